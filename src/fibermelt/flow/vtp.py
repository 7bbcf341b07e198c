"""Lines as VTK polygonal data, for ParaView."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.vtu import HEADER, data_array

__all__ = ["Named", "polylines"]

Named = tuple[NDArray[np.generic], Sequence[str]]
"""Values, (..., ) or (..., k), and what their components are called; none by numbers."""


def polylines(
    points: NDArray[np.float64], at_points: Mapping[str, Named], of_lines: Mapping[str, Named]
) -> bytes:
    """Return lines of equal length as a ``.vtp`` file.

    Parameters
    ----------
    points : (m, n, 3) array
        The points of each line.
    at_points : mapping
        Values (m, n) or (m, n, k) at them, by name.
    of_lines : mapping
        Values (m,) or (m, k) of each line, by name.
    """
    count, length = points.shape[:2]
    vertices = np.arange(count * length, dtype=np.int64)
    ends = length * np.arange(1, count + 1, dtype=np.int64)
    over = [
        data_array(name, values.reshape(count * length, *values.shape[2:]), called)
        for name, (values, called) in at_points.items()
    ]
    lines = [
        '<?xml version="1.0"?>',
        f'<VTKFile type="PolyData" {HEADER}><PolyData>',
        f'<Piece NumberOfPoints="{count * length}" NumberOfVerts="0" NumberOfLines="{count}" '
        'NumberOfStrips="0" NumberOfPolys="0">',
        "<PointData>",
        *over,
        "</PointData><CellData>",
        *(data_array(name, values, called) for name, (values, called) in of_lines.items()),
        "</CellData><Points>",
        data_array("points", points.reshape(-1, 3)),
        "</Points><Lines>",
        data_array("connectivity", vertices),
        data_array("offsets", ends),
        "</Lines></Piece></PolyData></VTKFile>",
    ]
    return "\n".join(lines).encode("utf-8")
