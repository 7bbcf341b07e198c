"""The paper's own mesh (its Fig. 6): 60 x 60 unit cells, 1800 quadratic triangles.

"A radial seed of 60-unit cells with a unidirectional geometric bias of 1.1 and circumferential seed
of 60-unit cells resulting in a total of 1800 triangular elements" is read like this:

- a unit cell is an interval between neighbouring nodes: 60 of them carry 30 quadratic elements, and
  30 x 30 quadrilaterals cut in two make 1800 triangles, six nodes each;
- the bias belongs to the seed, hence to the unit cells: each radial interval is 1.1 times the one
  before, finest at the fiber. A midside node then lies at 1/2.1 of its element's radial edge, and
  an element is 1.21 times the one before. (With a bias of 1.1 from element to element the first
  one outgrows the tip's radius of curvature in cells large enough to compare with Jeffery, and the
  period at ``r_e = 6`` is above Table 1's 39.53 s in every cell, whichever way diagonals run.)
- the nodes around are equally spaced in the eccentric angle, on straight lines from
  ``(a cos s, b sin s)`` to ``(R cos s, R sin s)``: rings are ellipses, and cannot fold;
- every quadrilateral is cut along the same diagonal. The mesh is then the same after half a turn
  but not in a mirror; its mirror image (the other diagonal) has the same ``B`` and tip pressures.

Pressure is linear on the triangles: its extremes on the surface lie at the 30 vertices there, and
these are the surface points of the response. Lengths are in units of the half-length ``a``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["BIAS", "PAPER_ORDER", "UNIT_CELLS", "PaperGrid"]

Array = NDArray[np.float64]

UNIT_CELLS = 60
"""Intervals between nodes, radially and around (section 2.2)."""

BIAS = 1.1
"""Each radial interval over the one before (section 2.2)."""

PAPER_ORDER = 2
"""Quadratic velocity and geometry; the pressure is linear."""


@dataclass(frozen=True)
class PaperGrid:
    """Where the nodes of the paper's mesh lie; columns and rows count as in `CellGrid`.

    Parameters
    ----------
    semi_minor : float
        ``b/a`` of the ellipse [-], at most one.
    radius : float
        ``R/a`` of the cell [-], above one.
    """

    semi_minor: float
    radius: float

    @property
    def columns(self) -> int:
        """Return the number of quadrilaterals around the fiber."""
        return UNIT_CELLS // PAPER_ORDER

    @property
    def rows(self) -> int:
        """Return the number of quadrilaterals between the fiber and the cell's edge."""
        return UNIT_CELLS // PAPER_ORDER

    @property
    def columns_per_quarter(self) -> float:
        """Return the number of columns in a quarter turn: the flanks are midside nodes."""
        return self.columns / 4.0

    def surface_angles(self) -> Array:
        """Return the eccentric angles of the surface's vertices [rad], (columns,)."""
        return 2.0 * np.pi * np.arange(self.columns) / self.columns

    def depths(self) -> Array:
        """Return the nodes' fractions of the way to the cell's edge [-], (61,)."""
        ends = np.concatenate([[0.0], np.cumsum(BIAS ** np.arange(UNIT_CELLS))])
        return np.asarray(ends / ends[-1])

    def nodes(self) -> Array:
        """Return all nodes [a]: around, outward, component; shape (60, 61, 2)."""
        s = 2.0 * np.pi * np.arange(UNIT_CELLS)[:, None] / UNIT_CELLS
        t = self.depths()
        reach = t * self.radius
        x = (1.0 - t + reach) * np.cos(s)
        y = ((1.0 - t) * self.semi_minor + reach) * np.sin(s)
        return np.stack([x, y], axis=-1)
