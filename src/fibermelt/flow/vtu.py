"""The flow as a VTK unstructured grid of Lagrange triangles, for ParaView."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import refuse_other
from fibermelt.flow.field import FlowField

__all__ = ["write_vtu"]

LAGRANGE_TRIANGLE = 69
"""VTK's cell type: a triangle of any degree, its nodes in `FlowField`'s order."""

TYPES = {"float64": "Float64", "int64": "Int64", "uint8": "UInt8"}


def _array(name: str, values: NDArray[np.generic]) -> str:
    """Return a DataArray element, its values as base64 after their length in bytes (UInt64)."""
    data = np.ascontiguousarray(values)
    payload = base64.b64encode(np.uint64(data.nbytes).tobytes() + data.tobytes()).decode()
    width = f' NumberOfComponents="{values[0].size}"' if values.ndim > 1 else ""
    kind = TYPES[data.dtype.name]
    return f'<DataArray type="{kind}" Name="{name}"{width} format="binary">{payload}</DataArray>'


def _spatial(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return planar vectors (n, 2) with a zero third component: VTK knows three dimensions."""
    return np.column_stack([vectors, np.zeros(len(vectors))])


def write_vtu(field: FlowField, path: str | Path) -> None:
    """Write the field to ``path``: velocity, pressure, gradient, viscosity and the rest, in SI.

    The gradient's nine components are those of ``L`` embedded in space, row by row.

    Raises
    ------
    ConfigError
        If the field is none.
    """
    refuse_other("field", field, FlowField)
    n_cells, n_local = field.cells.shape
    gradient = np.zeros((len(field.points), 3, 3))
    gradient[:, :2, :2] = field.gradient
    point_data = [
        _array("velocity", _spatial(field.velocity)),
        _array("pressure", field.pressure),
        _array("velocity_gradient", gradient.reshape(-1, 9)),
        _array("shear_rate", field.shear_rate),
        _array("viscosity", field.viscosity),
        _array("stream_function", field.stream_function),
        _array("velocity_gradient_error", field.gradient_error),
    ]
    cells = [
        _array("connectivity", field.cells.reshape(-1).astype(np.int64)),
        _array("offsets", n_local * np.arange(1, n_cells + 1, dtype=np.int64)),
        _array("types", np.full(n_cells, LAGRANGE_TRIANGLE, dtype=np.uint8)),
    ]
    lines = [
        '<?xml version="1.0"?>',
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64"><UnstructuredGrid>',
        f'<Piece NumberOfPoints="{len(field.points)}" NumberOfCells="{n_cells}">',
        '<PointData Scalars="pressure" Vectors="velocity">',
        *point_data,
        "</PointData><Points>",
        _array("points", _spatial(field.points)),
        "</Points><Cells>",
        *cells,
        "</Cells></Piece></UnstructuredGrid></VTKFile>",
    ]
    Path(path).write_text("\n".join(lines), encoding="ascii")
