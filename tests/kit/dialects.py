"""Exact flows as files of other solvers: what readers are tested on, at any resolution.

Each writer takes a folder and a `Sample` and returns the file; layouts are those of the solvers'
own exports.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pyvista
from exact_flows import ExactFlow, Mesh, embedded
from numpy.typing import NDArray

Array = NDArray[np.float64]

AXES = "xyz"


@dataclass(frozen=True)
class Sample:
    """A flow's values at the nodes of a mesh, in the units that a file is to have."""

    mesh: Mesh
    velocity: Array
    pressure: Array

    @property
    def width(self) -> int:
        return self.mesh.points.shape[1]


def sample(
    flow: ExactFlow, n: int, *, length: float = 1.0, speed: float = 1.0, pressure: float = 1.0
) -> Sample:
    """Return a flow on its mesh, its numbers divided by these units in SI."""
    mesh = flow.mesh(n)
    x = embedded(mesh.points)
    return Sample(
        Mesh(mesh.points / length, mesh.cells),
        flow.velocity(x)[:, : mesh.points.shape[1]] / speed,
        flow.pressure(x) / pressure,
    )


def _rows(*columns: Array, between: str = " ") -> str:
    table = np.column_stack(columns)
    return "\n".join(between.join(f"{value:.12e}" for value in row) for row in table) + "\n"


def fluent(folder: Path, data: Sample, *, between: str = ",") -> Path:
    """Write Fluent's ASCII export: nodes with commas, or blanks."""
    axes = AXES[: data.width]
    names = ["nodenumber", *(f"{a}-coordinate" for a in axes), "pressure"]
    names += [f"{a}-velocity" for a in axes]
    number = np.arange(1, len(data.mesh.points) + 1)
    path = folder / "export"  # Fluent gives it no suffix
    head = (between + " ").join(f"{name:>15}" for name in names)
    body = _rows(number, data.mesh.points, data.pressure, data.velocity, between=between)
    path.write_text(f"{head}\n{body}")
    return path


def cfdpost(
    folder: Path, data: Sample, *, units: tuple[str, str, str] = ("m", "m s^-1", "Pa")
) -> Path:
    """Write CFD-Post's CSV, with faces of a plane; in space it has points only."""
    length, speed, stress = units
    names = [f"{axis} [ {length} ]" for axis in "XYZ"]
    names += [f"Pressure [ {stress} ]", f"Velocity [ {speed} ]"]
    names += [f"Velocity {letter} [ {speed} ]" for letter in "uvw"]
    u = embedded(data.velocity)
    columns = [embedded(data.mesh.points), data.pressure, np.linalg.norm(u, axis=1), u]
    text = "\n[Name]\nPlane 1\n\n[Data]\n" + ", ".join(names) + "\n" + _rows(*columns, between=", ")
    if data.width == 2:
        faces = "\n".join(", ".join(map(str, cell)) for cell in data.mesh.cells)
        text += f"\n[Faces]\n{faces}\n"
    path = folder / "export.csv"
    path.write_text(text)
    return path


def starccm(folder: Path, data: Sample) -> Path:
    """Write STAR-CCM+'s XYZ internal table."""
    names = ["Pressure (Pa)", *(f"Velocity[{i}] (m/s)" for i in "ijk")]
    names += [f"{axis} (m)" for axis in "XYZ"]
    head = ",".join(f'"{name}"' for name in names)
    columns = [data.pressure, embedded(data.velocity), embedded(data.mesh.points)]
    path = folder / "XYZ_Internal_Table_table.csv"
    path.write_text(head + "\n" + _rows(*columns, between=","))
    return path


def _comsol_head(data: Sample, unit: str, **more: str) -> str:
    lines = {
        "Model": "nozzle.mph",
        "Version": "COMSOL 6.2.0.290",
        "Date": "Jan 5 2026, 10:00",
        "Dimension": str(data.width),
        "Nodes": str(len(data.mesh.points)),
        **more,
        "Description": "Velocity field, x-component, Velocity field, y-component, Pressure",
        "Length unit": unit,
    }
    return "".join(f"% {key + ':':19} {value}\n" for key, value in lines.items())


def spreadsheet(
    folder: Path,
    data: Sample,
    *,
    units: tuple[str, str, str] = ("m", "m/s", "Pa"),
    axes: str = AXES,
    letters: str = "uvw",
) -> Path:
    """Write COMSOL's spreadsheet: a line for each node."""
    length, speed, stress = units
    names = [
        *axes[: data.width],
        *(f"{u} ({speed})" for u in letters[: data.width]),
        f"p ({stress})",
    ]
    head = _comsol_head(data, length, Expressions=str(data.width + 1))
    heading = "% " + "".join(f"{name:<25}" for name in names)
    path = folder / "export.txt"
    path.write_text(f"{head}{heading}\n" + _rows(data.mesh.points, data.velocity, data.pressure))
    return path


def sectionwise(
    folder: Path, data: Sample, *, units: tuple[str, str, str] = ("m", "m/s", "Pa")
) -> Path:
    """Write COMSOL's sectionwise export: coordinates, elements from 1, each expression."""
    length, speed, stress = units
    kind = "triangles" if data.width == 2 else "tetrahedra"
    more = {"Elements": str(len(data.mesh.cells)), "Expressions": str(data.width + 1)}
    elements = "\n".join(" ".join(map(str, cell)) for cell in data.mesh.cells + 1)
    text = _comsol_head(data, length, **more) + "% Coordinates\n" + _rows(data.mesh.points)
    text += f"% Elements ({kind})\n{elements}\n"
    for letter, column in zip("uvw", data.velocity.T, strict=False):
        text += f"% Data ({letter} ({speed}))\n{_rows(column)}"
    text += f"% Data (p ({stress}))\n{_rows(data.pressure)}"
    path = folder / "sections.txt"
    path.write_text(text)
    return path


def vtu(folder: Path, data: Sample, *, name: str = "export.vtu", **arrays: Array) -> Path:
    """Write VTK's unstructured grid, by pyvista."""
    kind = pyvista.CellType.TRIANGLE if data.width == 2 else pyvista.CellType.TETRA
    grid = pyvista.UnstructuredGrid({kind: data.mesh.cells}, embedded(data.mesh.points))
    grid.point_data["U"] = embedded(data.velocity)
    grid.point_data["p"] = data.pressure
    for key, values in arrays.items():
        grid.point_data[key] = values
    path = folder / name
    grid.save(path)
    return path


def _foam(kind: str, name: str, body: str) -> str:
    head = f"version 2.0; format ascii; class {kind}; object {name};"
    return f"FoamFile {{ {head} }}\n{body}\n"


def _foam_list(rows: Array) -> str:
    """Return rows as OpenFOAM's list: vectors in parentheses."""
    items = [
        f"({' '.join(f'{v:.12g}' for v in row)})" if np.ndim(row) else f"{row:.12g}" for row in rows
    ]
    return f"{len(items)}\n(\n" + "\n".join(items) + "\n)"


def openfoam(
    folder: Path,
    flow: ExactFlow,
    shape: tuple[int, int, int],
    *,
    over: float = 1.0,
    wall: str = "type zeroGradient;",
) -> Path:
    """Write an OpenFOAM case of a unit cube in bricks, with values at their centres at two times.

    ``over`` divides the pressure, which then is one over density. One brick in z is a plane.
    ``wall`` is the velocity's condition on all sides.
    """
    count = tuple(n + 1 for n in shape)
    axes = [np.linspace(0, 1, n) for n in count]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    node, cell = np.arange(np.prod(count)).reshape(count), np.arange(np.prod(shape)).reshape(shape)
    inner, outer = [], []
    for axis in range(3):
        # a face across an axis, its corners in the order of a right-handed turn
        b, c = [(1, 2), (2, 0), (0, 1)][axis]
        for place in np.ndindex(*(n + (k == axis) for k, n in enumerate(shape))):
            corners = []
            for step_b, step_c in ((0, 0), (1, 0), (1, 1), (0, 1)):
                where = list(place)
                where[b] += step_b
                where[c] += step_c
                corners.append(int(node[tuple(where)]))
            below = list(place)
            below[axis] -= 1
            if 0 < place[axis] < shape[axis]:
                inner.append((int(cell[tuple(below)]), int(cell[place]), corners))
            elif place[axis] == 0:
                outer.append((int(cell[place]), corners[::-1]))
            else:
                outer.append((int(cell[tuple(below)]), corners))
    inner.sort(key=lambda face: face[:2])
    faces = [face[-1] for face in (*inner, *outer)]
    mesh = folder / "constant" / "polyMesh"
    mesh.mkdir(parents=True)
    (folder / "system").mkdir()
    control = "application icoFoam; startTime 0; endTime 1; deltaT 0.5; writeFormat ascii;"
    (folder / "system" / "controlDict").write_text(_foam("dictionary", "controlDict", control))
    patch = f"1 ( walls {{ type wall; nFaces {len(outer)}; startFace {len(inner)}; }} )"
    texts = {
        "points": ("vectorField", _foam_list(points)),
        "faces": (
            "faceList",
            f"{len(faces)}\n(\n" + "\n".join(f"4({' '.join(map(str, f))})" for f in faces) + "\n)",
        ),
        "owner": ("labelList", _foam_list(np.array([f[0] for f in (*inner, *outer)]))),
        "neighbour": ("labelList", _foam_list(np.array([f[1] for f in inner]))),
        "boundary": ("polyBoundaryMesh", patch),
    }
    for name, (kind, body) in texts.items():
        (mesh / name).write_text(_foam(kind, name, body))
    centres = [axis[:-1] + np.diff(axis) / 2 for axis in axes]
    x = np.stack(np.meshgrid(*centres, indexing="ij"), axis=-1).reshape(-1, 3)
    for time, factor in (("0.5", 0.5), ("1", 1.0)):
        (folder / time).mkdir()
        stress = "[1 -1 -2 0 0 0 0]" if over == 1.0 else "[0 2 -2 0 0 0 0]"
        for name, kind, values, units in (
            ("U", "vector", factor * flow.velocity(x), "[0 1 -1 0 0 0 0]"),
            ("p", "scalar", flow.pressure(x) / over, stress),
        ):
            listed = f"nonuniform List<{kind}> {_foam_list(values)}"
            body = f"dimensions {units};\ninternalField {listed};\n"
            condition = wall if name == "U" else "type zeroGradient;"
            body += f"boundaryField {{ walls {{ {condition} }} }}"
            kind_of = f"vol{kind.capitalize()}Field"
            (folder / time / name).write_text(_foam(kind_of, name, body))
    return folder


def cgns(folder: Path, data: Sample) -> Path:
    """Write CGNS on HDF5: one zone of tetrahedra, values at vertices."""
    path = folder / "export.cgns"
    tags = {"R4": np.float32, "R8": np.float64, "I4": np.int32, "C1": np.int8}

    def text(value: str, size: int) -> np.ndarray:
        return np.bytes_(value.encode().ljust(size, b"\0"))

    def node(
        parent: h5py.Group, name: str, label: str, kind: str = "MT", values=None
    ) -> h5py.Group:
        group = parent.create_group(name, track_order=True)
        for key, value, size in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
            group.attrs.create(key, text(value, size), dtype=f"S{size}")
        group.attrs["flags"] = np.array([1], dtype=np.int32)
        if values is not None:
            if isinstance(values, str):
                values = np.frombuffer(values.encode(), dtype=np.int8)
            group.create_dataset(" data", data=np.asarray(values, dtype=tags[kind]))
        return group

    with h5py.File(path, "w", track_order=True, libver=("earliest", "v108")) as file:
        for key, value, size in (
            ("name", "HDF5 MotherNode", 33),
            ("label", "Root Node of HDF5 File", 33),
            ("type", "MT", 3),
        ):
            file.attrs.create(key, text(value, size), dtype=f"S{size}")
        form = np.frombuffer(b"IEEE_LITTLE_32\0", dtype=np.int8)
        file.create_dataset(" format", data=form)
        version = np.frombuffer(b"HDF5 Version 1.8.15".ljust(33, b"\0"), dtype=np.int8)
        file.create_dataset(" hdf5version", data=version)
        node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", "R4", [3.3])
        base = node(file, "Base", "CGNSBase_t", "I4", [3, 3])
        n, m = len(data.mesh.points), len(data.mesh.cells)
        zone = node(base, "Zone", "Zone_t", "I4", [[n], [m], [0]])
        node(zone, "ZoneType", "ZoneType_t", "C1", "Unstructured")
        grid = node(zone, "GridCoordinates", "GridCoordinates_t")
        for axis, column in zip("XYZ", data.mesh.points.T, strict=True):
            node(grid, f"Coordinate{axis}", "DataArray_t", "R8", column)
        cells = node(zone, "Elements", "Elements_t", "I4", [10, 0])
        node(cells, "ElementRange", "IndexRange_t", "I4", [1, m])
        node(cells, "ElementConnectivity", "DataArray_t", "I4", data.mesh.cells.ravel() + 1)
        flow = node(zone, "FlowSolution", "FlowSolution_t")
        node(flow, "GridLocation", "GridLocation_t", "C1", "Vertex")
        for axis, column in zip("XYZ", data.velocity.T, strict=True):
            node(flow, f"Velocity{axis}", "DataArray_t", "R8", column)
        node(flow, "Pressure", "DataArray_t", "R8", data.pressure)
    return path


DIALECTS: dict[str, Callable[[Path, Sample], Path]] = {
    "fluent": fluent,
    "cfdpost": cfdpost,
    "starccm": starccm,
    "spreadsheet": spreadsheet,
    "sectionwise": sectionwise,
    "vtu": vtu,
}
"""All of them, by name."""

JOINED = frozenset({"fluent", "starccm", "spreadsheet"})
"""Those without connectivity; CFD-Post's, in space."""
