"""Lagrange polynomials of any degree on the reference triangle, nodes in VTK's order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["LagrangeTriangle"]

Array = NDArray[np.float64]


def _vtk_nodes(order: int) -> Array:
    """Return the equidistant nodes (n, 2): corners (0,0), (1,0), (0,1), edges 01, 12, 20, inside.

    The inside of a triangle of degree k is ordered as a triangle of degree k - 3.
    """
    corners = np.array([[0, 0], [order, 0], [0, order]])
    if order == 0:
        return np.zeros((1, 2))
    nodes = [corners]
    steps = np.arange(1, order)[:, None]
    for first, last in ((0, 1), (1, 2), (2, 0)):
        nodes.append(corners[first] + steps * (corners[last] - corners[first]) // order)
    points = np.vstack(nodes).astype(float)
    if order >= 3:
        points = np.vstack([points, 1.0 + _vtk_nodes(order - 3) * max(order - 3, 1)])
    return points / order


class LagrangeTriangle:
    """Nodal basis of degree ``order`` on the triangle (0,0), (1,0), (0,1)."""

    def __init__(self, order: int) -> None:
        """Invert the Vandermonde matrix of the monomials once."""
        self.order = order
        self.nodes = _vtk_nodes(order)
        self._powers = [(i, j) for i in range(order + 1) for j in range(order + 1 - i)]
        self._coefficients = np.linalg.inv(self._monomials(self.nodes))

    def _monomials(self, at: Array) -> Array:
        x = at[:, :1] ** np.arange(self.order + 1)
        y = at[:, 1:] ** np.arange(self.order + 1)
        i, j = np.array(self._powers).T
        return x[:, i] * y[:, j]

    def evaluate(self, at: Array) -> tuple[Array, Array]:
        """Return values (n, n_local) and slopes (n, n_local, 2) at the points ``at`` (n, 2)."""
        degrees = np.arange(self.order + 1)
        x, y = at[:, :1] ** degrees, at[:, 1:] ** degrees
        dx, dy = np.zeros_like(x), np.zeros_like(y)
        dx[:, 1:], dy[:, 1:] = degrees[1:] * x[:, :-1], degrees[1:] * y[:, :-1]
        i, j = np.array(self._powers).T
        values = (x[:, i] * y[:, j]) @ self._coefficients
        slope_x = (dx[:, i] * y[:, j]) @ self._coefficients
        slope_y = (x[:, i] * dy[:, j]) @ self._coefficients
        return values, np.stack([slope_x, slope_y], axis=-1)

    def split(self) -> NDArray[np.int64]:
        """Return the ``order**2`` small triangles (n, 3) between the nodes, for drawing."""
        grid = np.rint(self.nodes * self.order).astype(int)
        number = {(int(i), int(j)): k for k, (i, j) in enumerate(grid)}
        small = []
        for i in range(self.order):
            for j in range(self.order - i):
                small.append((number[i, j], number[i + 1, j], number[i, j + 1]))
                if i + j < self.order - 1:
                    small.append((number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]))
        return np.array(small, dtype=np.int64)
