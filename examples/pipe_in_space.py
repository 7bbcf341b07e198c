"""
Spheroids in a pipe
===================

A flow in space, read from a VTK file: paths of equal flux from its inflow, spheroids that turn out
of any plane on them, and the lowest pressure on these. Of the flow in a pipe all of it is known.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista

import fibermelt as fm
from fibermelt.fiber import equal_area_directions, follow_spatial, spatial_bounds, spatial_pressure
from fibermelt.fields import paths

radius, length, speed, viscosity = 0.5e-3, 2e-3, 20e-3, 817.0  # m, m, m/s on the mean, Pa s
side = np.linspace(-1, 1, 17)
x, a, b = np.meshgrid(np.linspace(0, length, 9), side, side, indexing="ij")
y, z = radius * a * np.sqrt(1 - b**2 / 2), radius * b * np.sqrt(1 - a**2 / 2)  # square onto disk
grid = pyvista.StructuredGrid(x, y, z).cast_to_unstructured_grid()
x, y, z = grid.points.T
u = 2 * speed * (1 - (y**2 + z**2) / radius**2)
grid["U"] = np.column_stack([u, 0 * u, 0 * u])
grid["p"] = 8 * viscosity * speed / radius**2 * (length - x)
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "pipe.vtu")
    grid.save(file)
    field = fm.read_field(file)
print(*field.notes, sep="\n")

# %%
# Each path stands for the same flux: they lie close where the melt is fast.

seeds = paths.flux_seeds(field, paths.inflow_section(field), 40)
print(f"{seeds.flux * 1e9:.3f} mm3/s enter, {np.pi * radius**2 * speed * 1e9:.3f} in a round pipe")
lines = paths.trace_field(field, seeds, points=800)
distance = np.array([np.hypot(*line.history.position[0, 1:]) for line in lines])

# %%
# On each path twenty spheroids start in all directions. The lowest pressure that any direction
# sees is at the tips of a fiber that is being stretched the most, at 45 degrees:
# ``-mu gamma_dot beta_0 (r_e^2 - 1) / (r_e^2 alpha_0 - beta_0)`` by Jeffery's integrals.

ratio = 6.0
spheroid = fm.unbounded_model("spheroid", fm.Ellipse(42e-6, aspect_ratio=ratio)).spheroid
starts = equal_area_directions(20)
bound, met = np.empty(len(lines)), np.empty((len(lines), len(starts)))
for k, line in enumerate(lines):
    motion = follow_spatial(line.history, spheroid.shape_factor, starts)
    met[k] = spatial_pressure(line.history, spheroid, viscosity, motion).lowest.min(axis=1)
    bound[k] = spatial_bounds(line.history, spheroid, viscosity).lowest.min()

e = np.sqrt(ratio**2 - 1)
alpha = 2 / e**2 * (np.arccosh(ratio) / e - 1 / ratio)
beta = 1 / ratio - alpha / 2
factor = beta * e**2 / (ratio**2 * alpha - beta)
exact = -viscosity * 4 * speed * distance / radius**2 * factor
off = np.abs(bound - exact).max() / np.abs(exact).max()
print(f"{bound.min() / 1e3:.1f} kPa below the melt's at the lowest; off by {off:.0e} of it")

figure, (left, right) = plt.subplots(1, 2, layout="constrained", figsize=(9, 4))
place = 1e3 * np.array([line.history.position[0, 1:] for line in lines])
dots = left.scatter(*place.T, c=met.min(axis=1) / 1e3)
left.add_patch(plt.Circle((0, 0), 1e3 * radius, fill=False))
left.set(xlabel="y [mm]", ylabel="z [mm]", aspect="equal")
figure.colorbar(dots, ax=left, label="lowest pressure met [kPa]")
far = np.array([0, radius])
steepest = -4 * viscosity * speed * factor / radius
right.plot(1e3 * far, [0, steepest / 1e3], "k", label="any direction, exactly")
right.plot(1e3 * distance, bound / 1e3, "o", mfc="none", label="any direction")
right.plot(1e3 * distance, met / 1e3, "C1.", ms=2)
right.set(xlabel="distance from the axis [mm]", ylabel="lowest pressure [kPa]")
right.legend()
plt.show()
