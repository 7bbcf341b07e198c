"""
From fiber content to the cell
==============================

The size of the cell that stands for a fiber content (the paper's section 2.5): that in which a
fiber stalls at the angle at which most fibers of the suspension lie. The paper has M = 4.08.
"""

import matplotlib.pyplot as plt
import numpy as np

import fibermelt as fm
from fibermelt.orientation.interaction import bay

content, aspect_ratio = 0.084, 6.0
interaction = bay(content, aspect_ratio)  # C_I
shear = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
xi = fm.unbounded_model("ellipse", fm.Ellipse(42e-6, aspect_ratio)).response.shape_factor

curve = fm.stall_curve(aspect_ratio)  # B(M) from a dozen cells, Fig. 14c
angles, sizes = {}, {}
for convention in ("standard", "paper"):
    model = fm.FolgarTucker(xi, interaction, convention=convention)  # Eq. 26
    steady = fm.steady_state(model, shear, fm.closure("ORE"))  # Eq. 27-28
    angles[convention] = steady.angle
    sizes[convention] = curve.domain_size_at(steady.angle)  # Fig. 15
    print(
        f"{convention:9} C_I = {interaction:.4f}: fibers lie at {steady.angle:.4f} rad, "
        f"a fiber stalls there in a cell of M = {sizes[convention]:.3f}"
    )

# %%
# The larger the cell, the flatter the fiber stalls; beyond a largest cell it tumbles. Which rate
# of deformation multiplies ``C_I`` decides where the fibers lie.

domain = np.linspace(2.5, curve.largest_stalling_domain, 200)
figure, axes = plt.subplots(layout="constrained")
axes.plot(domain, curve.stall_angle(domain), "k", label="stall angle of one fiber in its cell")
for convention, size in sizes.items():
    axes.plot(size, angles[convention], "o", label=f"most fibers, {convention} convention")
axes.set(xlabel="domain size M", ylabel="angle from the flow [rad]")
axes.legend()
plt.show()
