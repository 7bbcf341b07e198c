"""The confined fiber: against the unbounded one, a series, and the paper's own algorithm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell import build_system, solve_cell
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.jeffery import unbounded_ellipse
from fibermelt.fiber.newton import NewtonSolver
from fibermelt.fiber.paths import strain_polar
from fibermelt.fiber.shape import Ellipse
from fibermelt.verify.ladder import Rung, below, order
from fibermelt.verify.series import SeriesCell

__all__ = ["RUNGS"]

Array = NDArray[np.float64]

PAPER = "Awenlimobor, Smith and Wang 2024, doi 10.1016/j.addma.2024.103980"
GOURSAT = "Langlois and Deville 2014, doi 10.1007/978-3-319-03835-3"

FIBER = Ellipse(1.0, 6.0)
CELL = 4.0
"""The paper's aspect ratio and domain-size factor ``M``."""

DOMAINS = (40.0, 80.0)
"""Far enough for the leading term, near enough for differences above the elements' 1e-5."""

ORDERS = (3, 5, 7)
"""Velocity orders on one mesh; at 8 the series' own error shows."""


def _unbounded_limit() -> tuple[float, ...]:
    """Return orders in ``1/M`` of shape factor and surface pressure, and their last distances."""
    exact = unbounded_ellipse(FIBER)
    factor, pressure = [], []
    for domain in DOMAINS:
        response = solve_cell(FIBER, domain, CellNumerics(order=8, estimate=False)).response
        factor.append(abs(response.shape_factor - exact.shape_factor))
        difference = response.curve.point(exact.surface) - exact.basis
        pressure.append(np.max(np.abs(difference)) / exact.support.largest)
    return (
        float(np.log2(factor[-2] / factor[-1])),
        float(np.log2(pressure[-2] / pressure[-1])),
        float(factor[-1]),
        float(pressure[-1]),
    )


def _series() -> tuple[float, ...]:
    """Return errors of ``B`` and of the surface pressure, and how fast both fall by the order."""
    series = SeriesCell(FIBER.aspect_ratio, CELL)
    factor, pressure = [], []
    for degree in ORDERS:
        cell = solve_cell(FIBER, CELL, CellNumerics(order=degree, estimate=False))
        exact = series.basis(cell.response.surface)
        factor.append(abs(cell.shape_factor - series.shape_factor))
        largest = np.max(np.hypot(*exact.T))
        pressure.append(np.max(np.abs(cell.response.basis - exact)) / largest)
    added = ORDERS[-1] - ORDERS[0]
    return (
        factor[-1],
        float(pressure[-1]),
        float((pressure[0] / pressure[-1]) ** (1.0 / added)),
        float((factor[0] / factor[-1]) ** (1.0 / added)),
    )


def _circle_in_circle() -> tuple[float, float]:
    """Return errors of tip pressure and shape factor of a circle in its cell.

    ``f = A z^3 + B/z``, ``g = E z + C/z^3`` for the strain ``D_11 = 1``: on ``|z| = r`` the
    harmonic ``e^(3 i s)`` has ``A r^3 + B/r - C/r^3`` and ``e^(-i s)`` has ``B/r - 3 A r^3 - E r``;
    both vanish at 1, and at ``R`` the second is ``R``.
    """
    R = 0.5 * CELL
    rows = []
    for r in (1.0, R):
        rows += [[r**3, 1.0 / r, 0.0, -(r**-3)], [-3.0 * r**3, 1.0 / r, -r, 0.0]]
    A, B, *_ = np.linalg.solve(rows, [0.0, 0.0, 0.0, R])
    cell = solve_cell(Ellipse(1.0, 1.0), CELL, CellNumerics(estimate=False))
    exact = -4.0 * (3.0 * A - B)
    return abs(float(cell.response.tip[0] / exact) - 1.0), abs(cell.shape_factor)


def _newton_raphson() -> tuple[float, float]:
    """Return differences in spin and surface pressure between the two paths, over ``|D|``."""
    system = build_system(FIBER, CELL, CellNumerics(order=4))
    solver, response = NewtonSolver(system), system.response
    gradients = np.random.default_rng(11).normal(size=(12, 2, 2))
    gradients[:, 1, 1] = -gradients[:, 0, 0]
    size, double = strain_polar(gradients)
    spins, pressures = [], []
    for k, gradient in enumerate(gradients):
        angle = 0.5 * k
        melt = np.concatenate([[0.3, -1.1], gradient.ravel()])
        rates, unknowns = solver.motion(FIBER.half_length, melt, angle, np.zeros(3))
        phase = double[k] - 2.0 * angle
        whirl = 0.5 * (gradient[1, 0] - gradient[0, 1])
        exact = whirl + response.shape_factor * size[k] * np.sin(phase)
        spins.append(abs(rates[2] - exact) / size[k])
        shape = response.basis @ [np.cos(phase), np.sin(phase)]
        difference = solver.surface_pressure(unknowns) / size[k] - shape
        pressures.append(np.max(np.abs(difference)))
    return float(max(spins)), float(max(pressures))


RUNGS = (
    Rung(
        "fiber",
        (
            order(
                "cell: shape factor becomes Jeffery's",
                "Order in 1/M in which B becomes xi, from M = 40 to 80.",
                "far field of a stresslet, u ~ 1/r: the edge answers as (a/R)^2",
                (1.95, 2.05),
                "the next term is (a/R)^2 smaller, 1e-3 at M = 80",
            ),
            order(
                "cell: pressure becomes the ellipse's",
                "Order in 1/M in which the surface pressure becomes the closed form's, from M = 40 "
                "to 80.",
                "far field of a stresslet, u ~ 1/r: the edge answers as (a/R)^2",
                (1.95, 2.05),
                "the next term is 1e-3, and the elements' 1e-5 are 1 % of what is left at M = 80",
            ),
            below(
                "cell: B - xi at M = 80",
                "Shape factor of the confined fiber against Jeffery's at M = 80.",
                "Jeffery 1922, doi 10.1098/rspa.1922.0078",
                1e-3,
                "of the order of (a/R)^2 = 6e-4",
            ),
            below(
                "cell: pressure at M = 80",
                "Surface pressure of the confined fiber against the closed form at M = 80, over "
                "the largest.",
                "Jeffery 1922, doi 10.1098/rspa.1922.0078",
                2e-3,
                "a few times (a/R)^2 = 6e-4",
            ),
        ),
        _unbounded_limit,
        quick=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "cell: shape factor by a series",
                "B of the paper's cell by finite elements against a series solution.",
                GOURSAT,
                1e-8,
                "ten times the default settings' own estimate of their error",
            ),
            below(
                "cell: surface pressure by a series",
                "Surface pressure of the paper's cell by finite elements against a series "
                "solution, over the largest.",
                GOURSAT,
                1e-4,
                "ten times the default settings' own estimate of their error",
            ),
            order(
                "cell: pressure's gain per order",
                "Factor by which the error of the surface pressure falls for every order of the "
                "elements, from 3 to 7.",
                "Babuska and Suri 1994, doi 10.1137/1036141",
                (4.0, 7.0),
                "analytic solutions converge exponentially: 5.5 on this mesh, less if an order is "
                "lost",
            ),
            order(
                "cell: shape factor's gain per order",
                "Factor by which the error of B falls for every order of the elements, from 3 to "
                "7.",
                "Babuska and Suri 1994, doi 10.1137/1036141",
                (8.0, 14.0),
                "a torque is a virtual work, so it gains more than the pressure: 11 on this mesh",
            ),
        ),
        _series,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "cell: circle in a circle, pressure",
                "Tip pressure of a circle in the paper's cell against the elementary solution, "
                "relative.",
                GOURSAT,
                1e-6,
                "no tip to resolve: a hundred times the elements' own error",
            ),
            below(
                "cell: circle in a circle, spin",
                "B of a circle, which has no direction to be turned to, against zero.",
                "symmetry",
                1e-8,
                "ten times the elements' own error",
            ),
        ),
        _circle_in_circle,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "cell: spin by the paper's algorithm",
                "Spin of a fiber by superposition against Newton-Raphson on force and torque, "
                "over the strain rate, 12 flows.",
                PAPER,
                1e-9,
                "the same linear algebra in two ways: solver precision",
            ),
            below(
                "cell: pressure by the paper's algorithm",
                "Surface pressure by superposition against Newton-Raphson on force and torque, "
                "over viscosity and strain rate, 12 flows.",
                PAPER,
                1e-9,
                "the same linear algebra in two ways: solver precision",
            ),
        ),
        _newton_raphson,
        quick=True,
        brief=True,
    ),
)
