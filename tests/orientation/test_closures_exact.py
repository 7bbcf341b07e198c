"""The exact closure against Carlson's integrals, against fibers, and the fits against it."""

import time

import numpy as np
import pytest
from fiberoripy.closures import compute_closure

from fibermelt.errors import ConvergenceError
from fibermelt.orientation import exact_closure
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.exact_closure import ExactDeviation, central_gaussian, second_moments
from fibermelt.verify.closures import carlson_moments, deformed_fibers

pytestmark = pytest.mark.verification

EXACT = CLOSURES["exact"]


def test_quadrature_is_carlsons_integral():
    x = np.random.default_rng(1).normal(scale=5.0, size=(500, 3))
    b = np.exp(x - x.mean(axis=1, keepdims=True))
    assert np.allclose(second_moments(b), carlson_moments(b), rtol=1e-13, atol=0)


def test_inverse_from_random_to_aligned_and_planar():
    small = 10.0 ** -np.arange(1, 12)[:, None]
    one = np.ones_like(small)
    values = np.concatenate(
        [
            np.hstack([1 - 2 * small, small, small]),
            np.hstack([1 - 1.5 * small, small, 0.5 * small]),
            np.hstack([(1 - small) / 2, (1 - small) / 2, small]),
            np.hstack([0.9 - small, 0.1 * one, small]),
            np.random.default_rng(2).dirichlet([0.5, 0.5, 0.5], 500).clip(1e-12),
        ]
    )
    b = central_gaussian(values)
    assert np.allclose(carlson_moments(b), values, rtol=2e-13, atol=0)
    # Nothing imposes it: the trace does.
    assert np.allclose(np.prod(b, axis=1), values.sum(axis=1) ** -2.0, rtol=1e-12, atol=0)


def test_no_answer_is_said(monkeypatch):
    monkeypatch.setattr(exact_closure, "ITERATIONS", 2)
    with pytest.raises(ConvergenceError, match="use the closure ORE"):
        central_gaussian(np.array([[0.9, 0.09, 0.01]]))


def test_mixed_component_by_differences_of_carlsons_integrals():
    """A_1122 = (b_1 a_1 - b_2 a_2)/(2 (b_1 - b_2)): another path to the fourth moment."""
    values = np.array([[0.6, 0.3, 0.1]])
    b, a = central_gaussian(values)[0], values[0]
    A = EXACT.fourth(np.diag(a))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        mixed = (b[i] * a[i] - b[j] * a[j]) / (2.0 * (b[i] - b[j]))
        assert A[i, i, j, j] == pytest.approx(mixed, abs=1e-14)


@pytest.mark.parametrize("split", [0.5, 0.7, 0.95])
def test_planar_limit_is_the_natural_closure(split):
    """A_1111 = L (1 + L)/2 and A_1122 = L (1 - L)/2 in the plane (Verleye and Dupret 1993)."""
    A = EXACT.fourth(np.diag([split, 1.0 - split, 0.0]))
    assert A[0, 0, 0, 0] == pytest.approx(split * (1 + split) / 2, abs=5e-12)
    assert A[1, 1, 1, 1] == pytest.approx((1 - split) * (2 - split) / 2, abs=5e-12)
    assert A[0, 0, 1, 1] == pytest.approx(split * (1 - split) / 2, abs=5e-12)


@pytest.mark.parametrize("shear", [0.0, 1.0, 2.0])
def test_it_is_exact_for_fibers_turned_from_random_orientation(shear):
    F = np.array([[1.2, shear, 0.3], [0.0, 0.9, 0.1], [0.0, 0.2, 1.0]])
    a, A = deformed_fibers(F, 120)
    rough, _ = deformed_fibers(F, 60)
    # The rule converges geometrically: twice the points square the error.
    assert np.abs(a - rough).max() < 1e-6
    assert np.allclose(EXACT.fourth(a), A, atol=1e-12, rtol=0)


# Largest component error over the triangle of eigenvalues, and its root mean square, against the
# exact closure: rounded up in the last digit.
ERRORS = {
    "linear": (0.229, 0.080),
    "quadratic": (0.126, 0.102),
    "hybrid": (0.126, 0.074),
    "ORS": (0.0530, 0.0340),
    "ORF": (0.0125, 0.0051),
    "ORL": (0.0059, 0.0029),
    "ORW": (0.0026, 0.0012),
    "ORW3": (0.0015, 0.0005),
    "ORE": (0.0012, 0.00033),
    "IBOF": (0.0026, 0.0005),
}


def triangle(count=81):
    """Sorted eigenvalues of all orientation tensors, on a grid."""
    grid = np.linspace(0.0, 1.0, count)
    x, y = np.meshgrid(grid, grid, indexing="ij")
    z = 1.0 - x - y
    inside = (x >= y - 1e-12) & (y >= z - 1e-12) & (z >= -1e-12)
    return np.stack([x, y, z], axis=-1)[inside].clip(0.0, 1.0)


def test_how_far_the_fits_are_from_exact():
    a = triangle()[:, :, None] * np.eye(3)
    exact = EXACT.fourth(a)
    for name, (largest, mean) in ERRORS.items():
        error = np.abs(CLOSURES[name].fourth(a) - exact).max(axis=(1, 2, 3, 4))
        assert 0.9 * largest < error.max() <= largest, name
        assert 0.9 * mean < np.sqrt(np.mean(error**2)) <= mean, name


def test_slopes_by_differences_of_the_principal_law():
    law, step = ExactDeviation(), 1e-4
    values = np.array([[0.6, 0.3, 0.1], [0.9, 0.07, 0.03]])
    _, slopes = law.value_and_slopes(values)
    for change in (np.array([1.0, -1.0, 0.0]), np.array([0.0, 1.0, -1.0])):
        up, down = law.value(values + step * change), law.value(values - step * change)
        # Third derivatives grow like 1/lambda_3^2 times those of order 1: (1e-4/0.03)^2 of them.
        assert np.allclose((up - down) / (2 * step), slopes @ change, atol=2e-5, rtol=0)


@pytest.mark.parametrize("name", ["linear", "quadratic", "hybrid", "ORF", "ORW3", "IBOF"])
def test_contraction_is_fifty_times_faster_than_a_loop(name):
    """Measured 100 to 420 on one core, also with five others at work there.

    Processor time and the best of many, of arrays that fit into a cache: other work hardly counts.
    """
    rng = np.random.default_rng(3)
    p = rng.normal(size=(10_000, 6, 3))
    p /= np.linalg.norm(p, axis=-1, keepdims=True)
    a = np.einsum("nki,nkj->nij", p, p) / 6
    rate = np.array([[0.0, 0.5, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])

    def seconds(run):
        start = time.process_time()
        run()
        return time.process_time() - start

    def loop():
        for each in a[:100]:
            np.einsum("ijkl,kl->ij", compute_closure(each, name.upper()), rate)

    ours = min(seconds(lambda: CLOSURES[name].contract(a, rate)) for _ in range(40)) / len(a)
    theirs = min(seconds(loop) for _ in range(8)) / 100
    assert theirs > 50.0 * ours
