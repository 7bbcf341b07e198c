"""The deposition flow: exact parts, balances and scalings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.deposition import FlowSolution, solve_deposition
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.streamlines import trace_streamlines
from fibermelt.melt import Newtonian
from fibermelt.verify.ladder import Rung, below

__all__ = ["LONG_CAPILLARY", "PAPER", "RUNGS", "line_flux"]

Array = NDArray[np.float64]

BATCHELOR = "Batchelor 1967, section 4.2, doi 10.1017/CBO9780511800955"
MASS = "conservation of mass"
SCALING = "Stokes flow is linear in viscosity and speed"

PAPER = Deposition(Nozzle(), Newtonian(viscosity=817.0))
"""The paper's study."""

LONG_CAPILLARY = replace(PAPER, nozzle=Nozzle(capillary_length=6 * Nozzle().capillary_width))
"""Six widths: both ends are felt in the middle as ``exp(-4.2 * 3) = 3e-6`` of their size."""

COARSE = FlowNumerics().coarsened(4.0)
"""Edges four times the default's: three seconds, and exact where the exact flow is a polynomial."""


def line_flux(flow: FlowSolution, first: tuple[float, float], last: tuple[float, float]) -> float:
    """Return the flux [m2/s] through a straight line, by Gauss's rule on 60 equal parts.

    Parameters
    ----------
    flow : FlowSolution
        The flow.
    first, last : (x, y)
        Ends of the line [m]; the flux counts to the right of the way from first to last.
    """
    nodes, weights = np.polynomial.legendre.leggauss(4)
    part = ((np.arange(60)[:, None] + 0.5 + 0.5 * nodes) / 60).ravel()
    weight = np.tile(weights / 120, 60)
    ends = np.array([first, last])
    tangent = ends[1] - ends[0]
    xy = ends[0] + part[:, None] * tangent
    u = flow.field.evaluate(flow.field.velocity, flow.field.locate(xy))
    return float(np.sum(weight * (u[:, 0] * tangent[1] - u[:, 1] * tangent[0])))


def _poiseuille(flow: FlowSolution) -> tuple[float, float]:
    """Return relative errors of pressure gradient and velocity in the middle of the capillary."""
    problem, field, nozzle = flow.problem, flow.field, flow.problem.nozzle
    width, middle = nozzle.capillary_width, nozzle.gap + 0.5 * nozzle.capillary_length
    y = middle + 0.1 * width * np.array([-1.0, 1.0])
    p = field.evaluate(field.pressure, field.locate(np.column_stack([np.zeros(2), y])))
    exact = 12 * problem.viscosity_scale * problem.flux / width**3
    x = np.linspace(-0.49, 0.49, 41) * width
    place = field.locate(np.column_stack([x, np.full(41, middle)]))
    mean = problem.flux / width
    parabola = -1.5 * mean * (1 - (2 * x / width) ** 2)
    miss = field.evaluate(field.velocity, place) - np.column_stack([np.zeros(41), parabola])
    return (
        abs(float((p[1] - p[0]) / (y[1] - y[0])) / exact - 1.0),
        float(np.max(np.abs(miss))) / mean,
    )


def _fluxes(flow: FlowSolution) -> float:
    """Return the largest relative error of the flux at stations along the melt's way."""
    nozzle, flux = flow.problem.nozzle, flow.problem.flux
    half = nozzle.capillary_width / 2
    heights = np.linspace(nozzle.gap * 1.02, nozzle.capillary_entrance * 0.999, 8)
    stations = [line_flux(flow, (half, y), (-half, y)) for y in heights]
    top = flow.downstream_surface
    for x in np.linspace(2 * half, 0.99 * nozzle.outlet, 8):
        height = float(np.interp(x, top[:, 0], top[:, 1]))
        stations.append(line_flux(flow, (x, 0.0), (x, height * (1 - 1e-6))))
    return float(np.max(np.abs(np.abs(stations) / flux - 1.0)))


def _coarse_flow() -> tuple[float, ...]:
    """Return what a coarse mesh must have exactly, or nearly."""
    flow = solve_deposition(LONG_CAPILLARY, COARSE)
    gradient, velocity = _poiseuille(flow)
    return gradient, velocity, flow.mass_imbalance, flow.kinematic_residual, _fluxes(flow)


def _papers_flow() -> tuple[float, ...]:
    """Return the balances of the paper's flow at the default settings."""
    flow = solve_deposition(PAPER)
    drift = float(np.median([line.drift for line in trace_streamlines(flow)]))
    return flow.mass_imbalance, _fluxes(flow), flow.kinematic_residual, drift


def _scalings() -> tuple[float, float, float]:
    """Return changes of shape, velocity and pressure by scaling viscosity and speeds."""
    viscosity, speed = 10.0, 2.0
    scaled = Deposition(
        PAPER.nozzle,
        Newtonian(viscosity=viscosity * PAPER.viscosity_scale),
        inlet_speed=speed * PAPER.inlet_speed,
        bed_speed=speed * PAPER.bed_speed,
    )
    one, other = (solve_deposition(problem, COARSE).field for problem in (PAPER, scaled))

    def change(found: Array, exact: Array) -> float:
        return float(np.max(np.abs(found - exact)) / np.max(np.abs(exact)))

    return (
        change(other.points, one.points),
        change(other.velocity, speed * one.velocity),
        change(other.pressure, viscosity * speed * one.pressure),
    )


RUNGS: tuple[Rung, ...] = (
    Rung(
        "flow",
        (
            below(
                "capillary: pressure gradient",
                "Pressure gradient in the middle of a capillary six widths long against "
                "12 mu Q / W^3, relative, coarse mesh.",
                BATCHELOR,
                1e-5,
                "the ends are felt as exp(-4.2 * 3) = 3e-6, the mesh by as much; the elements have "
                "a parabola exactly",
            ),
            below(
                "capillary: velocity",
                "Velocity in the middle of a capillary six widths long against the parabola, over "
                "its mean, coarse mesh.",
                BATCHELOR,
                1e-5,
                "the ends are felt as exp(-4.2 * 3) = 3e-6, the mesh by as much; the elements have "
                "a parabola exactly",
            ),
            below(
                "bead: height on a coarse mesh",
                "Bead height against flux over bed speed, relative, coarse mesh.",
                MASS,
                1e-7,
                "far downstream the height is set by mass alone, whatever the mesh: what is left "
                "is the end of the swell at the outlet",
            ),
            below(
                "bead: surface on a coarse mesh",
                "Velocity through the free surfaces, root mean square over the bed's speed, coarse "
                "mesh.",
                MASS,
                4e-4,
                "four times what the default mesh is allowed, as its edges are",
            ),
            below(
                "bead: flux on a coarse mesh",
                "Flux at 16 stations from capillary to outlet against the inlet's, relative, "
                "coarse mesh.",
                MASS,
                1e-4,
                "ten times what the default mesh is allowed: third order in the bulk's edges, "
                "first at the lips",
            ),
        ),
        _coarse_flow,
        quick=True,
    ),
    Rung(
        "flow",
        (
            below(
                "bead: height",
                "Bead height of the paper's study against flux over bed speed, relative.",
                MASS,
                1e-8,
                "far downstream the height is set by mass alone: what is left is the end of the "
                "swell at the outlet",
            ),
            below(
                "bead: flux",
                "Flux at 16 stations from capillary to outlet against the inlet's, relative.",
                MASS,
                1e-5,
                "a tenth of what elements of one degree less leak",
            ),
            below(
                "bead: surface",
                "Velocity through the free surfaces, root mean square over the bed's speed.",
                MASS,
                1e-4,
                "five times the lips' share on the default mesh",
            ),
            below(
                "streamlines: drift of the stream function",
                "Change of the stream function along a streamline over the flux, median of 22.",
                MASS,
                1e-5,
                "what fibers may be fed with: far below the flux between two lines",
            ),
        ),
        _papers_flow,
        quick=False,
    ),
    Rung(
        "flow",
        (
            below(
                "scaling: shape",
                "Nodes of the flow with ten times the viscosity at twice the speeds against the "
                "paper's, relative, coarse mesh.",
                SCALING,
                1e-12,
                "neither enters the scaled problem: rounding",
            ),
            below(
                "scaling: velocity",
                "Velocity of that flow against twice the paper's, relative, coarse mesh.",
                SCALING,
                1e-12,
                "it enters as a factor: rounding",
            ),
            below(
                "scaling: pressure",
                "Pressure of that flow against twenty times the paper's, relative, coarse mesh.",
                SCALING,
                1e-12,
                "both enter as factors: rounding",
            ),
        ),
        _scalings,
        quick=False,
    ),
)
