"""Closed forms of an unbounded fiber, against other forms of the same."""

from __future__ import annotations

import numpy as np

from fibermelt.fiber.ellipsoid import Ellipsoid, unbounded_ellipsoid
from fibermelt.fiber.ellipsoid_integrals import ellipsoid_integrals
from fibermelt.fiber.jeffery import ellipse_extremes, unbounded_ellipse
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.spheroid import Spheroid, embed_planar, unbounded_spheroid
from fibermelt.verify.ladder import Rung, below, order

__all__ = ["RUNGS", "TIP_PRESSURES", "spheroid_integrals"]

JEFFERY = "Jeffery 1922, doi 10.1098/rspa.1922.0078"

EXACT = 1e-12
"""Closed forms lose a few digits of rounding to the aspect ratio, no more."""

RATIO = 6.0
SPATIAL = np.array([[0.3, 1.1, -0.4], [-0.2, 0.5, 0.7], [0.6, -0.9, -0.8]])
STRETCH = np.diag([1.0, -0.5, -0.5])

TIP_PRESSURES = {3.0: -13.384, 6.0: -31.067, 10.0: -63.034}
"""Tip pressure over ``mu`` of prolate spheroids in unit axial stretching, by aspect ratio: an
evaluation of Jeffery's solution that shares no code with this one, to the digits it gave."""


def _orbit_extreme() -> tuple[float]:
    """Return the worst relative error over aspect ratios from a circle to a long fiber."""
    ratios = (1.0, 2.0, RATIO, 50.0)
    errors = [
        abs(unbounded_ellipse(Ellipse(1.0, ratio)).tip_pressure / (1.0 + ratio) - 1.0)
        for ratio in ratios
    ]
    return (max(errors),)


def _spheroid_tips() -> tuple[float, ...]:
    """Return errors of the tip pressures, of a tumbling spheroid's peak, and of the sphere."""
    axis = np.array([1.0, 0.0, 0.0])
    tips = [
        abs(float(unbounded_spheroid(Spheroid(1.0, ratio)).tip(STRETCH, axis)) - pressure)
        for ratio, pressure in TIP_PRESSURES.items()
    ]
    shear = embed_planar([[0.0, 1.0], [0.0, 0.0]])
    _, peak = unbounded_spheroid(Spheroid(1.0, RATIO)).bounds(shear)
    sphere = unbounded_ellipsoid(Ellipsoid((1.0, 1.0, 1.0))).surface_stress(SPATIAL)
    exact = 2.5 * (SPATIAL + SPATIAL.T)
    return max(tips), abs(float(peak) - 15.53), float(np.max(np.abs(sphere - exact)))


def spheroid_integrals(ratio: float) -> tuple[float, float, float]:
    """Return ``N_a``, ``I_ab`` and ``I_bb`` of a spheroid with ``b = 1`` in elementary functions.

    Parameters
    ----------
    ratio : float
        ``r_e`` [-], positive and away from one, where these forms cancel.

    References
    ----------
    Osborn 1945, doi 10.1103/PhysRev.67.351.
    """
    if ratio > 1.0:
        root = np.sqrt(ratio * ratio - 1.0)
        along = (ratio / root * np.log(ratio + root) - 1.0) / root**2
    else:
        root = np.sqrt(1.0 - ratio * ratio)
        along = (1.0 - ratio / root * np.arccos(ratio)) / root**2
    across = 0.5 * (1.0 - along)
    mixed = 2.0 * (across - along) / (ratio * ratio - 1.0)
    return float(along), float(mixed), float(0.25 * (2.0 - mixed))  # 4 I_bb + I_ab = 2/b^2


def _integrals() -> tuple[float]:
    """Return the worst relative error of a spheroid's integrals, prolate and oblate."""
    errors = []
    for ratio in (0.1, 0.5, 2.0, RATIO, 40.0):
        found = ellipsoid_integrals(np.array([ratio, 1.0, 1.0]), np.array(0.0))
        values = (0.5 * found.single[0], found.double[0, 1], found.double[1, 2])
        exact = np.array(spheroid_integrals(ratio))
        errors.append(np.max(np.abs(np.array(values) / exact - 1.0)))
    return (float(max(errors)),)


def _cylinder_limit() -> tuple[float]:
    """Return the order in which an ellipsoid's extremes become the ellipse's as it grows long."""
    gradient = np.random.default_rng(2).normal(size=(50, 2, 2))
    gradient[:, 1, 1] = -gradient[:, 0, 0]
    shear = 0.5 * (gradient[:, 0, 1] + gradient[:, 1, 0])
    low, high = ellipse_extremes(RATIO, gradient[:, 0, 0], shear)
    errors = []
    for length in (200.0, 400.0):
        body = unbounded_ellipsoid(Ellipsoid((1.0, 1.0 / RATIO, length)))
        found = body.extremes(embed_planar(gradient))
        errors.append(max(np.max(np.abs(found.lowest - low)), np.max(np.abs(found.highest - high))))
    return (float(np.log2(errors[0] / errors[1])),)


RUNGS = (
    Rung(
        "fiber",
        (
            below(
                "ellipse: extreme over an orbit",
                "Largest surface pressure of an unbounded ellipse over an orbit in simple shear "
                "against mu gamma_dot (1 + r_e), relative, aspect ratios 1 to 50.",
                JEFFERY,
                EXACT,
                "both sides are closed forms: rounding",
            ),
        ),
        _orbit_extreme,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "spheroid: tip pressures",
                "Tip pressure over mu in unit axial stretching at aspect ratios 3, 6 and 10 "
                "against an independent evaluation.",
                JEFFERY,
                5e-4,
                "the reference has three decimals",
                "1/s",
            ),
            below(
                "spheroid: peak of an orbit",
                "Largest surface pressure in simple shear over all directions at aspect ratio 6 "
                "against 15.53 mu gamma_dot.",
                JEFFERY,
                5e-3,
                "the reference has two decimals",
            ),
            below(
                "sphere: surface stress",
                "Traction tensor of a free sphere against 5/2 mu (L + L^T), unit rates.",
                "Einstein 1906, doi 10.1002/andp.19063240204",
                EXACT,
                "both sides are closed forms: rounding",
                "1/s",
            ),
        ),
        _spheroid_tips,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            below(
                "ellipsoid: integrals",
                "Integrals of an ellipsoid's potentials, by quadrature, against a spheroid's in "
                "elementary functions, relative, aspect ratios 0.1 to 40.",
                "Osborn 1945, doi 10.1103/PhysRev.67.351",
                EXACT,
                "the quadrature has converged, and the other side loses two digits: rounding",
            ),
        ),
        _integrals,
        quick=True,
        brief=True,
    ),
    Rung(
        "fiber",
        (
            order(
                "ellipsoid: becomes the ellipse",
                "Order in which surface extremes of an ellipsoid become those of the ellipse as "
                "its third axis grows from 200 to 400 half-lengths.",
                JEFFERY,
                (1.75, 2.25),
                "second order times a logarithm, which is worth 0.2 at these lengths",
            ),
        ),
        _cylinder_limit,
        quick=True,
        brief=True,
    ),
)
"""All quick: nothing here is solved."""
