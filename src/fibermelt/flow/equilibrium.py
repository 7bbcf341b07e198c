"""The flow of a melt that thins, on a mesh that is held: Newton's method with a line search.

It goes before the mesh moves, and between the steps of flow and mesh together: these alone
converge for melts that hardly thin only. A viscosity that is known, one everywhere or that of the
mesh before, is led to the law's by a power: ``eta_known^(1 - t) eta^t``, ``t`` from 0 to 1.
"""

from __future__ import annotations

from typing import Any

import ngsolve as ng
import numpy as np

from fibermelt.errors import ConvergenceError
from fibermelt.flow.linear import load_of, without_pivots

__all__ = ["Equilibration"]

SMALLEST_SHARE = 0.02
"""Smallest step on the way from a known viscosity to the law's, of which the whole is 1."""

ROUGHLY, SETTLED = 1e-2, 1e-5
"""Residual left, in parts of that without any motion: on the way to the law, and of the law itself.
What is left the coupled step takes with it."""

MAX_STEPS = 25
"""Newton's steps for one law on one mesh."""

SEARCHES, FLAT_ENOUGH = 3, 0.5
"""Places along a step that are tried, and the part of the first slope at which one is good."""


class Equilibration:
    """Brings velocity and pressure to equilibrium on the mesh as it lies.

    Parameters
    ----------
    space : product space
        Velocity and pressure.
    terms : list of forms
        The derivative of the residual with them (`stokes_form`), symmetric.
    state : vector
        Velocity and pressure, which it corrects; the velocity has its given values.
    residual : form
        Its first entries are those of momentum and mass at ``state``.
    thinning : ng.Parameter
        The power ``t`` in both.
    scale : float
        Norm of the residual of a melt of viscosity one that moves at its boundaries only.

    Raises
    ------
    ConvergenceError
        If no way leads to the flow of this law.
    """

    def __init__(
        self,
        space: Any,
        terms: list[Any],
        state: ng.BaseVector,
        residual: ng.LinearForm,
        thinning: ng.Parameter,
        scale: float,
    ) -> None:
        """Find the flow of the law, from that of the known viscosity."""
        self._matrix = without_pivots(space, terms)
        self._state, self._residual, self._thinning = state, residual, thinning
        self._velocities = space.components[0].ndof
        self._scale = scale
        self._thinning.Set(0.0)
        self.settle(ROUGHLY)
        self._lead()

    def _load(self) -> tuple[ng.BaseVector, float]:
        return load_of(self._matrix.free, self._state, self._residual)

    def _lead(self) -> None:
        """Raise the power to one: at once, or in steps that are halved where they fail."""
        reached, step = 0.0, 1.0
        kept = self._state.CreateVector()
        while reached < 1.0:
            kept.data = self._state
            wanted = min(1.0, reached + step)
            self._thinning.Set(wanted)
            if self.settle(ROUGHLY if wanted < 1.0 else SETTLED):
                reached = wanted
                continue
            self._state.data = kept
            step /= 2
            if step < SMALLEST_SHARE:
                msg = (
                    "deposition flow: no flow of this melt was found on a fixed mesh, beyond "
                    f"{reached:.0%} of its thinning; raise melt.index, or give the melt an "
                    "melt.infinite_viscosity"
                )
                raise ConvergenceError(msg)

    def settle(self, tolerance: float = SETTLED) -> bool:
        """Correct the flow on the mesh as it is; return whether its residual became small."""
        bound = tolerance * self._scale
        right, size = self._load()
        for _ in range(MAX_STEPS):
            if size <= bound:
                return True
            self._matrix.factorise()
            move = self._matrix.solve(right)[0]
            right, size = self._searched(right, move, bound)
        return size <= bound

    def _power(self, right: ng.BaseVector, move: ng.BaseVector) -> float:
        """Return the power of the residual's forces in a move: the slope of the potential along it.

        The flow of a given law is where a convex potential (half the dissipation, if Newtonian)
        is least among velocities without divergence. Pressure has no part in it.
        """
        pair = (vector.FV().NumPy()[: self._velocities] for vector in (right, move))
        return float(np.dot(*pair))

    def _searched(
        self, right: ng.BaseVector, move: ng.BaseVector, bound: float
    ) -> tuple[ng.BaseVector, float]:
        """Go along a move to where the potential is least, by the secant of its slope.

        Newton's full step overshoots where a melt thins much; backtracking on the residual's norm
        instead takes twice the steps.
        """
        slope, taken, wanted = self._power(right, move), 0.0, 1.0
        for _ in range(SEARCHES):
            self._state.data -= (wanted - taken) * move
            taken = wanted
            right, left = self._load()
            here = self._power(right, move)
            if left <= bound or abs(here) <= FLAT_ENOUGH * abs(slope):
                break
            zero = taken * slope / (slope - here) if here != slope else 2.0 * taken
            wanted = min(max(zero, 0.1 * taken), 2.0 * taken)
        return right, left
