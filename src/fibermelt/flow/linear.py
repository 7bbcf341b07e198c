"""Linear systems whose inner unknowns are eliminated element by element, and Stokes at rest."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from fibermelt.errors import ConvergenceError
from fibermelt.flow.forms import Elements, MeltStress, Unknowns, ViscousStress, stokes_form
from fibermelt.flow.spaces import Boundaries

__all__ = ["CondensedForm", "load_of", "solve_at_rest", "without_pivots"]

Array = NDArray[np.float64]

LARGEST_RESIDUAL = 1e-8
"""Largest relative residual of a linear solve; above it the factorisation has lost the answer."""

COMPRESSIBILITY = 1e-10
"""Pressure mass over viscosity in the Stokes matrix, so that sparse Cholesky needs no pivots. It
is not in the residual: the first solve leaves 1e-9 of it, each further one takes as much again."""

MAX_PASSES = 6
"""Passes of refinement; one is enough, more than five others are a failure."""


def _singular(left: float, size: float) -> ConvergenceError:
    return ConvergenceError(
        f"the linear solve left a residual of {left:.2e} against {size:.2e}: the matrix "
        "is singular to working precision: near the last gap or bed speed with a steady surface "
        "lower flow.gap or flow.bed_speed, elsewhere try a longer numerics.contact_edge or lip_edge"
    )


@cache
def _libraries() -> ThreadpoolController:
    """Return the loaded BLAS, looked for once: that takes 2 ms."""
    return ThreadpoolController()


@contextmanager
def _one_thread() -> Iterator[None]:
    """Factorise and solve on one thread.

    The fronts of a planar problem are too small for more: waiting threads cost up to five times
    the work on a busy machine. Sparse Cholesky on several sums in the order in which they come,
    and another last bit is enough for another mesh.
    """
    threads = ng.GetNumThreads()
    ng.SetNumThreads(1)
    try:
        with _libraries().limit(limits=1, user_api="blas"):
            yield
    finally:
        ng.SetNumThreads(threads)


class CondensedForm:
    """A bilinear form, its factors, and solves with them.

    The unknowns inside elements (a tenth of all at degree 3) are eliminated before the
    factorisation, which for the coupled matrix then takes two thirds of the time, a solve half.
    """

    def __init__(self, space: Any, terms: list[Any], solver: str, *, symmetric: bool) -> None:
        """Set up the sum of ``terms`` on ``space``; ``solver`` is NGSolve's name of one."""
        self.free = np.fromiter(space.FreeDofs(), dtype=bool, count=space.ndof)
        self._form = ng.BilinearForm(space, symmetric=symmetric, condense=True)
        for term in terms:
            self._form += term.Compile()
        self._outer = space.FreeDofs(coupling=True)
        self._solver = solver

    def factorise(self) -> None:
        """Assemble the form as things are now, on all cores, and factorise it."""
        with ng.TaskManager():
            self._form.Assemble()
        with _one_thread():
            self._inverse = self._form.mat.Inverse(self._outer, inverse=self._solver)

    def release(self) -> None:
        """Let the factors go, most of what a large flow keeps; a next solve needs new ones."""
        self._inverse = None

    def solve(self, right: ng.BaseVector) -> tuple[ng.BaseVector, float]:
        """Return the solution for ``right``, zero where not free, and the residual it leaves."""
        form, outer = self._form, ng.Projector(self._outer, True)
        load, left, solution = (right.CreateVector() for _ in range(3))
        with _one_thread():
            load.data = right + form.harmonic_extension_trans * right
            solution.data = self._inverse * load
            left.data = load - form.mat * solution
            left.data = outer * left
            solution.data += form.harmonic_extension * solution
            solution.data += form.inner_solve * right
        return solution, float(ng.Norm(left))

    def checked(self, right: ng.BaseVector) -> ng.BaseVector:
        """Return the solution for ``right``.

        Raises
        ------
        ConvergenceError
            If the factorisation has lost it.
        """
        solution, left = self.solve(right)
        size = float(ng.Norm(right))
        if not left <= LARGEST_RESIDUAL * max(size, LARGEST_RESIDUAL):
            raise _singular(left, size)
        return solution


def solve_at_rest(
    space: Any,
    elements: Elements,
    state: ng.BaseVector,
    residual: ng.LinearForm,
    boundaries: Boundaries,
) -> float:
    """Solve Stokes on the mesh as it is: correct ``state`` until hardly any residual is left.

    Returns the norm of the residual that it started from.

    Parameters
    ----------
    space : product space
        Velocity and pressure.
    elements : Elements
        How they are integrated.
    state : vector
        Velocity and pressure; the velocity has its given values.
    residual : form
        Its first entries are those of momentum and mass at ``state``.
    boundaries : Boundaries
        Their film, if they have one, holds the melt too.

    Raises
    ------
    ConvergenceError
        If refinement does not end.
    """
    trial, test = space.TnT()
    stress = ViscousStress(ng.Grad(trial[0]))
    melt, unknowns = MeltStress(elements, stress, stress), Unknowns(trial, test, None, None)
    terms = stokes_form(unknowns, melt, boundaries.free, boundaries.film)
    matrix = without_pivots(space, terms)
    matrix.factorise()
    first = 0.0
    for count in range(MAX_PASSES):
        right, size = load_of(matrix.free, state, residual)
        first = first if count else size
        if size <= LARGEST_RESIDUAL * first:
            return first
        state.data -= matrix.solve(right)[0]
    raise _singular(size, first)


def without_pivots(space: Any, terms: list[Any]) -> CondensedForm:
    """Return the form of the flow on a fixed mesh, made so that sparse Cholesky can have it."""
    trial, test = space.TnT()
    squeeze = -COMPRESSIBILITY * trial[1] * test[1] * ng.dx
    return CondensedForm(space, [*terms, squeeze], "sparsecholesky", symmetric=True)


def load_of(
    free: NDArray[np.bool_], state: ng.BaseVector, residual: ng.LinearForm
) -> tuple[ng.BaseVector, float]:
    """Return the residual's entries of momentum and mass, zero where not free, and their norm."""
    with ng.TaskManager():
        residual.Assemble()
    right = state.CreateVector()
    right.FV().NumPy()[:] = np.where(
        free[: len(right)], residual.vec.FV().NumPy()[: len(right)], 0.0
    )
    return right, float(ng.Norm(right))
