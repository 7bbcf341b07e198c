"""Fields on tetrahedra as plain arrays: what is left of a bead once the solver is gone."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.problem import BeadDeposition
from fibermelt.flow.recover import projections

__all__ = ["BeadField", "bead_field_of"]

Array = NDArray[np.float64]

SAME_NODE = 1e-7
"""Nodes of neighbours this near [diameters] are one: above rounding, below any edge."""

FACES = ((0, 1, 3), (1, 2, 3), (2, 0, 3), (0, 2, 1))
"""Faces of a tetrahedron in VTK's order."""

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
"""Its edges, likewise."""


@dataclass(frozen=True, eq=False)
class BeadField:
    """A flow in space on curved tetrahedra, in SI units; z >= 0, the rest is its mirror image.

    Parameters
    ----------
    order : int
        Degree of the elements, 2 or 3; their nodes are in VTK's order for Lagrange tetrahedra.
    points : (n, 3) array
        Nodes [m]; x along the bed, y up from it, z across.
    cells : (n_cells, n_local) int array
        Nodes of each tetrahedron.
    velocity : (n, 3) array
        Velocity [m/s].
    pressure : (n,) array
        Pressure [Pa].
    gradient : (n, 3, 3) array
        ``L[..., i, j] = d u_i / d x_j`` [1/s], without trace.
    divergence : (n,) array
        The trace that was taken out of it [1/s], a third from each normal component.
    viscosity : (n,) array
        Viscosity [Pa s].
    gradient_error : (n,) array
        Estimated error of the gradient [1/s], Frobenius: what it differs from that of the elements
        around by.
    """

    order: int
    points: Array
    cells: NDArray[np.int64]
    velocity: Array
    pressure: Array
    gradient: Array
    divergence: Array
    viscosity: Array
    gradient_error: Array


def _nodes(order: int) -> Array:
    """Return barycentric coordinates (n_local, 4) of the nodes of a tetrahedron, in VTK's order."""
    corners = np.eye(4)
    nodes = [*corners]
    for first, last in EDGES:
        steps = np.arange(1, order) / order
        nodes += [(1 - s) * corners[first] + s * corners[last] for s in steps]
    if order == 3:
        nodes += [corners[list(face)].mean(axis=0) for face in FACES]
    return np.array(nodes)


def bead_field_of(flow: FreeSurfaceFlow, problem: BeadDeposition) -> BeadField:
    """Return a solved flow as a `BeadField`.

    Notes
    -----
    The gradient jumps between elements: it is projected (L2) on continuous functions of the
    velocity's degree, and what trace is left is taken out, a third from each normal component.
    """
    mesh, order = flow.mesh, flow.order
    slope = ng.Grad(flow.velocity)
    parts = [slope[i, j] for i, j in itertools.product(range(3), repeat=2)]
    recovered = projections(mesh, order, parts)
    barycentric = _nodes(order)
    # the solver's reference tetrahedron has its corners at e_x, e_y, e_z and 0
    nodes = [tuple(map(float, node[:3])) for node in barycentric]
    rule = ng.IntegrationRule(nodes, [0.0] * len(nodes))
    at = mesh.MapToAllElements(rule, ng.VOL)
    values = ng.CF((ng.x, ng.y, ng.z, flow.velocity, flow.pressure, *recovered, *parts))
    sampled = np.asarray(values(at))
    keys = np.rint(sampled[:, :3] / SAME_NODE).astype(np.int64)
    _, first, node = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    node = node.reshape(-1)
    L = sampled[:, 7:16].reshape(-1, 3, 3)
    trace = np.trace(L, axis1=1, axis2=2)
    L = L - (trace / 3)[:, None, None] * np.eye(3)
    miss = np.linalg.norm(sampled[:, 16:25].reshape(-1, 3, 3) - L, axis=(1, 2)) ** 2
    error = np.sqrt(np.bincount(node, miss) / np.bincount(node))
    L = L[first]
    rate = np.sqrt(0.5) * np.linalg.norm(L + L.transpose(0, 2, 1), axis=(1, 2))
    units = problem.rate_scale
    return BeadField(
        order=order,
        points=sampled[first, :3] * problem.nozzle.capillary_width,
        cells=node.reshape(-1, len(barycentric)),
        velocity=sampled[first, 3:6] * problem.bed_speed,
        pressure=sampled[first, 6] * problem.stress_scale,
        gradient=L * units,
        divergence=trace[first] * units,
        viscosity=problem.melt.viscosity_at(rate * units),
        gradient_error=error * units,
    )
