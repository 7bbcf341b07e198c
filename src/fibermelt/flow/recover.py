"""From the solver's spaces to plain arrays: gradient, stream function, nodal values, error."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fibermelt.flow.field import FlowField
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.lagrange import LagrangeTriangle
from fibermelt.flow.linear import CondensedForm
from fibermelt.flow.problem import Deposition

__all__ = ["field_of", "projections", "with_error"]

Array = NDArray[np.float64]

PIN = 1e-10
"""Mass added to the stream function's matrix: its constant is free until set on the bed."""

EXTRA_QUADRATURE = 2
"""Added order of quadrature, for elements with a curved edge."""


def _fits(space: Any, matrix: Any, loads: list[Any]) -> list[ng.GridFunction]:
    """Return what fits each of ``loads`` best in the sense of ``matrix``, by one factorisation."""
    measure = ng.dx(bonus_intorder=EXTRA_QUADRATURE)
    form = CondensedForm(space, [matrix * measure], "sparsecholesky", symmetric=True)
    form.factorise()
    fits = []
    for load in loads:
        right = ng.LinearForm(space)
        right += load * measure
        with ng.TaskManager():
            right.Assemble()
        fit = ng.GridFunction(space)
        fit.vec.data = form.solve(right.vec)[0]
        fits.append(fit)
    return fits


def projections(mesh: ng.Mesh, order: int, functions: list[Any]) -> list[ng.GridFunction]:
    """Return the L2 projections of ``functions`` on continuous ones of degree ``order``."""
    space = ng.H1(mesh, order=order)
    trial, test = space.TnT()
    return _fits(space, trial * test, [function * test for function in functions])


def _stream_function(flow: FreeSurfaceFlow) -> ng.GridFunction:
    """Return ``psi`` of degree one above the velocity's, the best fit of ``rot psi`` to ``u``."""
    space = ng.H1(flow.mesh, order=flow.order + 1)
    psi, test = space.TnT()
    u, slope = flow.velocity, ng.grad(test)
    matrix = ng.grad(psi) * slope + PIN * psi * test
    return _fits(space, matrix, [u[0] * slope[1] - u[1] * slope[0]])[0]


def _numbering(vertices: NDArray[np.int64], order: int) -> tuple[NDArray[np.int64], int]:
    """Return the shared node numbers (n_cells, n_local) of triangles given by vertex, and a count.

    Nodes on an edge are counted from its lower to its higher vertex, so both sides agree.
    """
    n_cells = len(vertices)
    n_edge = order - 1
    ends = vertices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    edge = edge.reshape(-1)
    along = np.where((ends[:, 0] < ends[:, 1])[:, None], np.arange(n_edge), np.arange(n_edge)[::-1])
    first_edge = int(vertices.max()) + 1
    on_edges = (first_edge + edge[:, None] * n_edge + along).reshape(n_cells, 3 * n_edge)
    first_inside = first_edge + (int(edge.max()) + 1) * n_edge
    n_inside = (order - 1) * (order - 2) // 2
    inside = first_inside + np.arange(n_cells * n_inside).reshape(n_cells, n_inside)
    return np.hstack([vertices, on_edges, inside]), first_inside + n_cells * n_inside


def field_of(flow: FreeSurfaceFlow, problem: Deposition, *, stream: bool = True) -> FlowField:
    """Return the flow as a `FlowField` in SI units.

    Parameters
    ----------
    flow : FreeSurfaceFlow
        A solved flow, in units of capillary width, bed speed and the viscosity at their rate.
    problem : Deposition
        What it solves: those units, and the melt.
    stream : bool
        With the stream function, a third of the work; it is zero without.

    Notes
    -----
    Nodes are those of degree one above the velocity's, so that the stream function, which has that
    degree, loses nothing. The gradient of the velocity jumps between elements; its L2 projection
    on continuous functions of the velocity's degree is three times nearer to that of a fine mesh
    than one of the pressure's degree (pressure extremes: 4e-4 against 1e-3, in the median). What
    trace is left (the discretisation's divergence) is taken out: half of it from each normal
    component.
    """
    mesh, order = flow.mesh, flow.order + 1
    length, speed = problem.nozzle.capillary_width, problem.bed_speed
    slope = ng.Grad(flow.velocity)
    parts = [slope[0, 0] - slope[1, 1], slope[0, 1], slope[1, 0]]
    gradient = projections(mesh, flow.order, parts)
    psi = _stream_function(flow) if stream else ng.CF(0.0)
    # the solver's reference triangle has its corners at (1,0), (0,1), (0,0)
    nodes = LagrangeTriangle(order).nodes
    reference = np.column_stack([1 - nodes.sum(axis=1), nodes[:, 0]])
    rule = ng.IntegrationRule([tuple(map(float, r)) for r in reference], [0.0] * len(reference))
    at = mesh.MapToAllElements(rule, ng.VOL)
    sampled = ng.CF((ng.x, ng.y, flow.velocity, flow.pressure, *gradient, psi))(at)
    vertices = np.array([[v.nr for v in el.vertices] for el in mesh.Elements(ng.VOL)])
    cells, count = _numbering(vertices, order)
    values = np.empty((count, sampled.shape[1]))
    values[cells.reshape(-1)] = sampled
    used = np.unique(cells)
    renumber = np.full(count, -1, dtype=np.int64)
    renumber[used] = np.arange(len(used))
    values, cells = values[used], renumber[cells]
    half, xy, yx = values[:, 5] / 2, values[:, 6], values[:, 7]
    L = np.stack([np.stack([half, xy], axis=-1), np.stack([yx, -half], axis=-1)], axis=1)
    bed = np.argmin(np.abs(values[:, 1]) + 1e-3 * np.abs(values[:, 0]))
    from_bed = values[:, 8] - values[bed, 8]
    rate = np.sqrt(4 * half**2 + (xy + yx) ** 2) * problem.rate_scale
    return FlowField(
        order=order,
        points=values[:, :2] * length,
        cells=cells,
        velocity=values[:, 2:4] * speed,
        pressure=values[:, 4] * problem.stress_scale,
        gradient=L * problem.rate_scale,
        stream_function=from_bed * (speed * length),
        viscosity=problem.melt.viscosity_at(rate),
        gradient_error=np.zeros(len(values)),
    )


def with_error(field: FlowField, coarser: FlowField) -> FlowField:
    """Return ``field`` with its gradient's error estimated: what differs from a coarser mesh's.

    Nodes that the coarser mesh does not hold (the surfaces differ by their error) take the error
    of the nearest node that it does.
    """
    place = coarser.locate(field.points)
    difference = field.gradient - coarser.evaluate(coarser.gradient, place)
    error = np.linalg.norm(difference, axis=(1, 2))
    known = place.found
    nearest = cKDTree(field.points[known]).query(field.points[~known])[1]
    error[~known] = error[known][nearest]
    return replace(field, gradient_error=error)
