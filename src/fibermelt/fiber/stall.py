"""The stall angle of a confined fiber against the size of its cell, for any aspect ratio.

In simple shear a confined fiber turns at ``theta_dot = (gamma_dot/2)(B cos 2 theta - 1)``: where
its shape factor ``B(M, r_e)`` exceeds one it stalls at ``cos 2 theta = 1/B``, theta from the flow.
``B`` falls from the narrowest cell to Jeffery's ``xi < 1`` in an unbounded melt, and is one at the
largest cell in which the fiber stalls (the paper's Fig. 14c, and Eq. 32 for ``r_e = 6``).

``B`` is smooth in ``s = sqrt(1 - (2/M)^2)``, which runs from zero where the fiber touches the
cell's edge to one in the unbounded melt, where ``B = xi`` is exact: a polynomial through a dozen
Chebyshev points of ``s`` holds it to 1e-6 from ``M = 2.1`` to infinity. (In ``1/M^2`` or ``1/M``
the film at the tip takes twice as many.)
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, ConvergenceError, refuse_no_number, refuse_other
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.shape import Ellipse, jeffery_factor
from fibermelt.fiber.stall_data import StallCurve, domain_of, fit_curve, narrowness

__all__ = ["CURVE_NUMERICS", "StallCurve", "paper_stall_angle", "stall_curve"]

Array = NDArray[np.float64]

CURVE_NUMERICS = CellNumerics(order=6, angular_spacing=1.0, radial_spacing=1.0, estimate=False)
"""Cells of 50 ms whose ``B`` is good to `CELL_ERROR`: the spin converges long before pressures."""

CURVE_TOLERANCE = 1e-6
"""Largest error of ``B`` on a curve: angles of the paper's Fig. 14c are then good to 1e-5 rad."""

CELL_ERROR = 1e-7
"""Twice the largest error of ``B`` in those cells, against order 9, over `KNOWN_RATIOS` and M from
`KNOWN_DOMAIN` to 8; elsewhere the narrowest cell's own estimate takes its place if larger."""

KNOWN_RATIOS, KNOWN_DOMAIN = (1.5, 30.0), 2.05
"""Where `CELL_ERROR` was measured; rounder fibers have a thinner film for the same ``M``."""

HIGHEST_ORDER = 10
"""Order of the cells at which a rounder fiber is given up; 9 suffices at ``r_e = 1.02``."""

SMALLEST_DOMAIN = 2.1
"""Smallest ``M`` of a curve: a gap of a twentieth of the half-length at the tip."""

SMALLEST_GAP = 2.001
"""Smallest ``M`` that a curve can begin with; closer, the film at the tip is all there is."""

POINTS = 13
"""Points of a curve, the last of them the unbounded melt, which needs no cell."""

MOST_POINTS = 49
"""Points at which a curve that is not yet accurate is given up."""

PAPER_DOMAIN_END = 5.3
"""Largest ``M`` of the paper's Eq. 32: beyond 5.35 its angle is negative."""


def stall_curve(
    fiber_aspect_ratio: float,
    smallest_domain: float = SMALLEST_DOMAIN,
    tolerance: float = CURVE_TOLERANCE,
    numerics: CellNumerics | None = None,
) -> StallCurve:
    """Build the curve of a fiber from twelve cells: 0.7 s at ``r_e = 6``.

    The error is that of the cells, and the last two coefficients of the polynomial; if it is above
    the tolerance, the points are doubled and those already solved are used again.

    Parameters
    ----------
    fiber_aspect_ratio : float
        ``r_e`` [-], above one. Tried from 1.02 to 30; below 1.5 the cells take longer.
    smallest_domain : float
        Smallest ``M`` of the curve, at least 2.001; the largest is infinite.
    tolerance : float
        Of ``B`` [-], at least 2e-7, as the cells are good to 1e-7.
    numerics : CellNumerics, optional
        Of the cells; by default `CURVE_NUMERICS`, of a higher order where the narrowest cell needs
        it for the tolerance, as the thinner film of a rounder fiber does.

    Raises
    ------
    ConfigError
        If the aspect ratio is not above one, as a circle has ``B = 0`` in every cell and never
        stalls, or another value is out of its range.
    ConvergenceError
        If the cells, or 49 points, do not reach the tolerance.
    """
    _check_curve(fiber_aspect_ratio, smallest_domain, tolerance)
    if numerics is not None:
        refuse_other("numerics", numerics, CellNumerics)
    fiber = Ellipse(1.0, fiber_aspect_ratio)
    low, points = float(narrowness(np.asarray(smallest_domain))), POINTS
    narrowest, cells, numerics = _narrowest_cell(fiber, smallest_domain, tolerance, numerics)
    solved = {round(2.0 / smallest_domain, 12): narrowest}
    while points <= MOST_POINTS:
        nodes = -np.cos(np.pi * np.arange(points) / (points - 1))
        M = domain_of(0.5 * (low + 1.0 + (1.0 - low) * nodes))
        M[0], M[-1] = smallest_domain, np.inf
        for size in M:
            key = round(
                2.0 / float(size), 12
            )  # every other point is there already, but for rounding
            if key not in solved:
                solved[key] = _shape_factor(fiber, float(size), numerics)
        B = np.array([solved[round(2.0 / float(size), 12)] for size in M])
        error = cells + float(np.sum(np.abs(fit_curve(nodes, B)[-2:])))
        if error <= tolerance:
            return StallCurve(fiber_aspect_ratio, M, B, error)
        points = 2 * points - 1
    msg = (
        f"stall curve at r_e = {fiber_aspect_ratio:g}: {B.size} points from M = "
        f"{smallest_domain:g} on give B to {error:.1e} only (tolerance {tolerance:g}): "
        "take a larger smallest_domain or tolerance"
    )
    raise ConvergenceError(msg)


def paper_stall_angle(domain_size: ArrayLike) -> Array:
    """Return the paper's Eq. 32: the stall angle from the flow [rad] at ``r_e = 6``.

    ``0.33839 - 0.022 M - 0.0077 M^2``, to compare with: 0.203, 0.127 and 0.036 at ``M`` of 3, 4 and
    5, where the cells give 0.2004, 0.1292 and 0.0539. Its cells are coarse, and a parabola cannot
    follow the root with which the angle goes to zero.

    Parameters
    ----------
    domain_size : array_like
        ``M`` [-], above 2 and up to 5.3, where the parabola falls under zero; the paper prints no
        range. At 2.4 it gives 0.241, the cells 0.247.

    Raises
    ------
    ConfigError
        If a domain size is out of that range.
    """
    M = real_array("fiber.domain_size", domain_size)
    inside = (M > 2.0) & (PAPER_DOMAIN_END >= M)
    if not np.all(inside):
        first = float(M[~inside].flat[0])
        msg = (
            f"fiber.domain_size = {first:g}: the paper's Eq. 32 holds above 2 and up to "
            f"{PAPER_DOMAIN_END:g}; take the computed curve beyond"
        )
        raise ConfigError(msg)
    return np.asarray(0.33839 - 0.022 * M - 0.0077 * M**2)


def _check_curve(aspect_ratio: float, smallest: float, tolerance: float) -> None:
    refuse_no_number("fiber.aspect_ratio", aspect_ratio)
    refuse_no_number("smallest_domain", smallest)
    refuse_no_number("tolerance", tolerance)
    if not (np.isfinite(aspect_ratio) and aspect_ratio > 1.0):
        msg = (
            f"fiber.aspect_ratio = {aspect_ratio:g}: must be above 1; a circle does not feel "
            "strain and stalls in no cell"
        )
        raise ConfigError(msg)
    if not (np.isfinite(smallest) and smallest >= SMALLEST_GAP):
        msg = (
            f"smallest_domain = {smallest:g}: must be at least {SMALLEST_GAP:g}; at 2 the fiber "
            "touches the cell's edge"
        )
        raise ConfigError(msg)
    if not tolerance >= 2.0 * CELL_ERROR:
        msg = f"tolerance = {tolerance:g}: must be at least {2.0 * CELL_ERROR:g}, the cells' own"
        raise ConfigError(msg)


def _narrowest_cell(
    fiber: Ellipse, domain_size: float, tolerance: float, given: CellNumerics | None
) -> tuple[float, float, CellNumerics]:
    """Return ``B`` in the narrowest cell, which is the hardest, its error, and how it was solved.

    Numerics that are given stand; else the lowest order that reaches the tolerance is taken.
    """
    from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415  # a second's import, on demand

    low, high = KNOWN_RATIOS
    known = low <= fiber.aspect_ratio <= high and domain_size >= KNOWN_DOMAIN
    numerics = given or CURVE_NUMERICS
    highest = numerics.order if given else HIGHEST_ORDER
    for order in range(numerics.order, highest + 1):
        numerics = replace(numerics, order=order)
        is_known = known and numerics == CURVE_NUMERICS
        cell = solve_cell(fiber, domain_size, replace(numerics, estimate=not is_known))
        estimate = cell.error_estimate
        error = CELL_ERROR if estimate is None else max(CELL_ERROR, estimate.shape_factor)
        if error < tolerance:
            return cell.shape_factor, error, numerics
    msg = (
        f"stall curve at r_e = {fiber.aspect_ratio:g}: the cell of M = {domain_size:g} gives B "
        f"to {error:.1e} only (tolerance {tolerance:g}, order {highest}): take a more slender "
        "fiber, numerics of a higher order, a larger smallest_domain or tolerance"
    )
    raise ConvergenceError(msg)


def _shape_factor(fiber: Ellipse, domain_size: float, numerics: CellNumerics) -> float:
    """Return ``B`` of a cell, or of the unbounded melt."""
    if math.isinf(domain_size):
        return jeffery_factor(fiber.aspect_ratio)
    from fibermelt.fiber.cell import solve_cell  # noqa: PLC0415  # a second's import, on demand

    return solve_cell(fiber, domain_size, numerics).shape_factor
