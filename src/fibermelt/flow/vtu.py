"""The flow as a VTK unstructured grid of Lagrange triangles or tetrahedra, for ParaView."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import refuse_other
from fibermelt.flow.field import FlowField

if TYPE_CHECKING:
    from fibermelt.flow.space.field import BeadField

__all__ = ["HEADER", "data_array", "spatial", "write_vtu"]

LAGRANGE_TRIANGLE, LAGRANGE_TETRAHEDRON = 69, 71
"""VTK's cell types: of any degree, nodes in the order of `FlowField` and of `BeadField`."""

TYPES = {"float64": "Float64", "int64": "Int64", "int8": "Int8", "uint8": "UInt8"}

HEADER = 'version="1.0" byte_order="LittleEndian" header_type="UInt64"'
"""What every VTK file of ours says of its arrays."""


def data_array(name: str, values: NDArray[np.generic], components: Sequence[str] = ()) -> str:
    """Return a DataArray element, its values as base64 after their length in bytes (UInt64).

    Parameters
    ----------
    name : str
        Its name.
    values : (n,) or (n, k) array
        Its values, of a type in `TYPES`.
    components : sequence of str
        What each of the k components is called; numbers by default.
    """
    data = np.ascontiguousarray(values)
    data = data.astype(data.dtype.newbyteorder("<"), copy=False)
    payload = base64.b64encode(np.uint64(data.nbytes).tobytes() + data.tobytes()).decode()
    width = f" NumberOfComponents={quoteattr(str(values[0].size))}" if values.ndim > 1 else ""
    width += "".join(f" ComponentName{k}={quoteattr(one)}" for k, one in enumerate(components))
    kind = TYPES[data.dtype.name]
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)}{width} format="binary">'
        f"{payload}</DataArray>"
    )


def spatial(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return planar vectors (n, 2) with a zero third component: VTK knows three dimensions."""
    return np.column_stack([vectors, np.zeros(len(vectors))])


def write_vtu(field: FlowField | BeadField, path: str | Path) -> None:
    """Write the field to ``path``: velocity, pressure, gradient, viscosity and the rest, in SI.

    The gradient's nine components are those of ``L`` in space, row by row. Of a bead in space it is
    the half that was solved, z >= 0: ParaView's Reflect has the other.

    Raises
    ------
    ConfigError
        If the field is none.
    """
    if isinstance(field, FlowField):
        gradient = np.zeros((len(field.points), 3, 3))
        gradient[:, :2, :2] = field.gradient
        points, velocity = spatial(field.points), spatial(field.velocity)
        own, kind = {"stream_function": field.stream_function}, LAGRANGE_TRIANGLE
    else:
        from fibermelt.flow.space.field import BeadField  # noqa: PLC0415  loads the finite elements

        refuse_other("field", field, BeadField)
        points, velocity, gradient = field.points, field.velocity, field.gradient
        own, kind = {"divergence": field.divergence}, LAGRANGE_TETRAHEDRON
    n_cells, n_local = field.cells.shape
    rate = gradient + gradient.swapaxes(1, 2)
    point_data = [
        data_array("velocity", velocity),
        data_array("pressure", field.pressure),
        data_array("velocity_gradient", gradient.reshape(-1, 9)),
        data_array("shear_rate", np.sqrt(0.5) * np.linalg.norm(rate, axis=(1, 2))),
        data_array("viscosity", field.viscosity),
        *(data_array(name, values) for name, values in own.items()),
        data_array("velocity_gradient_error", field.gradient_error),
    ]
    cells = [
        data_array("connectivity", field.cells.reshape(-1).astype(np.int64)),
        data_array("offsets", n_local * np.arange(1, n_cells + 1, dtype=np.int64)),
        data_array("types", np.full(n_cells, kind, dtype=np.uint8)),
    ]
    lines = [
        '<?xml version="1.0"?>',
        f'<VTKFile type="UnstructuredGrid" {HEADER}><UnstructuredGrid>',
        f'<Piece NumberOfPoints="{len(field.points)}" NumberOfCells="{n_cells}">',
        '<PointData Scalars="pressure" Vectors="velocity">',
        *point_data,
        "</PointData><Points>",
        data_array("points", points),
        "</Points><Cells>",
        *cells,
        "</Cells></Piece></UnstructuredGrid></VTKFile>",
    ]
    Path(path).write_text("\n".join(lines), encoding="ascii")
