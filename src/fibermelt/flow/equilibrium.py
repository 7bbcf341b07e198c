"""The flow of a melt that thins on a mesh that is held, where the steps of flow and mesh begin."""

from __future__ import annotations

from typing import Any

import ngsolve as ng

from fibermelt.errors import ConvergenceError
from fibermelt.flow.forms import MeltStress, Unknowns, stokes_form
from fibermelt.flow.linear import load_of, without_pivots
from fibermelt.flow.spaces import Boundaries

__all__ = ["Equilibrium"]

SETTLED = 1e-3
"""Residual left, in parts of that of a Newtonian melt that moves at its boundaries only; the steps
of flow and mesh take it with them. Ten times less saves one of 19 such steps for an index of 0.25,
and takes half as many again of the others; without any between them some flows are not found: the
few elements at a lip need more steps than all others."""

MAX_STEPS = 40
"""Newton steps; 3 to 10 are taken on the first mesh, 1 to 4 on others, 0 to 2 between the steps of
flow and mesh."""


class Equilibrium:
    """Brings velocity and pressure nearly to equilibrium on the mesh as it lies.

    Parameters
    ----------
    space : product space
        Velocity and pressure.
    stress : MeltStress
        Of a melt that thins.
    state : vector
        Velocity and pressure, which it corrects; the velocity has its given values.
    residual : form
        Its first entries are those of momentum and mass at ``state``; of a Newtonian melt that
        moves at its boundaries only as yet.
    boundaries : Boundaries
        Their film, if they have one, holds the melt too.
    """

    def __init__(
        self,
        space: Any,
        stress: MeltStress,
        state: ng.BaseVector,
        residual: ng.LinearForm,
        boundaries: Boundaries,
    ) -> None:
        trial, test = space.TnT()
        unknowns = Unknowns(trial, test, None, None)
        terms = stokes_form(unknowns, stress, boundaries.free, boundaries.film)
        self._matrix = without_pivots(space, terms)
        self._stress, self._state, self._residual = stress, state, residual
        self._bound = SETTLED * self._load()[1]

    def _load(self) -> tuple[ng.BaseVector, float]:
        return load_of(self._matrix.free, self._state, self._residual)

    def settle(self) -> None:
        """Correct the flow until little of its residual is left.

        Raises
        ------
        ConvergenceError
            If the steps do not end.
        """
        for _ in range(MAX_STEPS):
            right, size = self._load()
            if size <= self._bound:
                return
            self._matrix.factorise()
            self._state -= self._matrix.solve(right)[0]
            self._stress.follow()
        msg = (
            f"deposition flow: no flow of this melt was found on a fixed mesh in {MAX_STEPS} "
            "steps; raise melt.index, or give the melt an melt.infinite_viscosity"
        )
        raise ConvergenceError(msg)
