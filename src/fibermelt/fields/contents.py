"""What is in a file of another solver, as it stands there: no unit converted, nothing chosen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["Contents", "Reader"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Contents:
    """A flow as its file has it.

    Parameters
    ----------
    format : str
        Whose file it is, for a person.
    points : (n, 2 or 3) array
        Nodes, in the file's unit.
    arrays : dict
        Values at the nodes by name: (n,) or (n, c) arrays.
    cells : (m, 3 or 4) int array, optional
        Triangles or tetrahedra; None where the file has points only.
    file_cells : int
        Cells of the file, before they were split into those.
    units : dict
        Units that the file names, by array.
    length_unit : str
        That of the points; empty where the file names none.
    names_units : bool
        Whether files of this format name their units: one that does not is then asked for, while SI
        is assumed, and told, of formats that never do.
    axis : str
        "x" or "y" where the file says that its plane is turned about that axis.
    times : tuple of float
        Times that the file has, in its unit; empty of a steady flow.
    notes : tuple of str
        What was done to the data as they were read, in words.
    from_cells : frozenset of str
        Arrays that the file has at its cells, and that were taken to the nodes.
    """

    format: str
    points: Array
    arrays: Mapping[str, Array]
    cells: Index | None = None
    file_cells: int = 0
    units: Mapping[str, str] = field(default_factory=dict)
    length_unit: str = ""
    names_units: bool = False
    axis: str = ""
    times: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()
    from_cells: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Reader:
    """One format: how its files are known from their first bytes, and how they are read.

    Parameters
    ----------
    format : str
        Name for a person.
    knows : callable
        ``(path, first bytes) -> bool``; a folder has no bytes.
    read : callable
        ``(path, time step) -> Contents``; without a time step, the last one.
    """

    format: str
    knows: Callable[[Path, bytes], bool]
    read: Callable[[Path, float | None], Contents]
