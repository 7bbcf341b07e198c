"""What OpenFOAM's case says beside the values of its cells: dimensions, and values on walls."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fibermelt.fields.contents import Contents

__all__ = ["case_folder", "with_case"]

Array = NDArray[np.float64]

GIVEN = frozenset({"fixedValue", "noSlip", "movingWallVelocity", "flowRateInletVelocity"})
"""Types of boundary conditions that give the value itself."""

SAME = 1e-6
"""Over the domain's size: distance of a patch's nodes from the mesh's; both have four bytes."""


def case_folder(path: Path) -> Path | None:
    """Return the case that a folder, its ``.foam`` file or ``controlDict`` stands for, if one."""
    folder = path if path.is_dir() else path.parent
    folder = folder.parent if folder.name == "system" else folder
    named = path.is_dir() or path.suffix == ".foam" or path.name == "controlDict"
    return folder if named and (folder / "system" / "controlDict").is_file() else None


def with_case(
    folder: Path, time: float, contents: Contents, patches: Mapping[str, Any]
) -> Contents:
    """Return the contents with what the case gives on its patches, and its pressure's dimension.

    Parameters
    ----------
    folder : Path
        The case.
    time : float
        The time that was read.
    contents : Contents
        Its cells' values, taken to the nodes.
    patches : dict
        By name, nodes and values at them of each patch: ``(points, {array: values})``.

    Notes
    -----
    Where a condition gives the value (a wall without slip, an inlet), nodes take it: what is led on
    to them from the cells has a melt slip at walls, by an error of second order. Patches of lower
    speed come last: where a wall meets an inlet, it is a wall.
    """
    there = [item for item in folder.iterdir() if _time_of(item) is not None]
    nearest = min(there, key=lambda item: abs((_time_of(item) or 0.0) - time), default=None)
    if nearest is None:
        return contents
    arrays = {name: values.copy() for name, values in contents.arrays.items()}
    given = []
    tree = cKDTree(contents.points)
    size = float(np.ptp(contents.points, axis=0).max())
    for name, values in arrays.items():
        file = nearest / name
        conditions = _conditions(file) if file.is_file() else {}
        found = [
            (points, at[name])
            for patch, (points, at) in patches.items()
            if conditions.get(patch) in GIVEN and name in at
        ]
        for points, new in sorted(found, key=lambda item: -float(np.abs(item[1]).mean())):
            away, node = tree.query(points)
            values[node[away <= SAME * size]] = new[away <= SAME * size]
        given += [name] * bool(found)
    units = dict(contents.units)
    if _is_over_density(nearest / "p"):
        units["p"] = "m^2/s^2"
    notes = contents.notes
    if given:
        notes = (*notes, f"nodes on patches that give it have the value there: {', '.join(given)}")
    return replace(contents, arrays=arrays, units=units, notes=notes)


def _time_of(folder: Path) -> float | None:
    try:
        return float(folder.name) if folder.is_dir() else None
    except ValueError:
        return None


def _conditions(file: Path) -> dict[str, str]:
    """Return the type of the condition on each patch in a field's file."""
    text = file.read_bytes().rpartition(b"boundaryField")[2].decode("latin-1")
    return dict(re.findall(r"\"?([\w.\-]+)\"?\s*\{\s*type\s+(\w+)\s*;", text))


def _is_over_density(file: Path) -> bool:
    """Return whether a field's dimension has no mass: OpenFOAM's incompressible pressure."""
    if not file.is_file():
        return False
    match = re.search(rb"dimensions\s*\[\s*(-?\d+)\s+", file.read_bytes()[:4096])
    return match is not None and match.group(1) == b"0"
