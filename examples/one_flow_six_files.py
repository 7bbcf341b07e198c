"""
One flow in six files
=====================

What six solvers export of the same melt in a slit, in their own words and units, and what becomes
of it: the gradient, the pressure and half a turn of a fiber, each beside the exact one.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyvista

import fibermelt as fm
from fibermelt.fields import paths

height, length, speed, viscosity = 1e-3, 20e-3, 0.05, 817.0  # m, m, m/s at the most, Pa s
rows, columns = 21, 101
x, y = (
    a.ravel() for a in np.meshgrid(np.linspace(0, length, columns), np.linspace(0, height, rows))
)
u = 4 * speed * y / height * (1 - y / height)
p = 8 * viscosity * speed / height**2 * (length - x)
first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
corners = np.stack([first, first + 1, first + columns + 1, first + columns], axis=-1)
triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
zero = 0 * u


def table(*columns, between=" "):
    """Return numbers as lines."""
    return "\n".join(between.join(f"{v:.9g}" for v in row) for row in np.column_stack(columns))


def comsol(*more):
    """Return the head of COMSOL's files."""
    lines = ["Model: slit.mph", "Version: COMSOL 6.2.0.290", "Dimension: 2", f"Nodes: {len(x)}"]
    return "".join(f"% {line}\n" for line in (*lines, *more, "Length unit: mm"))


# %%
# Fluent names no units, and none but CFD-Post (of a plane), COMSOL's sections and VTK say which
# points belong together.

number = np.arange(1, len(x) + 1)
joined = "\n".join(", ".join(map(str, cell)) for cell in triangles)
elements = "\n".join(" ".join(map(str, cell)) for cell in triangles + 1)
files = {
    "Fluent": "nodenumber, x-coordinate, y-coordinate, pressure, x-velocity, y-velocity\n"
    + table(number, x, y, p, u, zero, between=", "),
    "CFD-Post": "\n[Name]\nPlane 1\n\n[Data]\nX [ mm ], Y [ mm ], Z [ mm ], Pressure [ MPa ], "
    "Velocity u [ mm s^-1 ], Velocity v [ mm s^-1 ], Velocity w [ mm s^-1 ]\n"
    + table(1e3 * x, 1e3 * y, zero, 1e-6 * p, 1e3 * u, zero, zero, between=", ")
    + f"\n\n[Faces]\n{joined}\n",
    "STAR-CCM+": '"Pressure (Pa)","Velocity[i] (m/s)","Velocity[j] (m/s)","Velocity[k] (m/s)",'
    '"X (m)","Y (m)","Z (m)"\n' + table(p, u, zero, zero, x, y, zero, between=","),
    "COMSOL, spreadsheet": comsol("Expressions: 3")
    + "% x                       y                        u (mm/s)                 "
    "v (mm/s)                 p (MPa)\n" + table(1e3 * x, 1e3 * y, 1e3 * u, zero, 1e-6 * p),
    "COMSOL, sections": comsol(f"Elements: {len(triangles)}", "Expressions: 3")
    + f"% Coordinates\n{table(1e3 * x, 1e3 * y)}\n% Elements (triangles)\n{elements}\n"
    + f"% Data (u (mm/s))\n{table(1e3 * u)}\n% Data (v (mm/s))\n{table(zero)}\n"
    + f"% Data (p (MPa))\n{table(1e-6 * p)}\n",
}
grid = pyvista.UnstructuredGrid(
    {pyvista.CellType.TRIANGLE: triangles}, np.column_stack([x, y, zero])
)
grid["U"], grid["p"] = np.column_stack([u, zero, zero]), p
fields = {}
with tempfile.TemporaryDirectory() as folder:
    for name, text in files.items():
        file = Path(folder, "export")  # the name says nothing: the first bytes do
        file.write_text(text)
        fields[name] = fm.read_field(file)
    file = Path(folder, "export.vtu")
    grid.save(file)
    fields["VTK"] = fm.read_field(file)

# %%
# The same fiber in each: it starts across the flow, a quarter of the height above the wall.

start = [0.1e-3, height / 4]
response = fm.unbounded_model("ellipse", fm.Ellipse(42e-6, aspect_ratio=6.0)).response
rate = 2 * speed / height  # there
half_turn, deepest = np.pi * (6 + 1 / 6) / rate, -viscosity * rate * (1 + 6)
errors, turns = {}, {}
for name, field in fields.items():
    slope = 4 * speed / height * (1 - 2 * field.points[:, 1] / height)
    (line,) = paths.trace_field(field, paths.point_seeds(field, [start]))
    history = line.history
    motion = fm.follow(history, response.shape_factor, np.radians([90.0]))
    lowest = fm.surface_pressure(history, response, viscosity, motion).lowest[0]
    turns[name] = history.time, motion.angle[0], lowest
    pressure = 8 * viscosity * speed / height**2 * (length - history.position[:, 0])
    errors[name] = (
        np.abs(field.gradient[:, 0, 1] - slope).max() / slope.max(),
        np.abs(history.pressure - pressure).max() / p.max(),
        np.interp(np.pi, np.pi / 2 - motion.angle[0], history.time) / half_turn - 1,
        lowest.min() / deepest - 1,
    )
print(f"{'':20}{'gradient':>10}{'pressure':>10}{'half turn':>11}{'lowest':>10}")
for name, (gradient, pressure, turn, lowest) in errors.items():
    print(f"{name:20}{gradient:10.0e}{pressure:10.0e}{turn:11.0e}{lowest:10.0e}")

figure, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
for k, (name, (time, angle, lowest)) in enumerate(turns.items()):
    some = slice(25 * k, None, 150)
    above.plot(time[some], np.degrees(angle[some]), ".", label=name)
    below.plot(time[some], lowest[some] / 1e3, ".")
above.plot(time, np.degrees(angle), "k", lw=0.5)
below.plot(time, lowest / 1e3, "k", lw=0.5)
above.set(ylabel="angle [deg]")
below.set(xlabel="time [s]", ylabel="lowest pressure [kPa]")
figure.legend(loc="outside upper center", ncols=3)
plt.show()
