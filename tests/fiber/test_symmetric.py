"""Outer eigenpairs of symmetric matrices, above all where two eigenvalues are close."""

import numpy as np
import pytest

from fibermelt.fiber.symmetric import extreme_eigenpairs

ROUNDING = 1e-14  # ten roundings and some


def matrices(eigenvalues: tuple[float, float, float], spread: float) -> np.ndarray:
    rng = np.random.default_rng(8)
    turns = np.linalg.qr(rng.normal(size=(2000, 3, 3)))[0]
    values = np.array(eigenvalues) + spread * rng.normal(size=(2000, 3))
    product = np.einsum("nij,nj,nkj->nik", turns, values, turns)
    return 0.5 * (product + np.swapaxes(product, -1, -2))


def check(A: np.ndarray) -> None:
    components = tuple(A[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))
    low, high, at_low, at_high = extreme_eigenpairs(components)
    size = np.max(np.abs(A), axis=(1, 2))
    exact = np.linalg.eigvalsh(A)
    assert np.all(np.abs(low - exact[:, 0]) <= ROUNDING * size)
    assert np.all(np.abs(high - exact[:, 2]) <= ROUNDING * size)
    for value, parts in ((low, at_low), (high, at_high)):
        vector = np.stack(parts, axis=-1)
        residual = np.einsum("nij,nj->ni", A, vector) - value[:, None] * vector
        assert np.all(np.abs(residual) <= ROUNDING * size[:, None])
        assert np.sum(vector**2, axis=-1) == pytest.approx(1.0, abs=ROUNDING)


@pytest.mark.parametrize("spread", [0.0, 1e-15, 1e-12, 1e-8, 1e-6, 1e-3, 1.0])
@pytest.mark.parametrize("eigenvalues", [(1, 1, -2), (2, -1, -1), (1, 1, 1), (5, 4, 1)])
def test_random_matrices(eigenvalues: tuple[float, float, float], spread: float) -> None:
    check(matrices(eigenvalues, spread))


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e-100, 1e-30, 1e12, 1e101, 1e160, 1e300])
def test_scale_does_not_matter(size: float) -> None:
    check(size * matrices((2.0, 0.3, -1.0), 0.1))


@pytest.mark.parametrize(
    "diagonal", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, -1), (2, 2, 2)]
)
def test_diagonal_matrices(diagonal: tuple[float, float, float]) -> None:
    check(np.diag(np.array(diagonal, dtype=float))[None])


@pytest.mark.parametrize("size", [5e-324, 1e-320, 1e-310])
def test_components_with_few_digits_left(size: float) -> None:
    """Next to zero numbers are whole multiples of 5e-324: right to one of them, and no warning."""
    matrix = (size * np.array([1.0, -1.0, 0.0, 0.0, 0.0, 1.0]))[:, None]
    low, high, at_low, at_high = extreme_eigenpairs(tuple(matrix))
    assert low[0] == pytest.approx(-np.sqrt(2.0) * size, abs=5e-324)
    assert high[0] == pytest.approx(np.sqrt(2.0) * size, abs=5e-324)
    for vector in (at_low, at_high):
        assert np.linalg.norm(np.ravel(vector)) == pytest.approx(1.0, abs=ROUNDING)


def test_one_at_rest_among_others() -> None:
    """What is rare is taken care of without touching the rest."""
    some = matrices((2.0, 0.3, -1.0), 0.1)
    some[3] = 0.0
    some[5] *= 1e-170
    check(some[:3])
    parts = tuple(some[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)))
    low, high, _, at_high = extreme_eigenpairs(parts)
    assert (low[3], high[3]) == (0.0, 0.0)
    expected = np.linalg.eigvalsh(some[5] * 1e170) * 1e-170
    assert [low[5], high[5]] == pytest.approx([expected[0], expected[2]], rel=1e-14)
    assert np.all(np.isfinite(np.stack(at_high)))
