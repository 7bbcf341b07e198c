"""
One fiber in simple shear
=========================

Its period, and what its surface sees: alone in the melt, in a cell, and in three dimensions. The
paper's Table 1 prints 38.75 s by Jeffery's formula and 39.53 s by finite elements.
"""

import matplotlib.pyplot as plt
import numpy as np

import fibermelt as fm

shear_rate, viscosity = 1.0, 817.0  # 1/s, Pa s
fiber = fm.Ellipse(half_length=42e-6, aspect_ratio=6.0)
alone = fm.unbounded_model("ellipse", fiber).response  # Jeffery, Eq. 23-25
confined = fm.solve_cell(fiber, domain_size=28.0).response  # as large as the paper's seems to be
spheroid = fm.unbounded_model("spheroid", fiber).response  # in three dimensions

turns = {
    name: fm.orbit(response, shear_rate, viscosity)
    for name, response in (("ellipse", alone), ("in its cell", confined), ("spheroid", spheroid))
}
for name, turn in turns.items():
    print(f"{name:12} {turn.period:7.3f} s  {turn.min_pressure / 1e3:8.3f} kPa at the lowest")

time = np.linspace(0.0, turns["ellipse"].period, 9)
angle = np.degrees(fm.tumble(alone, shear_rate, viscosity, time).angle)  # Fig. 8a
print("angle every eighth of a period:", *(f"{value:.0f}" for value in angle), "deg")

# %%
# A fiber lies along the flow most of the time and turns over in a moment. That is when its tips
# see the pressure fall, and rise: to ``mu gamma_dot (1 + r_e)`` for the ellipse, exactly.

fine = np.linspace(0.0, turns["ellipse"].period, 800)
figure, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
for name, response in (("ellipse", alone), ("spheroid", spheroid)):
    seen = fm.tumble(response, shear_rate, viscosity, fine)
    above.plot(fine, np.degrees(seen.angle), label=name)
    below.plot(fine, seen.lowest / 1e3, label=name)
above.set(ylabel="angle [deg]")
below.set(xlabel="time [s]", ylabel="lowest pressure [kPa]")
below.legend()
plt.show()
