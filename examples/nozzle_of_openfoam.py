"""
A nozzle of OpenFOAM
====================

A case's folder is read as it is: cells become nodes' values, walls and the inlet give theirs. Here
the case is written first, of a slit that tapers: melt creeps to the point where its walls would
meet, and flow and pressure are known.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fibermelt as fm
from fibermelt.fields import paths

half_angle, density, viscosity = np.radians(20), 1040.0, 817.0  # -, kg/m3, Pa s
inlet, outlet, thickness, flux = 4e-3, 1e-3, 0.2e-3, 20e-6  # m from the apex, m, m, m2/s
strength = flux / (np.sin(2 * half_angle) - 2 * half_angle * np.cos(2 * half_angle))


def exact(x):
    """Velocity and pressure of Jeffery and Hamel's flow, without inertia; the apex at x = 0."""
    r, angle = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], -x[:, 0])
    speed = strength * (np.cos(2 * angle) - np.cos(2 * half_angle)) / r
    velocity = -speed[:, None] * x / r[:, None] * [1, 1, 0]
    return velocity, -2 * viscosity * strength * np.cos(2 * angle) / r**2


# %%
# A mesh in OpenFOAM is a list of faces, each with the cell it leads out of and, inside, the one
# it leads into. One layer of cells between "empty" planes is a planar flow.


def foam(file, kind, body):
    """Write a file of a case."""
    file.parent.mkdir(parents=True, exist_ok=True)
    head = f"version 2.0; format ascii; class {kind}; object {file.name};"
    file.write_text(f"FoamFile {{ {head} }}\n{body}\n")


def listed(rows, before=""):
    """Return rows as OpenFOAM's list: vectors in parentheses, faces with their number before."""
    items = [f"{before}({' '.join(map(str, r))})" if np.ndim(r) else str(r) for r in rows]
    return f"{len(items)}\n(\n" + "\n".join(items) + "\n)"


def write_case(folder, points, shape):
    """Write a case of one layer of bricks, whose nodes ``points`` are in order."""
    node = np.arange(len(points)).reshape(*(n + 1 for n in shape))
    cell = np.arange(np.prod(shape)).reshape(shape)
    inner, outer = [], []
    for axis in range(3):
        order = (axis, (axis + 1) % 3, (axis + 2) % 3)
        n, c = node.transpose(order), cell.transpose(order)
        around = [n[:, :-1, :-1], n[:, 1:, :-1], n[:, 1:, 1:], n[:, :-1, 1:]]
        face = np.stack(around, axis=-1)  # seen along the axis, right-handed
        pairs = [c[:-1].ravel(), c[1:].ravel()]
        inner.append(np.column_stack([*pairs, face[1:-1].reshape(-1, 4)]))
        ends = ((c[0], face[0, ..., ::-1]), (c[-1], face[-1]))
        outer += [np.column_stack([c.ravel(), f.reshape(-1, 4)]) for c, f in ends]
    inner = np.concatenate(inner)
    inner = inner[np.lexsort(inner[:, 1::-1].T)]
    sides = {"inlet": outer[:1], "outlet": outer[1:2], "walls": outer[2:4], "planes": outer[4:]}
    kinds = {"walls": "wall", "planes": "empty"}
    patches, start = "", len(inner)
    for name, parts in sides.items():
        count, kind = sum(map(len, parts)), kinds.get(name, "patch")
        patches += f"{name} {{ type {kind}; nFaces {count}; startFace {start}; }}\n"
        start += count
    owner = np.concatenate([inner[:, 0], *(part[:, 0] for part in outer)])
    corners = np.concatenate([inner[:, 2:], *(part[:, 1:] for part in outer)])
    mesh = folder / "constant" / "polyMesh"
    foam(mesh / "points", "vectorField", listed(points))
    foam(mesh / "faces", "faceList", listed(corners, before=4))
    foam(mesh / "owner", "labelList", listed(owner))
    foam(mesh / "neighbour", "labelList", listed(inner[:, 1]))
    foam(mesh / "boundary", "polyBoundaryMesh", f"4\n(\n{patches})")
    control = "application simpleFoam; startTime 0; endTime 1; deltaT 1; writeFormat ascii;"
    foam(folder / "system" / "controlDict", "dictionary", control)

    middle = np.zeros((cell.size, 3))
    np.add.at(middle, owner, points[corners].mean(axis=1))
    np.add.at(middle, inner[:, 1], points[inner[:, 2:]].mean(axis=1))
    velocity, pressure = exact(middle / 6)  # a brick has six faces
    entering, _ = exact(points[outer[0][:, 1:]].mean(axis=1))
    rest = "planes { type empty; }"
    conditions = {
        "U": f"inlet {{ type fixedValue; value nonuniform List<vector> {listed(entering)}; }} "
        "outlet { type zeroGradient; } walls { type noSlip; }",
        "p": " ".join(f"{name} {{ type zeroGradient; }}" for name in ("inlet", "outlet", "walls")),
    }
    for name, kind, values, units in (
        ("U", "vector", velocity, "[0 1 -1 0 0 0 0]"),
        ("p", "scalar", pressure / density, "[0 2 -2 0 0 0 0]"),
    ):
        body = f"dimensions {units};\ninternalField nonuniform List<{kind}> {listed(values)};\n"
        body += f"boundaryField {{ {conditions[name]} {rest} }}"
        foam(folder / "1" / name, f"vol{kind.capitalize()}Field", body)


shape = (80, 40, 1)
r, angle, z = np.meshgrid(
    np.geomspace(inlet, outlet, shape[0] + 1),
    np.linspace(-half_angle, half_angle, shape[1] + 1),
    [0, thickness],
    indexing="ij",
)
nodes = np.stack([-r * np.cos(angle), r * np.sin(angle), z], axis=-1).reshape(-1, 3)
with tempfile.TemporaryDirectory() as folder:
    write_case(Path(folder), nodes, shape)
    # an incompressible solver has the pressure over the density
    field = fm.read_field(folder, fm.FieldMap(pressure_unit=f"{density} Pa"))
print(*field.notes, sep="\n")

# %%
# The melt goes straight to the apex. On the axis it is stretched at ``rate``; a fiber that lies
# along it has ``-2 mu rate (1 + r_e)`` at its tips. Off the axis it is sheared as well. Beside the
# inlet and the outlet cells lie on one side only: the gradient is worse there, as its estimated
# error tells, and left out of the comparison.

section = paths.inflow_section(field)
lines = paths.trace_field(field, paths.flux_seeds(field, section, 9))
print(f"{section.flux * 1e6:.3f} mm2/s enter, exactly {flux * 1e6:.3f}")
fiber = fm.Ellipse(42e-6, aspect_ratio=6.0)
response = fm.unbounded_model("ellipse", fiber).response
off, turned, lowest = [], [], []
for line in lines:
    history = line.history
    r = np.hypot(*history.position[:, :2].T)
    angle = np.arctan2(history.position[:, 1], -history.position[:, 0])
    turned.append(np.ptp(angle))
    stretch = strength * (np.cos(2 * angle) - np.cos(2 * half_angle)) / r**2
    worst = np.hypot(stretch, strength * np.sin(2 * angle) / r**2)
    bound = -2 * viscosity * (1 + fiber.aspect_ratio) * worst
    found = fm.pressure_bounds(history, response, viscosity).lowest
    inside = (r > 1.15 * outlet) & (r < 0.9 * inlet)
    off.append(np.abs(found / bound - 1)[inside].max())
    motion = fm.follow(history, response.shape_factor, fm.isotropic_angles(60))
    lowest.append(fm.surface_pressure(history, response, viscosity, motion).lowest.min())
print(f"paths turn by up to {np.degrees(max(turned)):.3f} deg; they should not")
print(f"bounds are off by up to {max(off):.2%}")

axis = lines[len(lines) // 2].history
motion = fm.follow(axis, response.shape_factor, [0.0])
pressure = axis.pressure + fm.surface_pressure(axis, response, viscosity, motion).lowest[0]
r = -axis.position[:, 0]
rate = strength * (1 - np.cos(2 * half_angle)) / r**2
known = -2 * viscosity * (strength / r**2 + rate * (1 + fiber.aspect_ratio))
figure, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
for line, value in zip(lines, lowest, strict=True):
    above.plot(*(1e3 * line.history.position[:, :2].T), "C0")
    above.annotate(f"{value / 1e3:.0f}", 1e3 * line.history.position[0, :2], ha="right")
above.set(
    xlim=(-4.5, -0.9),
    ylim=(-1.3, 1.3),
    ylabel="y [mm]",
    title="lowest pressure on fibers over the melt's [kPa]",
)
below.plot(-1e3 * r, known / 1e6, "k", label="exactly")
below.plot(-1e3 * r, pressure / 1e6, "C1--", label="in the field")
below.set(xlabel="x from the apex [mm]", ylabel="with the melt's, on the axis [MPa]")
below.legend()
plt.show()
