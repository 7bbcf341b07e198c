"""The cell's grid: rays along the fiber's normals, from the ellipse to the circle.

A structured grid of ``columns x rows`` curved quadrilaterals covers the ring between the fiber
(semi-axes 1 and ``b``) and the cell's edge (radius ``R``). Column ``i`` counts counter-clockwise
from the tip on the x axis, row ``j`` outward from the fiber. Two lengths decide where it is fine:

- in the conformal coordinates ``x + i y = c cosh(xi + i s)`` of the ellipse the continued solution
  is singular at the foci only, at the distance ``xi_0 = artanh(b/a)`` from the surface and right
  below the tips: the spacing in ``s`` grows like ``sqrt(s^2 + xi_0^2)`` from each tip, and the
  spacing along a normal starts at the local length ``xi_0 sqrt(a^2 sin^2 s + b^2 cos^2 s)``,
  which at the tip is the radius of curvature ``b^2/a``;
- a narrow gap ``g = R - a`` is felt over the distance ``s = sqrt(2 g/(1 - b^2))`` from the tip.

Both enter through ``sinh`` stretches, so the number of elements grows with the logarithm only
of the aspect ratio and of the domain size. Columns may be bounded in width: `CellGrid.even_from`.
Lengths are in units of the half-length ``a``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["CellGrid"]

Array = NDArray[np.float64]

LARGEST_STRETCH = 0.8
"""Bound of the grading length: a circle needs none, but a few elements for its own pressure."""

FEWEST_PER_QUARTER = 4
"""Columns in a quarter turn, so that ``cos 2s`` is met by several elements."""

FEWEST_ROWS = 4
"""Rows across the gap, so that a lubrication profile is not left to one polynomial."""


@dataclass(frozen=True)
class CellGrid:
    """Where the elements of a cell lie.

    Parameters
    ----------
    semi_minor : float
        ``b/a`` of the ellipse [-], at most one.
    radius : float
        ``R/a`` of the cell [-], above one.
    angular_spacing, radial_spacing : float
        Largest element in the stretched coordinates [-], where the distance to the nearest
        singularity is about one: smaller is finer.
    sharpening : float
        How many times nearer to the tip and the surface than the above the grid is fine [-]. One in
        a Newtonian melt; a thinning one varies around the points of the surface where nothing
        deforms, the tip in a stretch along the fiber.
    even_from : float
        Eccentric angle from a tip [rad] beyond which columns grow no wider. In a Newtonian melt
        they go on growing, its singularities lie below the tips; the points of a thinning one move
        all over the surface as the strain turns.
    """

    semi_minor: float
    radius: float
    angular_spacing: float
    radial_spacing: float
    sharpening: float = 1.0
    even_from: float = math.inf

    @cached_property
    def focal_depth(self) -> float:
        """Return ``xi_0``, the conformal distance of the foci below the surface [-], bounded.

        Over the sharpening.
        """
        b = self.semi_minor
        depth = LARGEST_STRETCH if b >= math.tanh(LARGEST_STRETCH) else math.atanh(b)
        return depth / self.sharpening

    @cached_property
    def tip_width(self) -> float:
        """Return the eccentric angle over which the tip's pressure varies [rad]."""
        gap, b = self.radius - 1.0, self.semi_minor
        lubrication = math.sqrt(2.0 * gap / (1.0 - b * b)) if b < 1.0 else math.inf
        return min(self.focal_depth, lubrication / self.sharpening)

    @cached_property
    def stretch(self) -> float:
        """Return the quarter turn's length in the stretched angle, that of `eccentric_angle`."""
        return float(self._stretched(np.float64(0.5 * math.pi)))

    def _stretched(self, offset: Any) -> Any:
        """Return the stretched angle at eccentric angles [rad] from a tip."""
        if math.isfinite(self.even_from):
            offset = self.even_from * np.sinh(offset / self.even_from)
        return np.arcsinh(offset / self.tip_width)

    @cached_property
    def columns_per_quarter(self) -> int:
        """Return the number of columns from tip to flank."""
        return max(FEWEST_PER_QUARTER, math.ceil(self.stretch / self.angular_spacing))

    @property
    def columns(self) -> int:
        """Return the number of elements around the fiber."""
        return 4 * self.columns_per_quarter

    @cached_property
    def rows(self) -> int:
        """Return the number of elements between the fiber and the cell's edge."""
        b, depth = self.semi_minor, self.focal_depth
        tip = math.asinh((self.radius - 1.0) / (depth * b))
        flank = math.asinh((self.radius - b) / depth)
        return max(FEWEST_ROWS, math.ceil(max(tip, flank) / self.radial_spacing))

    def nearest_tip(self, column: NDArray[np.int_]) -> Array:
        """Return the tip (0, 2 or 4 quarter turns) from which a column's angle is counted."""
        quarter = np.asarray(column) // self.columns_per_quarter
        return np.asarray(2.0 * ((quarter + 1) // 2), dtype=np.float64)

    def eccentric_angle(self, tip: Any, quarters: Any, functions: Any = np) -> Any:
        """Return the eccentric angle ``s`` [rad] of the ray at ``quarters`` [0, 4].

        From a tip it is ``t = c sinh(stretch u)``, or with ``e`` the angle ``even_from`` ``e
        arsinh(t/e)``, so that elements are as wide as ``sqrt(c^2 + s^2)`` up to ``e`` and no wider.

        Parameters
        ----------
        tip
            `nearest_tip` of the ray's column.
        quarters
            Column coordinate in quarter turns, ``column / columns_per_quarter``.
        functions
            Module whose ``sinh`` is used: numpy, or the finite elements' own.
        """
        offset = self.tip_width * functions.sinh(self.stretch * (quarters - tip))
        if math.isfinite(self.even_from):
            part = offset / self.even_from
            offset = self.even_from * functions.log(part + functions.sqrt(1.0 + part * part))
        return tip * (0.5 * math.pi) + offset

    def column_coordinate(self, angle: Array) -> Array:
        """Return the column coordinate in [0, columns) at eccentric angles in [0, 2 pi)."""
        tip = 2.0 * np.floor(angle / math.pi + 0.5)
        offset = self._stretched(angle - tip * (0.5 * math.pi)) / self.stretch
        return np.asarray((tip + offset) * self.columns_per_quarter % self.columns)

    def position(self, tip: Any, quarters: Any, depth: Any, functions: Any = np) -> tuple[Any, Any]:
        """Return ``x, y`` [a] at a ray and a fraction ``depth`` of the way to the cell's edge.

        ``E(s) + t n(s)`` with ``n`` the ellipse's normal, ``t = l sinh(k depth)``, ``l`` the local
        length of the module's docstring and ``k`` such that ``depth = 1`` lies on the circle.
        Normals of a convex curve never meet, so the grid cannot fold.
        """
        fn, b, radius = functions, self.semi_minor, self.radius
        s = self.eccentric_angle(tip, quarters, fn)
        x, y = fn.cos(s), b * fn.sin(s)
        metric = fn.sqrt(fn.sin(s) ** 2 + (b * fn.cos(s)) ** 2)
        nx, ny = b * fn.cos(s) / metric, fn.sin(s) / metric
        along = x * nx + y * ny
        reach = fn.sqrt(along * along + radius * radius - x * x - y * y) - along
        local = self.focal_depth * metric
        ratio = reach / local
        t = local * fn.sinh(fn.log(ratio + fn.sqrt(1.0 + ratio * ratio)) * depth)
        return x + t * nx, y + t * ny
