"""The flow of a melt that thins on a mesh that is held: where the steps of flow and mesh begin."""

from __future__ import annotations

from typing import Any

import ngsolve as ng

from fibermelt.errors import ConvergenceError
from fibermelt.flow.forms import MeltStress, Unknowns, stokes_form
from fibermelt.flow.linear import load_of, without_pivots

__all__ = ["equilibrate"]

SETTLED = 1e-3
"""Residual left, in parts of that of a Newtonian melt that moves at its boundaries only. The steps
of flow and mesh take it with them: with 1e-9 they are as many, with 1e-2 a third more, and some
flows of an index of 0.25 are not found."""

MAX_STEPS = 40
"""Newton steps; 3 to 10 are taken on the first mesh, 1 to 4 on others."""


def equilibrate(
    space: Any, stress: MeltStress, state: ng.BaseVector, residual: ng.LinearForm, scale: float
) -> None:
    """Bring velocity and pressure nearly to equilibrium on the mesh as it lies.

    Parameters
    ----------
    space : product space
        Velocity and pressure.
    stress : MeltStress
        Of a melt that thins, with the strain that it starts from.
    state : vector
        Velocity and pressure, which it corrects; the velocity has its given values.
    residual : form
        Its first entries are those of momentum and mass at ``state``.
    scale : float
        Norm of the residual of a Newtonian melt that moves at its boundaries only.

    Raises
    ------
    ConvergenceError
        If the steps do not end.
    """
    trial, test = space.TnT()
    matrix = without_pivots(space, stokes_form(Unknowns(trial, test, None, None), stress))
    for _ in range(MAX_STEPS):
        right, size = load_of(matrix.free, state, residual)
        if size <= SETTLED * scale:
            return
        matrix.factorise()
        state -= matrix.solve(right)[0]
        stress.follow()
    msg = (
        f"deposition flow: no flow of this melt was found on a fixed mesh in {MAX_STEPS} steps; "
        "raise melt.index, or give the melt an melt.infinite_viscosity"
    )
    raise ConvergenceError(msg)
