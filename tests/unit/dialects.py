"""Exact flows as files of other solvers: what readers are tested on, at any resolution.

Each writer takes a folder and a `Sample` and returns the file; layouts are those of the solvers'
own exports.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

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
