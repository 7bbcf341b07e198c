"""The orientation distribution against closed forms, series from the literature and itself."""

import time

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from fibermelt.errors import ConfigError, ConvergenceError, HistoryError
from fibermelt.orientation.distribution import Distribution, isotropic_distribution
from fibermelt.orientation.fokker_planck import (
    follow_distribution,
    rate_operator,
    steady_distribution,
)
from fibermelt.orientation.harmonics import evaluate_harmonics, sphere_operators
from fibermelt.verify.distribution import (
    folgar_tucker,
    random_distribution,
    random_gradient,
    slow_shear,
    uniaxial_moment,
)

pytestmark = pytest.mark.verification

SHEAR = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
UNIAXIAL = np.diag([1.0, -0.5, -0.5])
XI_6 = 35.0 / 37.0
ROUNDING = 1e-12  # of order-one moments after a few thousand roundings


def random_directions(count: int, seed: int) -> np.ndarray:
    p = np.random.default_rng(seed).normal(size=(count, 3))
    return p / np.linalg.norm(p, axis=1)[:, None]


def test_harmonics_are_orthonormal() -> None:
    degree = 8
    nodes, weights = np.polynomial.legendre.leggauss(degree + 1)
    angle = 2.0 * np.pi * np.arange(2 * degree + 2) / (2 * degree + 2)
    z, phi = (part.ravel() for part in np.meshgrid(nodes, angle, indexing="ij"))
    rho = np.sqrt(1.0 - z**2)
    Y = evaluate_harmonics(degree, np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=-1))
    weight = np.repeat(weights, angle.size) * 2.0 * np.pi / angle.size
    assert (Y.T * weight) @ Y == pytest.approx(np.eye(Y.shape[1]), abs=ROUNDING)


@examples(20)
@given(st.integers(0, 2**16), st.floats(-1.0, 1.5), st.floats(0.0, 2.0))
def test_second_moment_obeys_folgar_tucker(seed: int, xi: float, D_r: float) -> None:
    L, psi = random_gradient(seed), random_distribution(8, seed)
    rate = rate_operator(L, xi, D_r, 8) @ psi.coefficients
    moment = Distribution(rate, 8).second()
    expected = folgar_tucker(psi.second(), psi.fourth(), L, xi, D_r)
    # moments below degree four never meet the truncation at eight: an identity
    assert moment == pytest.approx(expected, abs=ROUNDING * (1.0 + np.abs(expected).max()))
    assert rate[0] == pytest.approx(0.0, abs=ROUNDING)  # no fiber is lost


def test_rate_is_the_equation_pointwise() -> None:
    # the operator on a series of degree 4 inside one of degree 8: nothing is truncated
    L, xi, D_r = random_gradient(3), 0.8, 0.3
    psi = random_distribution(4, 3)
    coefficients = psi.raised(8)
    p = random_directions(6, 4)
    rate = Distribution(rate_operator(L, xi, D_r, 8) @ coefficients, 8).density(p)
    D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)

    def value(q: np.ndarray) -> np.ndarray:
        return Distribution(coefficients, 8).density(q / np.linalg.norm(q, axis=1)[:, None])

    def flux(q: np.ndarray) -> np.ndarray:
        q = q / np.linalg.norm(q, axis=1)[:, None]
        turning = q @ W.T + xi * (q @ D.T - np.einsum("ki,ij,kj->k", q, D, q)[:, None] * q)
        return turning * value(q)[:, None]

    # both are constant along rays, so that surface operators are the space's at |p| = 1
    h = 1e-3
    divergence, laplacian = np.zeros(6), np.zeros(6)
    for i, e in enumerate(np.eye(3)):
        divergence += (flux(p + h * e) - flux(p - h * e))[:, i] / (2.0 * h)
        laplacian += (value(p + h * e) - 2.0 * value(p) + value(p - h * e)) / h**2
    # central differences: h^2 times a fourth derivative of a few hundred
    assert rate == pytest.approx(-divergence + D_r * laplacian, abs=5e-4 * np.abs(rate).max())


@pytest.mark.parametrize(("D_r", "xi"), [(0.5, 1.0), (0.05, 1.0), (0.02, 0.7)])
def test_uniaxial_elongation_has_a_closed_form(D_r: float, xi: float) -> None:
    # flux is zero: psi ~ exp(xi p.D p/(2 D_r)) = exp(k (p.e)^2)
    k = 0.75 * xi / D_r
    mass = quad(lambda x: np.exp(k * (x * x - 1.0)), 0.0, 1.0, epsabs=0.0, epsrel=1e-13)[0]
    second = uniaxial_moment(k)
    psi = steady_distribution(UNIAXIAL, xi, D_r)
    half = 0.5 * (1.0 - second)
    assert psi.second() == pytest.approx(np.diag([second, half, half]), abs=ROUNDING)
    p = random_directions(50, 1)
    exact = np.exp(k * (p[:, 0] ** 2 - 1.0)) / (4.0 * np.pi * mass)
    # the truncation is that of the root mean square; a peak adds up what degrees leave
    peak = np.exp(0.0) / (4.0 * np.pi * mass)
    assert psi.density(p) == pytest.approx(exact, abs=10.0 * psi.truncation * peak + ROUNDING)


def test_any_flow_without_vorticity_has_a_closed_form() -> None:
    D = random_gradient(11)
    D = 0.5 * (D + D.T)
    psi = steady_distribution(D, 0.9, 0.2)
    p = random_directions(40, 2)
    exact = np.exp(0.9 * np.einsum("ki,ij,kj->k", p, D, p) / 0.4)
    ratio = psi.density(p) / exact
    # relative, where psi is within a thousand of its peak: truncation 1e-8 there is 1e-5
    likely = exact > 1e-3 * exact.max()
    assert ratio[likely] == pytest.approx(np.median(ratio), rel=1e-4)


def test_series_of_rigid_rods_in_slow_shear() -> None:
    errors = [slow_shear(w) for w in (0.1, 0.05)]
    order = np.log2(np.abs(np.divide(*errors)))
    # what is left are the next terms of the series, w^6 and w^4; halving w from 0.1 is nearly there
    assert order == pytest.approx([6.0, 4.0], abs=0.1)


def test_strong_diffusion_is_isotropic() -> None:
    D = 0.5 * (SHEAR + SHEAR.T)
    departure = []
    for D_r in (20.0, 40.0):
        a = steady_distribution(SHEAR, XI_6, D_r).second()
        departure.append(np.abs(a - np.eye(3) / 3.0 - XI_6 * D / (15.0 * D_r)).max())
    assert departure[0] < 1e-4
    assert np.log2(departure[0] / departure[1]) == pytest.approx(2.0, abs=0.05)  # next order


def test_convergence_with_the_degree_is_spectral() -> None:
    exact = steady_distribution(SHEAR, XI_6, 0.0128, degree=80).second()
    previous = np.inf
    for degree in (16, 24, 32, 40):
        psi = steady_distribution(SHEAR, XI_6, 0.0128, degree=degree)
        error = np.abs(psi.second() - exact).max()
        assert error < 0.1 * previous  # each eight degrees gain more than a digit
        assert error < psi.truncation**2 + ROUNDING  # moments are off by the square
        previous = error
    chosen = steady_distribution(SHEAR, XI_6, 0.0128)
    assert chosen.truncation < 1e-8
    assert chosen.second() == pytest.approx(exact, abs=ROUNDING)
    assert chosen.residual < ROUNDING


@pytest.mark.parametrize("interaction", [1.0, 0.1, 0.0128, 1e-3, 1e-4])
def test_shear_at_any_interaction(interaction: float) -> None:
    psi = steady_distribution(SHEAR, XI_6, interaction)
    a = psi.second()
    rate = folgar_tucker(a, psi.fourth(), SHEAR, XI_6, interaction)
    assert rate == pytest.approx(np.zeros((3, 3)), abs=ROUNDING)
    assert np.trace(a) == pytest.approx(1.0, abs=ROUNDING)
    assert psi.density(random_directions(500, 5)).min() > -1e-7  # truncation below a peak of ten


def test_weak_diffusion_goes_to_leal_and_hinch() -> None:
    # D_r -> 0 selects one density over Jeffery's orbits (Leal and Hinch 1971): its error is O(D_r),
    # so that the difference halves with D_r
    second = [steady_distribution(SHEAR, 0.6, D_r).second() for D_r in (8e-3, 4e-3, 2e-3)]
    first = np.abs(second[0] - second[1]).max()
    assert np.log2(first / np.abs(second[1] - second[2]).max()) == pytest.approx(1.0, abs=0.1)


def test_steady_state_turns_with_the_frame() -> None:
    R = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    here = steady_distribution(SHEAR, XI_6, 0.05).second()
    there = steady_distribution(R @ SHEAR @ R.T, XI_6, 0.05).second()
    assert there == pytest.approx(R @ here @ R.T, abs=ROUNDING)


def test_paper_interaction_takes_less_than_a_tenth_of_a_second() -> None:
    best = np.inf
    for _ in range(5):
        sphere_operators.cache_clear()  # the matrices included
        start = time.process_time()
        steady_distribution(SHEAR, XI_6, 0.0128)
        best = min(best, time.process_time() - start)
    assert best < 0.1


def test_decay_without_flow() -> None:
    degree, D_r, t = 8, 0.3, np.linspace(0.0, 1.5, 4)
    start = random_distribution(degree, 8)
    history = follow_distribution(
        t, np.zeros((4, 3, 3)), 0.9, D_r, initial=start, degree=degree, tolerance=1e-11
    )
    l = sphere_operators(degree).degrees  # noqa: E741  # the field's letter
    exact = start.coefficients * np.exp(-D_r * np.outer(t, l * (l + 1)))
    # some ten steps of 1e-11 each, of coefficients up to three
    assert history.distribution.coefficients == pytest.approx(exact, abs=1e-9)


def test_rotation_only_turns_the_distribution() -> None:
    spin = np.array([0.2, -0.5, 1.3])
    W = np.cross(np.eye(3), spin)  # W p = spin x p
    assert pytest.approx(np.cross(spin, [1.0, 2.0, 3.0])) == W @ [1.0, 2.0, 3.0]
    start = random_distribution(6, 9)
    history = follow_distribution(
        [0.0, 2.0], np.stack([W, W]), 0.0, 0.0, initial=start, degree=6, tolerance=1e-11
    ).distribution
    p = random_directions(20, 6)
    back = Rotation.from_rotvec(2.0 * spin).inv().apply(p)
    assert history.density(p)[1] == pytest.approx(start.density(back), abs=1e-9)


def test_planar_and_spatial_gradients_agree_and_the_end_is_steady() -> None:
    t = np.linspace(0.0, 60.0, 31)
    planar = np.broadcast_to(SHEAR[:2, :2], (31, 2, 2))
    history = follow_distribution(t, planar, XI_6, 0.1)
    steady = steady_distribution(SHEAR, XI_6, 0.1).second()
    # the slowest mode decays faster than 6 D_r: e^-36
    assert history.distribution.second()[-1] == pytest.approx(steady, abs=1e-10)
    assert history.distribution.truncation < 1e-6


def test_history_without_diffusion_is_jefferys() -> None:
    # psi carried by F, F_dot = (W + xi D) F: a = mean of F p p F^T/|F p|^2 over isotropic p
    t = np.linspace(0.0, 2.0, 3)
    gradient = np.broadcast_to(SHEAR, (3, 3, 3))
    history = follow_distribution(t, gradient, XI_6, 0.0)
    D, W = 0.5 * (SHEAR + SHEAR.T), 0.5 * (SHEAR - SHEAR.T)
    K = W + XI_6 * D
    rate = np.sqrt(-K[0, 1] * K[1, 0])  # K^2 = -rate^2 in the plane
    F = np.eye(3)
    F[:2, :2] = np.cos(2.0 * rate) * np.eye(2) + np.sin(2.0 * rate) / rate * K[:2, :2]
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angle = 2.0 * np.pi * np.arange(120) / 120
    z, phi = (part.ravel() for part in np.meshgrid(nodes, angle, indexing="ij"))
    rho = np.sqrt(1.0 - z**2)
    q = np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=-1) @ F.T
    q /= np.linalg.norm(q, axis=1)[:, None]
    a = np.einsum("k,ki,kj->ij", np.repeat(weights, 120) / 240.0, q, q)
    assert history.distribution.second()[-1] == pytest.approx(a, abs=1e-9)
    assert history.error < 1e-8


def test_history_that_changes_with_time() -> None:
    # shear whose rate oscillates, D_r with it: a function of the strain, so that time drops out
    def strain(s):
        return s + 0.5 * np.sin(s)

    t = np.linspace(0.0, 3.0, 121)
    rate = 1.0 + 0.5 * np.cos(t)
    changing = follow_distribution(t, rate[:, None, None] * SHEAR, XI_6, 0.05 * rate)
    constant = follow_distribution([0.0, strain(3.0)], np.stack([SHEAR, SHEAR]), XI_6, 0.05)
    difference = changing.distribution.second()[-1] - constant.distribution.second()[-1]
    # cubic interpolation: the strain is off by t''' h^4/384, with h = 1/40 below 1e-8
    assert np.abs(difference).max() < 1e-7


def test_history_begins_where_it_is_told() -> None:
    start = steady_distribution(SHEAR, XI_6, 0.05)
    t = np.linspace(0.0, 5.0, 6)
    history = follow_distribution(t, np.broadcast_to(SHEAR, (6, 3, 3)), XI_6, 0.05, start)
    assert history.distribution.second() == pytest.approx(
        np.broadcast_to(start.second(), (6, 3, 3)), abs=1e-10
    )


def test_refusals() -> None:
    start = random_distribution(8, 0)
    with pytest.raises(ConfigError, match="needs a positive one"):
        steady_distribution(SHEAR, XI_6, 0.0)
    with pytest.raises(ConfigError, match=r"diffusivity = -1"):
        steady_distribution(SHEAR, XI_6, -1.0)
    with pytest.raises(ConfigError, match="degree = 7"):
        steady_distribution(SHEAR, XI_6, 0.1, degree=7)
    with pytest.raises(ConfigError, match="shape_factor = nan"):
        steady_distribution(SHEAR, np.nan, 0.1)
    with pytest.raises(HistoryError, match="has trace 3 1/s"):
        steady_distribution(np.eye(3), XI_6, 0.1)
    with pytest.raises(HistoryError, match="increase"):
        follow_distribution([0.0, 0.0], np.zeros((2, 3, 3)), XI_6, 0.1)
    with pytest.raises(HistoryError, match="one for each of 2"):
        follow_distribution([0.0, 1.0], np.zeros((3, 3, 3)), XI_6, 0.1)
    with pytest.raises(ConfigError, match="initial distribution's 8"):
        follow_distribution([0.0, 1.0], np.zeros((2, 3, 3)), XI_6, 0.1, start, degree=4)
    with pytest.raises(ConfigError, match="unit vector"):
        isotropic_distribution().density([[1.0, 1.0, 0.0]])
    with pytest.raises(ConfigError, match="coefficients have shape"):
        Distribution(np.ones(3), 4)


def test_a_peak_that_no_degree_resolves_is_refused() -> None:
    with pytest.raises(ConvergenceError, match="larger diffusivity"):
        steady_distribution(UNIAXIAL, 1.0, 1e-5)
