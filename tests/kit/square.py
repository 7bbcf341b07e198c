"""A field on the unit square."""

from __future__ import annotations

import numpy as np

from fibermelt.flow.field import FlowField
from fibermelt.flow.lagrange import LagrangeTriangle


def square_field(order: int, n: int = 4, bend: float = 0.0) -> FlowField:
    """Return the unit square in 2 n^2 triangles, its nodes moved by a cubic ``bend``."""
    grid = np.linspace(0, 1, n + 1)
    corners = np.array([(x, y) for y in grid for x in grid])
    cells = []
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            cells += [(a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1)]
    nodes = LagrangeTriangle(order).nodes
    weights = np.column_stack([1 - nodes.sum(axis=1), nodes])
    loose = np.einsum("kc,tcd->tkd", weights, corners[np.array(cells)]).reshape(-1, 2)
    _, first, number = np.unique(
        np.round(loose * 1e9).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    points = loose[first]
    points = points + bend * np.column_stack([np.zeros(len(points)), points[:, 0] ** 3])
    x, y = points.T
    return FlowField(
        order=order,
        points=points,
        cells=number.reshape(len(cells), len(nodes)),
        velocity=np.column_stack([1 + y, 0 * x]),
        pressure=x - y,
        gradient=np.tile([[0.0, 1.0], [0.0, 0.0]], (len(points), 1, 1)),
        stream_function=y + y**2 / 2,
        viscosity=np.ones(len(points)),
        gradient_error=np.zeros(len(points)),
    )
