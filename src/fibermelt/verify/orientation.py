"""Orientation tensors: along histories, at rest, and from fiber content to the cell's size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from fibermelt.fiber.shape import jeffery_factor
from fibermelt.fiber.stall import stall_curve
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.evolve import follow_orientation
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.interaction import bay
from fibermelt.orientation.models import FolgarTucker, Jeffery
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import isotropic
from fibermelt.verify.closures import deformed_fibers
from fibermelt.verify.distribution import folgar_tucker
from fibermelt.verify.ladder import Rung, below, order
from fibermelt.verify.series import SeriesCell

__all__ = [
    "DURATION",
    "FACTOR",
    "RUNGS",
    "deformed_moment",
    "fifth_order_errors",
    "history_error",
    "turning_gradient",
]

Array = NDArray[np.float64]

PAPER = "Awenlimobor, Smith and Wang 2024, doi 10.1016/j.addma.2024.103980"
JEFFERY = "Jeffery 1922, doi 10.1098/rspa.1922.0078"
ADVANI = "Advani and Tucker 1987, doi 10.1122/1.549945"
DEUFLHARD = "Deuflhard 2011, doi 10.1007/978-3-642-23899-4"
LANGLOIS = "Langlois and Deville 2014, doi 10.1007/978-3-319-03835-3"

FACTOR = 0.9
DURATION = 3.0
"""Of the turning history [s]: three units of strain."""

EXACT = CLOSURES["exact"]

QUICK_STATES = (("ORE", 1e-3), ("IBOF", 1e-2), ("exact", 0.1))
"""Closures and ``C_I``, each tried in all flows: the range that melts have."""

EVERY_STATE = tuple(
    (name, interaction)
    for name in ("quadratic", "hybrid", "ORS", "ORW", "ORW3", "ORE", "IBOF", "exact")
    for interaction in (1e-3, 1e-2, 0.1)
)
"""All closures that have a physical steady state in every flow."""

RATIO, CONTENT, DOMAIN = 6.0, 0.084, 4.08
"""The paper's section 2.5: aspect ratio, fiber content by volume, and the ``M`` they lead to."""

STALLING = (3.0, 4.0, 5.0)


def turning_gradient(t: float) -> Array:
    """Return a velocity gradient (3, 3) [1/s] that turns, stretches and leaves the plane."""
    c, s = np.cos(t), np.sin(t)
    return np.array([[0.2 * c, 1.0, 0.1 * t], [0.3 * s, -0.5 * c, 0.2], [0.0, 0.1, 0.3 * c]])


def deformed_moment() -> Array:
    """Return the second moment of Jeffery's fibers from isotropy, at the end of that history.

    ``F_dot = (W + xi D) F`` moves every fiber, ``p = F p_0/|F p_0|``; by a Runge-Kutta method of
    order eight on the formula of the gradient, not its points.
    """

    def rate(t: float, F: Array) -> Array:
        L = turning_gradient(t)
        carried = 0.5 * (1.0 + FACTOR) * L - 0.5 * (1.0 - FACTOR) * L.T
        return np.asarray((carried @ F.reshape(3, 3)).ravel())

    span, start = (0.0, DURATION), np.eye(3).ravel()
    run = solve_ivp(rate, span, start, method="DOP853", rtol=1e-12, atol=1e-13)
    return deformed_fibers(run.y[:, -1].reshape(3, 3), 80)[0]


def history_error(exact: Array, points: int, tolerance: float) -> float:
    """Return the largest error of the tensor at the end of that history.

    Parameters
    ----------
    exact : (3, 3) array
        From `deformed_moment`.
    points : int
        Of the history.
    tolerance : float
        Of the steps.
    """
    time = np.linspace(0.0, DURATION, points)
    path = (time, np.stack([turning_gradient(t) for t in time]))
    found = follow_orientation(Jeffery(FACTOR), EXACT, path, isotropic(), rtol=tolerance)
    return float(np.max(np.abs(found.a[-1] - exact)))


def fifth_order_errors(points: tuple[int, ...], finest: int) -> tuple[Array, list[int]]:
    """Return errors by number of points, against the finest, and the steps that were taken.

    The gradient does not change, so its interpolation has no error of its own; the tolerance is
    such that each interval is one step.
    """
    L = turning_gradient(0.4) - np.eye(3) * np.trace(turning_gradient(0.4)) / 3.0
    ends, steps = [], []
    for count in (*points, finest):
        path = (np.linspace(0.0, DURATION, count), np.broadcast_to(L, (count, 3, 3)))
        found = follow_orientation(FolgarTucker(FACTOR, 0.02), EXACT, path, isotropic(), rtol=1.0)
        ends.append(found.a[-1])
        steps.append(found.steps)
    return np.array([np.max(np.abs(end - ends[-1])) for end in ends[:-1]]), steps


def _histories() -> tuple[float, float, float]:
    """Return the last error along the history, its order in the points, and the method's."""
    exact = deformed_moment()
    errors = [history_error(exact, points, 1e-11) for points in (21, 41, 81)]
    by_step, _ = fifth_order_errors((13, 25), 193)
    return (
        errors[-1],
        float(0.5 * np.log2(errors[0] / errors[-1])),
        float(np.log2(by_step[0] / by_step[1])),
    )


def _states(cases: tuple[tuple[str, float], ...]) -> tuple[float, float]:
    """Return the largest rate over the shear rate, and the most Newton steps, of steady states."""
    factor = jeffery_factor(RATIO)
    residuals, iterations = [], []
    for name, interaction in cases:
        for L in FLOWS.values():
            state = steady_state(FolgarTucker(factor, interaction), L, CLOSURES[name])
            rate = float(np.sqrt(2.0 * np.sum((0.5 * (L + L.T)) ** 2)))
            A = CLOSURES[name].fourth(state.a)
            left = folgar_tucker(state.a, A, L, factor, interaction * rate)
            residuals.append(np.max(np.abs(left)) / rate)
            iterations.append(state.iterations)
    return float(max(residuals)), float(max(iterations))


def _steady() -> tuple[float, float, float]:
    """Return what some steady states leave, and one of them against a long history."""
    model, mixed = FolgarTucker(jeffery_factor(RATIO), 0.05), FLOWS["mixed"]
    state = steady_state(model, mixed, CLOSURES["ORE"])
    decay = abs(float(state.growth[0])) * np.sqrt(5.0)  # growth is over the mixed flow's rate
    path = (np.linspace(0.0, 20.0 / decay, 41), np.broadcast_to(mixed, (41, 3, 3)))
    end = follow_orientation(model, CLOSURES["ORE"], path, isotropic(), rtol=1e-8).a[-1]
    return *_states(QUICK_STATES), float(np.max(np.abs(end - state.a)))


def _every_state() -> tuple[float, float]:
    """Return what the steady states of all closures leave."""
    return _states(EVERY_STATE)


def _content() -> tuple[float, float, float]:
    """Return errors of the stall curve, of its end, and of the paper's domain size."""
    curve = stall_curve(RATIO)
    factors = np.array([SeriesCell(RATIO, M).shape_factor for M in STALLING])
    largest = SeriesCell(RATIO, curve.largest_stalling_domain).shape_factor
    model = FolgarTucker(jeffery_factor(RATIO), bay(CONTENT, RATIO), convention="paper")
    angle = steady_state(model, FLOWS["simple-shear"], CLOSURES["ORE"]).angle
    return (
        float(np.max(np.abs(curve.value(STALLING) - factors))),
        abs(largest - 1.0),
        abs(curve.domain_size_at(angle) - DOMAIN),
    )


RUNGS = (
    Rung(
        "orientation",
        (
            below(
                "tensor: along a history",
                "Orientation tensor of Jeffery's fibers with the exact closure at the end of a "
                "history of 81 points against all fibers, each moved by itself.",
                JEFFERY,
                5e-9,
                "twice the error of the cubic through the points",
            ),
            order(
                "tensor: order in the history's points",
                "Order in the spacing of the history's points of that error, from 21 to 81.",
                "de Boor 2001, doi 10.1007/978-1-4612-6333-3",
                (3.65, 4.05),
                "fourth order, less what the slopes at the ends lack: 3.85 at these spacings",
            ),
            order(
                "tensor: order of the integrator",
                "Order in the step at which the error of the tensor falls, steps of 1/4 and 1/8.",
                "Dormand and Prince 1980, doi 10.1016/0771-050X(80)90013-3",
                (4.8, 5.2),
                "fifth order; the next term is 1/20 of it",
            ),
        ),
        _histories,
        quick=True,
        brief=True,
    ),
    Rung(
        "orientation",
        (
            below(
                "steady state: residual",
                "Rate of the steady tensor by Folgar and Tucker's equation over the shear rate, "
                "five flows, C_I from 1e-3 to 0.1, 15 states.",
                ADVANI,
                2e-12,
                "the tolerance of Newton's method, 1e-12, and rounding of as much",
            ),
            below(
                "steady state: iterations",
                "Newton steps at the C_I asked for, the most of these states.",
                DEUFLHARD,
                10.0,
                "quadratic from a predicted start takes a handful; twice that is not quadratic",
            ),
            below(
                "steady state: end of a long history",
                "Steady tensor by Newton's method against the end of a history of twenty decay "
                "times, mixed flow, closure ORE.",
                "an integration in time, which knows no steady state",
                1e-8,
                "exp(-20) = 2e-9 of the way is left, and the tolerance of a step",
            ),
        ),
        _steady,
        quick=True,
        brief=True,
    ),
    Rung(
        "orientation",
        (
            below(
                "steady states: residual",
                "The same residual of eight closures in five flows, C_I from 1e-3 to 0.1, 120 "
                "states.",
                ADVANI,
                2e-12,
                "the tolerance of Newton's method, 1e-12, and rounding of as much",
            ),
            below(
                "steady states: iterations",
                "Newton steps at the C_I asked for, the most of these 120 states.",
                DEUFLHARD,
                10.0,
                "quadratic from a predicted start takes a handful; twice that is not quadratic",
            ),
        ),
        _every_state,
        quick=False,
    ),
    Rung(
        "orientation",
        (
            below(
                "stall curve: shape factor",
                "B of confined fibers by the stall curve against series solutions, M of 3, 4, 5.",
                LANGLOIS,
                1e-6,
                "the curve's stated tolerance",
            ),
            below(
                "stall curve: largest domain",
                "B by a series solution in the largest cell in which a fiber stalls against one.",
                LANGLOIS,
                1e-6,
                "the curve's stated tolerance",
            ),
            below(
                "content: the paper's domain size",
                "M from 8.4 % of fibers by volume, in the paper's convention, against its 4.08.",
                PAPER,
                0.1,
                "the paper reads it off polynomials, which are off by as much",
            ),
        ),
        _content,
        quick=True,
    ),
)
