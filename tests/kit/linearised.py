"""A flow's Jacobian beside differences of its residual, in a random direction of all unknowns."""

from __future__ import annotations

import ngsolve as ng
import numpy as np

from fibermelt.flow.freesurface import FreeSurfaceFlow

STEP = 1e-4
"""Of the central differences."""


def linearised(flow: FreeSurfaceFlow, shift: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the Jacobian times a direction, and what differences of the residual say of it.

    Parameters
    ----------
    flow : FreeSurfaceFlow
        After a step.
    shift : float
        How far nodes of the mesh go in that direction, small enough to keep the elements whole.
    """
    free = flow._matrix.free
    in_mesh = slice(flow._ranges[2].start, flow._ranges[2].stop)
    direction = np.where(free, np.random.default_rng(0).standard_normal(len(free)), 0.0)
    direction[in_mesh] *= shift
    direction[flow._ranges[3].start :] = 0.0  # the multiplier is no part of the residual
    start = flow._state.vec.FV().NumPy().copy()
    placed = flow.displacement.vec.FV().NumPy().copy()
    moved = np.zeros_like(placed)
    moved[flow._moves] = direction[in_mesh]

    def residual(step: float) -> np.ndarray:
        flow._state.vec.FV().NumPy()[:] = start + step * direction
        flow.displacement.vec.FV().NumPy()[:] = placed + step * moved
        flow.mesh.SetDeformation(flow.displacement)
        for held in flow._stress.held:
            held.hold(held.present)
        flow._residual.Assemble()
        return flow._residual.vec.FV().NumPy().copy()

    difference = (residual(STEP) - residual(-STEP)) / (2 * STEP)
    residual(0.0)
    jacobian = ng.BilinearForm(flow._space)
    for term in flow._jacobian:
        jacobian += term
    jacobian.Assemble()
    product = flow._residual.vec.CreateVector()
    vector = flow._residual.vec.CreateVector()
    vector.FV().NumPy()[:] = direction
    product.data = jacobian.mat * vector
    return product.FV().NumPy().copy(), difference
