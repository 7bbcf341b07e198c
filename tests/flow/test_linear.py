"""Linear solves of the free-surface flow: elimination inside elements, Stokes without pivots."""

from __future__ import annotations

import ngsolve as ng
import numpy as np
import pytest

from fibermelt.errors import ConvergenceError
from fibermelt.flow.dieswell import swell_problem
from fibermelt.flow.forms import MeltStress, Unknowns, ViscousStress, stokes_form
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.linear import LARGEST_RESIDUAL, CondensedForm, solve_at_rest
from fibermelt.flow.spaces import elements_of, spaces_on

pytestmark = pytest.mark.verification

ORDERS = [2, 3, 5]


@pytest.mark.parametrize("order", ORDERS)
def test_flow_at_rest_is_that_of_a_direct_solve(order: int) -> None:
    """The same Stokes problem by UMFPACK, all unknowns at once and no compressibility."""
    mesh, boundaries = swell_problem(0.05)
    flow = FreeSurfaceFlow(mesh, boundaries, order)
    space, elements = spaces_on(mesh, boundaries, order).flow, elements_of(mesh, boundaries)
    trial, test = space.TnT()
    form = ng.BilinearForm(space)
    one = ViscousStress(ng.Grad(trial[0]))
    stress = MeltStress(elements, one, one)
    for term in stokes_form(Unknowns(trial, test, None, None), stress):
        form += term
    form.Assemble()
    direct = ng.GridFunction(space)
    inlet = mesh.BoundaryCF({"inlet": ng.CF((1.5 * (1 - ng.y**2), 0))}, default=ng.CF((0, 0)))
    direct.components[0].Set(inlet, definedon=mesh.Boundaries(boundaries.given))
    given = direct.vec.FV().NumPy().copy()
    inverse = form.mat.Inverse(space.FreeDofs(), inverse="umfpack")
    direct.vec.data -= inverse * (form.mat * direct.vec)

    found = flow._state.vec.FV().NumPy()[: space.ndof]
    fixed = ~np.fromiter(space.FreeDofs(), dtype=bool, count=space.ndof)
    np.testing.assert_array_equal(found[fixed], given[fixed])
    for part in (space.Range(0), space.Range(1)):
        expected = direct.vec.FV().NumPy()[part.start : part.stop]
        # the residual ends at 1e-8 of the first; the pressure at the lip magnifies it tenfold
        bound = 10 * LARGEST_RESIDUAL * np.abs(expected).max()
        np.testing.assert_allclose(found[part.start : part.stop], expected, rtol=0, atol=bound)


@pytest.mark.parametrize("order", ORDERS)
def test_eliminated_unknowns_are_those_of_the_whole_matrix(order: int) -> None:
    mesh, boundaries = swell_problem(0.05)
    flow = FreeSurfaceFlow(mesh, boundaries, order)
    flow.step()
    right = flow._residual.vec.CreateVector()
    numbers = np.random.default_rng(1).standard_normal(len(right))
    right.FV().NumPy()[:] = np.where(flow._matrix.free, numbers, 0.0)
    flow._matrix.factorise()
    solution = flow._matrix.checked(right).FV().NumPy()

    whole = ng.BilinearForm(flow._space)
    for term in flow._jacobian:
        whole += term
    whole.Assemble()
    left, vector = right.CreateVector(), right.CreateVector()
    vector.FV().NumPy()[:] = solution
    left.data = whole.mat * vector - right
    size = np.linalg.norm(left.FV().NumPy()[flow._matrix.free])
    assert size < LARGEST_RESIDUAL * np.linalg.norm(right.FV().NumPy())
    assert not solution[~flow._matrix.free].any()


def test_every_unknown_left_has_an_equation() -> None:
    """The spaces hold nothing that the coupled problem does not ask for."""
    mesh, boundaries = swell_problem(0.1)
    spaces = spaces_on(mesh, boundaries, 3)
    components = spaces.coupled.components
    assert components[2].ndof == len(spaces.moves) == components[2].FreeDofs().NumSet()
    assert components[3].ndof == components[3].FreeDofs().NumSet()
    edges = mesh.Boundaries(boundaries.free).Elements()
    # three edges' unknowns each and a vertex between, none at the lip
    assert components[3].ndof == 3 * len(list(edges))


def test_a_lost_solution_is_said() -> None:
    """Stokes without a free end: the pressure's level is not determined."""
    mesh = ng.Mesh(ng.unit_square.GenerateMesh(maxh=0.5))
    space = ng.VectorH1(mesh, order=2, dirichlet=".*") * ng.H1(mesh, order=1)
    (u, p), (v, q) = space.TnT()
    terms = [(ng.InnerProduct(ng.Grad(u), ng.Grad(v)) - p * ng.div(v) - q * ng.div(u)) * ng.dx]
    form = CondensedForm(space, terms, "umfpack", symmetric=False)
    form.factorise()
    load = ng.LinearForm(q * ng.dx).Assemble().vec
    with pytest.raises(ConvergenceError, match="singular to working precision"):
        form.checked(load)


def test_refinement_that_does_not_end_is_said() -> None:
    mesh, boundaries = swell_problem(0.1)
    spaces, elements = spaces_on(mesh, boundaries, 2), elements_of(mesh, boundaries)
    state = ng.GridFunction(spaces.flow)
    _, test = spaces.flow.TnT()
    residual = ng.LinearForm(spaces.flow)
    residual += ng.InnerProduct(ng.CF((1, 1)), test[0]) * ng.dx  # does not see the state
    with pytest.raises(ConvergenceError, match="singular to working precision"):
        solve_at_rest(spaces.flow, elements, state.vec, residual, boundaries)
