"""Derivatives of the closures: orders of differences, complex steps, coinciding eigenvalues."""

import numpy as np
import pytest

from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.orthotropic import WIDTH
from fibermelt.orientation.tensors import TANGENTS
from fibermelt.verify.closures import central, generic_tensors

pytestmark = pytest.mark.verification

EVERY = pytest.mark.parametrize("name", CLOSURES)
ANALYTIC = ["linear", "quadratic", "hybrid", "IBOF"]
SMOOTH = ["linear", "quadratic", "hybrid", "IBOF", "exact"]

RATE = np.array([[0.3, 1.0, 0.2], [1.0, -0.5, 0.4], [0.2, 0.4, 0.2]])


def rotation(seed):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


@EVERY
def test_central_differences_converge_with_second_order(name):
    law, a = CLOSURES[name], generic_tensors()
    exact = law.fourth_derivative(a, TANGENTS)
    coarse, fine = (np.abs(central(law, a, h) - exact).max() for h in (2e-3, 1e-3))
    if name in ("linear", "quadratic"):
        assert fine < 1e-12  # differences of polynomials up to the second degree are exact
    else:
        # The next term is of relative size (1e-3/0.1)^2 where the fits vary over a gap of 0.1.
        assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.05)
        assert fine < 1e-3


@pytest.mark.parametrize("name", ANALYTIC)
def test_complex_step(name):
    """Polynomials of the components continue to complex ones: no difference is formed."""
    law, a, step = CLOSURES[name], generic_tensors(), 1e-30
    exact = law.fourth_derivative(a, TANGENTS)
    stepped = law.fourth(a[:, None] + 1j * step * TANGENTS).imag / step
    # The coefficients of IBOF reach 1e10 and cancel to derivatives of order 1.
    assert np.allclose(stepped, exact, atol=1e-11, rtol=0)
    along = law.contract_derivative(a, RATE, TANGENTS)
    stepped = law.contract(a[:, None] + 1j * step * TANGENTS, RATE).imag / step
    assert np.allclose(stepped, along, atol=1e-11, rtol=0)


@pytest.mark.parametrize("values", [(1 / 3, 1 / 3, 1 / 3), (0.5, 0.25, 0.25), (0.4, 0.4, 0.2)])
@pytest.mark.parametrize("name", SMOOTH)
def test_coinciding_eigenvalues_of_smooth_closures(name, values):
    Q = rotation(4)
    a = (Q @ np.diag(values) @ Q.T)[None]
    law = CLOSURES[name]
    exact = law.fourth_derivative(a, TANGENTS)
    coarse, fine = (np.abs(central(law, a, h) - exact).max() for h in (4e-3, 2e-3))
    assert fine < 1e-4
    assert fine < 1e-12 or np.log2(coarse / fine) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("gap", [3e-6, 3e-7, 1e-7, 3e-8, 1e-12])
@pytest.mark.parametrize("base", [(0.5, 0.25, 0.25), (0.4, 0.4, 0.2), (1 / 3, 1 / 3, 1 / 3)])
def test_exact_closure_is_continuous_through_the_switch(base, gap):
    law, Q = CLOSURES["exact"], rotation(6)
    split = gap * np.array([0.5, -0.5, 0.0] if base[0] == base[1] else [0.0, 0.5, -0.5])
    a, near = (Q @ np.diag(v) @ Q.T for v in (np.array(base), np.array(base) + split))
    # To the first order in the gap the value follows the derivative, and it follows itself.
    expected = law.fourth(a) + law.fourth_derivative(a, (near - a)[None])[0]
    assert np.allclose(law.fourth(near), expected, atol=10.0 * gap**2 + 1e-14, rtol=0)
    change = law.fourth_derivative(near, TANGENTS) - law.fourth_derivative(a, TANGENTS)
    # Second derivatives are of order 10; below the switch rounding over the gap takes over.
    assert np.abs(change).max() < 20.0 * gap + 2e-8


# The jump of each fit, which is its departure from h_i = h_j = 3/8 h_k, at lambda_1 = lambda_2 and
# at lambda_2 = lambda_3: largest component, rounded up in the third digit.
JUMPS = {
    "ORS": (0.0, 0.0),
    "ORF": (1.20e-3, 1.98e-3),
    "ORL": (1.80e-3, 4.05e-3),
    "ORW": (1.07e-3, 1.41e-3),
    "ORW3": (4.13e-4, 6.54e-4),
    "ORE": (2.76e-5, 1.26e-4),
}


@pytest.mark.parametrize("name", JUMPS)
def test_jump_of_the_fits_is_their_error(name):
    law = CLOSURES[name]
    x = np.linspace(1 / 3, 1.0, 1001)[1:-1]
    oblate = x[x < 0.5]
    states = (
        (np.stack([oblate, oblate, 1 - 2 * oblate], axis=1), (1.0, -1.0, 0.0)),
        (np.stack([x, (1 - x) / 2, (1 - x) / 2], axis=1), (0.0, 1.0, -1.0)),
    )
    for (values, split), bound in zip(states, JUMPS[name], strict=True):
        gap = 1.01 * WIDTH  # the fit as published, and what it is led over to
        at, near = values, values + 0.5 * gap * np.array(split)
        jump = np.abs(
            law.fourth(near[:, :, None] * np.eye(3)) - law.fourth(at[:, :, None] * np.eye(3))
        )
        assert jump.max() < bound + 2.0 * gap  # slopes are of order 1
        assert jump.max() > 0.97 * bound  # the table says what is there, not more


@pytest.mark.parametrize("values", [(1 / 3, 1 / 3, 1 / 3), (0.5, 0.25, 0.25), (0.4, 0.4, 0.2)])
@EVERY
def test_derivative_is_frame_indifferent_where_axes_are_arbitrary(name, values):
    law, Q = CLOSURES[name], rotation(8)
    a = np.diag(values)
    here = law.contract_derivative(a, Q.T @ RATE @ Q, Q.T @ TANGENTS @ Q)
    there = law.contract_derivative(Q @ a @ Q.T, RATE, TANGENTS)
    # The quartic fit's coefficients of 50 and IBOF's of 1e10 leave 1e-12 of rounding.
    assert np.allclose(Q @ here @ Q.T, there, atol=1e-11, rtol=0)


@EVERY
def test_uniaxial_states_stay_uniaxial(name):
    """What Newton's method needs in extension: no arbitrary axis enters the rate."""
    law, Q = CLOSURES[name], rotation(9)
    strain = Q @ np.diag([1.0, -0.5, -0.5]) @ Q.T
    for values in ((0.8, 0.1, 0.1), (0.2, 0.4, 0.4)):
        rate = Q.T @ law.contract(Q @ np.diag(values) @ Q.T, strain) @ Q
        assert rate[1, 1] == pytest.approx(rate[2, 2], abs=1e-13)
        assert np.abs(rate - np.diag(np.diag(rate))).max() < 1e-13


@pytest.mark.parametrize("base", [(0.5, 0.25, 0.25), (0.4, 0.4, 0.2), (1.0, 0.0, 0.0)])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.9])
@pytest.mark.parametrize("name", JUMPS)
def test_derivative_where_a_fit_is_led_over(name, share, base):
    """Differences across a small part of the width, where slopes are the jump over the width."""
    law, Q = CLOSURES[name], rotation(9)
    split = np.array([0.5, -0.5, 0.0] if base[0] == base[1] else [0.0, 0.5, -0.5])
    a = Q @ np.diag(np.array(base) + share * WIDTH * split) @ Q.T
    exact = law.fourth_derivative(a[None], TANGENTS)
    coarse, fine = (
        np.abs(central(law, a[None], h * WIDTH) - exact).max() for h in (2e-2 * share, 1e-2 * share)
    )
    # 1e-16 of rounding over a step of 2e-9
    assert fine < 1e-2 * np.abs(exact).max()
    assert fine < 2e-6 or np.log2(coarse / fine) == pytest.approx(2.0, abs=0.3)


def test_a_fit_is_led_over_by_the_closer_pair():
    """Nearly isotropic tensors with an axis keep it: turns about it change nothing."""
    values = np.array([1 / 3 + 2e-6, 1 / 3 - 1e-6, 1 / 3 - 1e-6])
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, 0.8, 0.6]])
    law = CLOSURES["ORL"]
    fourth = law.fourth(np.diag(values)[None])
    split = np.diag(values + np.array([0.0, 1e-9, -1e-9]))
    assert np.allclose(law.fourth((turn @ split @ turn.T)[None]), fourth, atol=1e-7, rtol=0)
