"""The free surface by itself: planar Newtonian die swell."""

from __future__ import annotations

import numpy as np

from fibermelt.flow.dieswell import solve_die_swell, swell_problem
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.verify.ladder import Rung, below, order

__all__ = ["RUNGS", "SWELL"]

MITSOULIS = "Mitsoulis, Georgiou and Kountouriotis, Computers & Fluids 57 (2012) 195"

SWELL = 1.1867
"""Planar Newtonian swell ratio without surface tension; independent codes agree to 1e-4."""


def _swell(degree: int, edges: tuple[float, ...]) -> tuple[float, float]:
    """Return error of the extrapolated swell, and the order over all halvings of the lip's edge."""
    swell = np.array([solve_die_swell(edge, order=degree).swell for edge in edges])
    steps = -np.diff(swell)
    observed = float(np.log2(abs(steps[0] / steps[-1]))) / (len(steps) - 1)
    return abs(2 * float(swell[-1]) - float(swell[-2]) - SWELL), observed


def _swell_quick() -> tuple[float, float]:
    """Return `_swell` of second degree."""
    return _swell(2, (0.016, 0.008, 0.004, 0.002))


def _swell_full() -> tuple[float, float]:
    """Return `_swell` of third degree, to a finer edge."""
    return _swell(3, (0.016, 0.008, 0.004, 0.002, 0.001, 0.0005))


def _newton() -> tuple[float]:
    """Return the order of Newton's last two steps on flow and mesh together."""
    mesh, boundaries = swell_problem(0.02)
    flow = FreeSurfaceFlow(mesh, boundaries, 3)
    sizes = [flow.step().size for _ in range(4)]
    return (float(np.log(sizes[3] / sizes[2]) / np.log(sizes[2] / sizes[1])),)


RUNGS: tuple[Rung, ...] = (
    Rung(
        "flow",
        (
            below(
                "die swell: ratio",
                "Swell ratio of a planar Newtonian jet, P2 elements, extrapolated to no lip edge, "
                "against 1.1867.",
                MITSOULIS,
                2e-4,
                "a quarter of the last step, most of which the extrapolation is to remove",
            ),
            order(
                "die swell: order in the lip's edge",
                "Observed order of the swell ratio in the lip's edge over three halvings, P2 "
                "elements.",
                "stress ~ r^-1/2 at the lip leaves first order whatever the degree",
                (0.75, 1.25),
                "meshes differ in more than the lip: single pairs scatter by 0.3, three by 0.15",
            ),
        ),
        _swell_quick,
        quick=True,
        brief=True,
    ),
    Rung(
        "flow",
        (
            order(
                "free surface: order of Newton's steps",
                "Order of the last steps of Newton's method on flow and mesh together.",
                "Newton with an exact Jacobian is quadratic",
                (1.7, 2.3),
                "the square's own constant is felt in so few steps; a wrong term gives 1",
            ),
        ),
        _newton,
        quick=True,
        brief=True,
    ),
    Rung(
        "flow",
        (
            below(
                "die swell: ratio, fine",
                "Swell ratio of a planar Newtonian jet, P3 elements, extrapolated to no lip edge, "
                "against 1.1867.",
                MITSOULIS,
                1e-4,
                "what independent codes agree to",
            ),
            order(
                "die swell: order, fine",
                "Observed order of the swell ratio in the lip's edge over five halvings, P3 "
                "elements.",
                "stress ~ r^-1/2 at the lip leaves first order whatever the degree",
                (0.8, 1.2),
                "meshes differ in more than the lip: single pairs scatter by 0.3, five by 0.1",
            ),
        ),
        _swell_full,
        quick=False,
    ),
)
