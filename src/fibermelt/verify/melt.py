"""Melts that thin: the developed flow of a power law, by itself and in the deposition flow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.deposition import solve_deposition
from fibermelt.flow.problem import FlowNumerics
from fibermelt.melt import PowerLaw
from fibermelt.melt.slit import SlitFlow
from fibermelt.verify.flow import LONG_CAPILLARY
from fibermelt.verify.ladder import Rung, below

__all__ = ["RUNGS"]

Array = NDArray[np.float64]

BIRD = "Bird, Armstrong and Hassager 1987, section 4.2"
INDICES = (1.0, 0.8, 0.5, 0.35, 0.25)
CONSISTENCY, LOWEST = 8213.0, 1e-6


def _wall(law: PowerLaw, width: float, speed: float) -> tuple[float, float]:
    """Return the exact rate at the wall [1/s] and pressure gradient [Pa/m] of a power law."""
    n = law.index
    wall = 2.0 * speed / width * (2.0 * n + 1.0) / n
    return wall, 2.0 * law.consistency / width * wall**n


def _slit() -> tuple[float, float, float]:
    """Return relative errors of wall rate, pressure gradient and profile of all indices."""
    width, speed = 3.175e-3, 0.096
    z = np.linspace(-1.0, 1.0, 201)
    errors = []
    for n in INDICES:
        law = PowerLaw(CONSISTENCY, n, LOWEST)
        found, (rate, gradient) = SlitFlow(law, width, speed), _wall(law, width, speed)
        profile = (2.0 * n + 1.0) / (n + 1.0) * (1.0 - np.abs(z) ** ((n + 1.0) / n))
        miss = found.velocity(0.5 * width * z) / speed - profile
        errors.append(
            (
                abs(found.wall_rate / rate - 1.0),
                abs(found.pressure_gradient / gradient - 1.0),
                float(np.max(np.abs(miss))),
            )
        )
    rate, gradient, profile = np.max(errors, axis=0)
    return float(rate), float(gradient), float(profile)


def _capillary() -> tuple[float, float]:
    """Return relative errors of a power law's flow in the middle of a long capillary."""
    law = PowerLaw(CONSISTENCY, 0.5, LOWEST)
    flow = solve_deposition(replace(LONG_CAPILLARY, melt=law), FlowNumerics().coarsened(4.0))
    nozzle, field = LONG_CAPILLARY.nozzle, flow.field
    width, middle = nozzle.capillary_width, nozzle.gap + 0.5 * nozzle.capillary_length
    speed = LONG_CAPILLARY.flux / width
    y = middle + 0.1 * width * np.array([-1.0, 1.0])
    p = field.evaluate(field.pressure, field.locate(np.column_stack([np.zeros(2), y])))
    x = np.linspace(-0.49, 0.49, 41)
    place = field.locate(np.column_stack([x * width, np.full(41, middle)]))
    exact = -2.0 / 1.5 * (1.0 - np.abs(2.0 * x) ** 3)
    miss = field.evaluate(field.velocity, place)[:, 1] / speed - exact
    gradient = float((p[1] - p[0]) / (y[1] - y[0]))
    return (
        abs(gradient / _wall(law, width, speed)[1] - 1.0),
        float(np.max(np.abs(miss))),
    )


RUNGS: tuple[Rung, ...] = (
    Rung(
        "melt",
        (
            below(
                "slit: rate at the wall",
                "Rate at the wall of a power law's flow in a slit against (2 U/H)(2 n + 1)/n, "
                "relative, n = 0.25 to 1.",
                BIRD,
                1e-11,
                "the root is found to the last digit, and panels that halve towards the axis have "
                "its powers as well",
            ),
            below(
                "slit: pressure gradient",
                "Pressure gradient of that flow against (2 K/H) wall rate^n, relative.",
                BIRD,
                1e-11,
                "as the rate at the wall",
            ),
            below(
                "slit: profile",
                "Velocity of that flow against the exact profile, over the mean.",
                BIRD,
                1e-9,
                "cubics with exact slopes between 401 points that crowd at the axis and the wall",
            ),
        ),
        _slit,
        quick=True,
        brief=True,
    ),
    Rung(
        "melt",
        (
            below(
                "capillary: pressure gradient of a power law",
                "Pressure gradient in the middle of a capillary six widths long against that of a "
                "slit, n = 0.5, relative, coarse mesh.",
                BIRD,
                1e-3,
                "the elements do not have |z|^3 and its stress exactly, as they have a parabola",
            ),
            below(
                "capillary: velocity of a power law",
                "Velocity there against the exact profile, over the mean.",
                BIRD,
                1e-3,
                "as the pressure gradient",
            ),
        ),
        _capillary,
        quick=False,
    ),
)
