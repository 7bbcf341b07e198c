"""
A fiber in another solver's flow
================================

A solver's text export becomes a field: names and units are found in it, the velocity gradient is
recovered. Here the export is written first, as COMSOL has it, of a melt sheared between plates and
driven by a pressure: the flow, its gradient and the turning of a fiber in it are known.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fibermelt as fm

height, speed, bulge = 2.0, 100.0, 30.0  # mm, mm/s: the plate's, and what the pressure adds
x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 40, 81), np.linspace(0, height, 21)))
across = y / height
u = speed * across + 4 * bulge * across * (1 - across)
p = 8e-6 * 817.0 * bulge / height**2 * (40 - x)  # MPa
heading = "".join(f"{name:<25}" for name in ("% x", "y", "u (mm/s)", "v (mm/s)", "p (MPa)"))
rows = np.column_stack([x, y, u, 0 * u, p])
head = "% Model:              plates.mph\n% Dimension:          2\n% Length unit:        mm"
text = f"{head}\n{heading}\n" + "\n".join(" ".join(f"{value:.9g}" for value in row) for row in rows)

# %%
# The reader goes by what is in a file, not by its name. What it did is in the notes.

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "plates.txt")
    file.write_text(text)
    field = fm.read_field(file)
print(*field.notes, sep="\n")
slope = (speed + 4 * bulge * (1 - 2e3 * field.points[:, 1] / height)) / height
off = np.abs(field.gradient[:, 0, 1] - slope).max() / slope.max()
print(f"gradients are off by {off:.0e} of the largest")

# %%
# A line across the middle is a path; the fiber on it turns as Jeffery says, half a turn in
# ``pi (r_e + 1 / r_e) / rate``.

along = np.column_stack([np.linspace(1e-3, 39e-3, 2001), np.full(2001, 1e-3)])
place = field.locate(along)
velocity = field.velocity_at(place)[:, :2]
history = fm.FlowHistory(
    time=(along[:, 0] - along[0, 0]) / velocity[0, 0],
    position=along,
    velocity=velocity,
    gradient=field.evaluate(field.gradient, place)[:, :2, :2],
    pressure=field.evaluate(field.pressure, place),
)
response = fm.unbounded_model("ellipse", fm.Ellipse(42e-6, aspect_ratio=6.0)).response
motion = fm.follow(history, response.shape_factor, np.radians([90.0]))
pressure = fm.surface_pressure(history, response, 817.0, motion)
rate = speed / height
half_turn = np.interp(np.pi, np.pi / 2 - motion.angle[0], history.time)
exact = np.pi * (6.0 + 1 / 6.0) / rate
print(f"half a turn in {half_turn:.5f} s, exactly {exact:.5f} s")

figure, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
above.plot(1e3 * along[:, 0], np.degrees(motion.angle[0]))
above.set(ylabel="angle [deg]")
below.plot(1e3 * along[:, 0], (history.pressure + pressure.lowest[0]) / 1e3)
below.set(xlabel="x [mm]", ylabel="lowest pressure [kPa]")
plt.show()
