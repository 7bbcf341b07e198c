"""Planar Newtonian die swell: the free surface against the literature, and its orders."""

from __future__ import annotations

import ngsolve as ng
import numpy as np
import pytest
from linearised import linearised

from fibermelt.flow.dieswell import solve_die_swell, swell_problem
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.strain import HeldStrain
from fibermelt.melt import CarreauYasuda, Newtonian, PowerLaw, ViscosityLaw
from fibermelt.verify.free_surface import SWELL

pytestmark = pytest.mark.verification


def test_swell_at_the_stated_lip_edge() -> None:
    assert solve_die_swell(0.002).swell == pytest.approx(SWELL, abs=1e-3)


@pytest.mark.parametrize("order", [2, 3])
def test_swell_converges_at_first_order_of_the_lip_edge(order: int) -> None:
    edges = [0.004, 0.002, 0.001, 0.0005]
    swell = np.array([solve_die_swell(edge, order=order).swell for edge in edges])
    steps = -np.diff(swell)
    assert np.all(steps > 0)
    # the lip's singularity (stress ~ r^-1/2) leaves order one whatever the degree
    observed = np.log2(steps[:-1] / steps[1:])
    assert np.all(np.abs(observed - 1.0) < 0.35), observed
    extrapolated = 2 * swell[-1] - swell[-2]
    assert extrapolated == pytest.approx(SWELL, abs=1e-4)


def test_swell_does_not_depend_on_the_mesh_away_from_the_lip() -> None:
    reference = solve_die_swell(0.002).swell
    for bulk_edge in (0.2, 0.5):
        swell = solve_die_swell(0.002, bulk_edge=bulk_edge).swell
        assert swell == pytest.approx(reference, abs=5e-5)
    # slower growth also refines around the lip: it may move the swell by the lip's own error
    assert abs(solve_die_swell(0.002, growth=0.15).swell - reference) < reference - SWELL


def test_newton_is_quadratic() -> None:
    mesh, boundaries = swell_problem(0.02)
    flow = FreeSurfaceFlow(mesh, boundaries, 3)
    sizes = [flow.step().size for _ in range(4)]
    # each step is the square of the last, times the problem's own constant (6 was seen);
    # at a linear rate the last step would be 1e-7 at best
    assert sizes[2] < 10 * sizes[1] ** 2
    assert sizes[3] < 10 * sizes[2] ** 2


@pytest.mark.parametrize("law", [None, CarreauYasuda(2.0, 0.4, 1.0)])
def test_linearisation_is_exact(law: ViscosityLaw | None) -> None:
    """The Jacobian against differences of the residual, in a random direction of all unknowns."""
    mesh, boundaries = swell_problem(0.1, law=law)
    flow = FreeSurfaceFlow(mesh, boundaries, 3, law)
    flow.step()
    exact, difference = linearised(flow, shift=1e-3)
    rows = flow._matrix.free.copy()
    in_mesh = slice(flow._ranges[2].start, flow._ranges[2].stop)
    rows[in_mesh] = False  # these rows say how the mesh follows, not what must vanish
    error = np.abs(difference - exact)[rows].max() / np.abs(exact)[rows].max()
    assert error < (1e-7 if law is None else 1e-5)  # central differences of step 1e-4


def test_poiseuille_flow_upstream_is_exact() -> None:
    mesh, boundaries = swell_problem(0.05)
    flow = FreeSurfaceFlow(mesh, boundaries, 3)
    for _ in range(5):
        flow.step()
    mesh.UnsetDeformation()
    slope = (flow.pressure(mesh(-3.5, 0.3)) - flow.pressure(mesh(-2.5, 0.3))) / 1.0
    assert slope == pytest.approx(3.0, rel=1e-5)  # dp/dx = -3 mu U / H^2; the lip is felt as e^-4x
    parabola = ng.CF(1.5 * (1 - ng.y**2))
    miss = [abs(flow.velocity(mesh(-3.0, y))[0] - parabola(mesh(-3.0, y))) for y in (0.1, 0.5, 0.9)]
    assert max(miss) < 1e-5


# Powers of the rate of 0.8 and 0.5, level a thousandth of the wall's rate below which: the values
# to which P3 on ever finer lips converges (0.02, 0.01, 0.005 half-widths: 1.12789, 1.12704,
# 1.12664; 1.04449, 1.04474, 1.04484), of order about one; another code extrapolates to the same.
POWER_LAW_SWELL = {0.8: 1.1263, 0.5: 1.0449}


@pytest.mark.parametrize("index", POWER_LAW_SWELL)
def test_a_power_law_swells_less(index: float) -> None:
    wall_rate = 2 + 1 / index
    law = PowerLaw(wall_rate ** (1 - index), index, 1e-3 * wall_rate)
    found = solve_die_swell(0.005, law=law)
    # at this lip edge the Newtonian jet is 1e-3 too thick, and one that thins less
    assert found.swell == pytest.approx(POWER_LAW_SWELL[index], abs=1e-3)


@pytest.mark.parametrize(
    "law",
    [
        pytest.param(CarreauYasuda(1.0, 0.5, 1e-4), id="slow"),
        pytest.param(CarreauYasuda(2.0, 0.3, 1e7, infinite_viscosity=1.0), id="fast"),
        pytest.param(Newtonian(3.0), id="thick"),
    ],
)
def test_both_newtonian_limits_of_a_law_swell_alike(law: ViscosityLaw) -> None:
    newtonian = solve_die_swell(0.005).swell
    # what is left of the law in either limit is (lambda gamma_dot)^2 and ^(n - 1): 1e-6 and 2e-5
    assert solve_die_swell(0.005, law=law).swell == pytest.approx(newtonian, abs=1e-4)
    assert newtonian == pytest.approx(SWELL, abs=1.5e-3)  # the lip edge's own error, above


def test_a_thinning_melt_holds_the_strain_that_its_flow_has() -> None:
    """Newton's steps end where what is held is what deforms, and quadratically."""
    law = CarreauYasuda(2.0, 0.35, 1.0)
    mesh, boundaries = swell_problem(0.02, law=law)
    flow = FreeSurfaceFlow(mesh, boundaries, 3, law)
    sizes = [flow.step().size for _ in range(5)]
    # the square of the last, times the problem's own constant (30 was seen)
    assert sizes[3] < 100 * sizes[2] ** 2
    assert sizes[4] < 100 * sizes[3] ** 2
    for stress in flow._stress.held:
        held, present = (stress._stored[:3], stress.present.T)
        chosen = np.array([values[stress._chosen] for values in held]).T
        np.testing.assert_allclose(chosen, present, rtol=0, atol=1e-8 * np.abs(present).max())


@pytest.mark.parametrize("order", [6, 10])
def test_strain_is_held_at_the_points_of_the_order_asked_for(order: int) -> None:
    """A space of degree p has the rule of order 2 p: of degree 6 it has 49 points, and not 12."""
    mesh, _ = swell_problem(0.1)
    everywhere = ng.BitArray(mesh.ne)
    everywhere.Set()
    held = HeldStrain(mesh, PowerLaw(1.0, 0.25), ng.CF((0.0,) * 4, dims=(2, 2)), everywhere, order)
    points = ng.IntegrationRule(ng.ET.TRIG, order).points
    np.testing.assert_allclose(held.rules[ng.ET.TRIG].points, points, rtol=0, atol=1e-15)
    assert held.present.shape == (3, mesh.ne * len(points))


def test_a_strain_that_is_held_grows_no_further_than_the_flow() -> None:
    """Where the rate grows tenfold the tangent promises a hundredfold, for an index of 0.25."""
    law = PowerLaw(1.0, 0.25, 1e-6)
    mesh, _ = swell_problem(0.1)
    everywhere = ng.BitArray(mesh.ne)
    everywhere.Set()
    held = HeldStrain(mesh, law, ng.CF((10.0, 0.0, 0.0, -10.0), dims=(2, 2)), everywhere, 2)
    before = np.zeros_like(held.present)
    before[:2] = [[1.0], [-1.0]]
    held.hold(before)
    held.follow()
    found = np.array([values[held._chosen] for values in held._stored[:3]])
    np.testing.assert_allclose(found, 10.0 * before, rtol=1e-12, atol=1e-12)
    # and where it falls to nothing, the stress ahead, 1 - n of the one before, has (1 - n)^(1/n)
    still = HeldStrain(mesh, law, ng.CF((0.0, 0.0, 0.0, 0.0), dims=(2, 2)), everywhere, 2)
    still.hold(before)
    still.follow()
    found = np.array([values[still._chosen] for values in still._stored[:3]])
    np.testing.assert_allclose(found, 0.75**4 * before, rtol=1e-6, atol=1e-12)
