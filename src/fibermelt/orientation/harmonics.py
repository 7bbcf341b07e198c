"""Real spherical harmonics of even degree, and what acts on them, as sparse matrices.

A distribution of directions with ``psi(-p) = psi(p)`` has even degrees only:
``psi(p) = sum c_lm Y_lm(p)``, ``l = 0, 2, ..., degree``, ``m = -l..l``, with real orthonormal
``Y_lm``: ``sqrt(2) N P_l^m(cos theta) cos(m phi)`` for ``m > 0``, the sine for ``m < 0``, polar
axis ``x_3``, no Condon-Shortley sign. Coefficients are counted degree by degree, ``m`` ascending.

All matrices come from two recurrences, that of a component of ``p`` (Edmonds 1957, Eq. 5.7 in the
form of ladder operators) and that of the angular momentum, so that they are exact: no quadrature.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

__all__ = [
    "SphereOperators",
    "evaluate_harmonics",
    "moment_tables",
    "number_of_harmonics",
    "sphere_operators",
]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

LOWEST_DEGREE = 4
"""Degree that the fourth moment needs; matrices of a lower one are not made."""

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Components of a symmetric tensor in the order in which `SphereOperators` has them."""


@dataclass(frozen=True, eq=False)
class SphereOperators:
    """What the Fokker-Planck operator is made of, up to a degree.

    Parameters
    ----------
    degree : int
        Largest degree, even.
    degrees : (N,) integer array
        ``l`` of each coefficient.
    rows, columns : (nnz,) integer arrays
        Places of the common pattern, row by row.
    strain : (6, nnz) array
        Answer to ``D`` component by component of `PAIRS`, at unit shape factor; those off the
        diagonal are counted twice, as both of them are strained.
    spin : (3, nnz) array
        Answer to the melt's angular velocity ``w`` (``W p = w x p``).
    laplacian : (nnz,) array
        ``-l (l + 1)`` on the diagonal.
    """

    degree: int
    degrees: Index
    rows: Index
    columns: Index
    strain: Array
    spin: Array
    laplacian: Array


def number_of_harmonics(degree: int) -> int:
    """Return the number of harmonics of even degree up to ``degree``: ``(l + 1)(l + 2)/2``."""
    return (degree + 1) * (degree + 2) // 2


def _labels(first: int, degree: int) -> tuple[Index, Index]:
    """Return ``l`` and ``m`` of the harmonics of degrees ``first, first + 2, ..., degree``."""
    degrees = np.arange(first, degree + 1, 2)
    l = np.repeat(degrees, 2 * degrees + 1)  # noqa: E741  # the field's letter
    starts = np.repeat(np.cumsum(2 * degrees + 1) - (2 * degrees + 1), 2 * degrees + 1)
    return l, np.arange(l.size) - starts - l


def _place(first: int, l: Index, m: Index) -> Index:  # noqa: E741  # the field's letter
    """Return the index of the harmonic ``(l, m)`` among those that begin with degree ``first``."""
    # degrees first, first + 2, ..., l - 2 hold (l - first)(l + first - 1)/2 harmonics
    return (l - first) * (l + first - 1) // 2 + l + m


def _to_real(l: Index, m: Index, first: int) -> Any:  # noqa: E741  # the field's letter
    """Return the unitary matrix from complex harmonics (with their sign) to real ones."""
    here, there = _place(first, l, m), _place(first, l, -m)
    order = np.abs(m)
    sign = (-1.0) ** order
    half = np.sqrt(0.5)
    # Y_real = (sign Y_|m| + Y_-|m|)/sqrt 2 for cosines, (sign Y_|m| - Y_-|m|)/(i sqrt 2) for sines
    own = np.where(m > 0, half * sign, np.where(m < 0, 1j * half, 1.0))
    other = np.where(m > 0, half, np.where(m < 0, -1j * half * sign, 0.0))
    rows = np.concatenate([here, here])
    columns = np.concatenate([here, there])
    # a real function's coefficients transform with the conjugate of its basis' matrix
    return sparse.csr_matrix((np.concatenate([own, other]).conj(), (rows, columns)))


def _components(degree: int) -> list[Any]:
    """Return multiplication by ``p_1, p_2, p_3``: from degrees 0, 2, ... to 1, 3, ..."""
    l, m = _labels(0, degree)  # noqa: E741  # the field's letter
    l_odd, m_odd = _labels(1, degree + 1)
    shape = (l_odd.size, l.size)

    def step(dl: int, dm: int, factor: Array) -> Any:
        fits = (l + dl >= 1) & (np.abs(m + dm) <= l + dl)
        to = _place(1, (l + dl)[fits], (m + dm)[fits])
        return sparse.csr_matrix((factor[fits], (to, np.flatnonzero(fits))), shape=shape)

    up, down = (2 * l + 1) * (2 * l + 3), np.maximum((2 * l - 1) * (2 * l + 1), 1)

    def root(numerator: Index, denominator: Index) -> Array:
        return np.sqrt(np.maximum(numerator, 0) / denominator)

    along = step(1, 0, root((l + 1) ** 2 - m**2, up)) + step(-1, 0, root(l**2 - m**2, down))
    plus = step(-1, 1, root((l - m) * (l - m - 1), down)) - step(
        1, 1, root((l + m + 1) * (l + m + 2), up)
    )
    minus = step(1, -1, root((l - m + 1) * (l - m + 2), up)) - step(
        -1, -1, root((l + m) * (l + m - 1), down)
    )
    real, real_odd = _to_real(l, m, 0), _to_real(l_odd, m_odd, 1)
    complex_ones = (0.5 * (plus + minus), -0.5j * (plus - minus), along)
    return [_real(real_odd @ part @ real.conj().T) for part in complex_ones]


def _rotations(degree: int) -> list[Any]:
    """Return the real antisymmetric matrices of ``p x grad`` about the three axes."""
    l, m = _labels(0, degree)  # noqa: E741  # the field's letter
    fits = m < l
    ladder = np.sqrt(((l - m) * (l + m + 1))[fits].astype(float))
    to = _place(0, l[fits], m[fits] + 1)
    raising = sparse.csr_matrix((ladder, (to, np.flatnonzero(fits))), shape=(l.size, l.size))
    momentum = (0.5 * (raising + raising.T), -0.5j * (raising - raising.T), sparse.diags(m * 1.0))
    real = _to_real(l, m, 0)
    return [_real(real @ (1j * part) @ real.conj().T) for part in momentum]


def _real(matrix: Any) -> Any:
    """Return the real part of a matrix whose imaginary part cancels."""
    result = sparse.csr_matrix(matrix.real)
    result.eliminate_zeros()
    return result


@lru_cache(maxsize=8)
def sphere_operators(degree: int) -> SphereOperators:
    """Return the parts of the Fokker-Planck operator up to an even degree, at least four.

    With ``Q = p.D p`` the rotation by strain is a gradient, ``D p - (p.D p) p = grad Q/2``, and
    ``-div(psi grad Q) = (Q lap psi - lap(Q psi) - psi lap Q)/2`` with ``lap Q = -6 Q``: an
    element of the multiplication by ``Q``, from degree ``l'`` to ``l``, has the factor
    ``(l (l + 1) - l' (l' + 1) + 6)/4``. The spin is ``-w.(p x grad)``.

    Parameters
    ----------
    degree : int
        Largest degree.
    """
    l, _ = _labels(0, degree)  # noqa: E741  # the field's letter
    p = _components(degree)
    parts = [(p[i].T @ p[j]).tocoo() * (1.0 if i == j else 2.0) for i, j in PAIRS]
    parts = [sparse.coo_matrix(part) for part in parts]
    for part in parts:
        part.data *= 0.25 * ((l * (l + 1))[part.row] - (l * (l + 1))[part.col] + 6.0)
    parts += [sparse.coo_matrix(-part) for part in _rotations(degree)]
    parts.append(sparse.coo_matrix(sparse.diags(-(l * (l + 1.0)))))
    codes = [part.row.astype(np.int64) * l.size + part.col for part in parts]
    places = np.unique(np.concatenate(codes))
    table = np.zeros((len(parts), places.size))
    for row, code, part in zip(table, codes, parts, strict=True):
        row[np.searchsorted(places, code)] = part.data
    return SphereOperators(
        degree, l, places // l.size, places % l.size, table[:6], table[6:9], table[9]
    )


@lru_cache(maxsize=1)
def moment_tables() -> tuple[Array, Array]:
    """Return the second and fourth moments of each harmonic up to degree four.

    Returns
    -------
    second : (3, 3, 15) array
        ``int p_i p_j Y`` over the sphere; zero above degree two.
    fourth : (3, 3, 3, 3, 15) array
        ``int p_i p_j p_k p_l Y``; zero above degree four.
    """
    p = [part.toarray() for part in _components(LOWEST_DEGREE)]
    products = np.array([[a.T @ b for b in p] for a in p])
    constant = np.zeros(products.shape[-1])
    constant[0] = np.sqrt(4.0 * np.pi)  # 1 = sqrt(4 pi) Y_00
    second = np.einsum("ijab,b->ija", products, constant)
    fourth = np.einsum("ijab,klb->ijkla", products, second)
    return second, fourth


def evaluate_harmonics(degree: int, direction: Array) -> Array:
    """Return the harmonics of even degree at unit vectors.

    Parameters
    ----------
    degree : int
        Largest degree.
    direction : (..., 3) array
        Unit vectors [-].

    Returns
    -------
    (..., N) array
        Values, in the order of the coefficients. By the recurrence of the normalised associated
        Legendre functions in ``l`` (Holmes and Featherstone 2002), each times ``(p_1 + i p_2)^m``.
    """
    p = np.asarray(direction, dtype=np.float64)
    z = p[..., 2]
    values = np.empty((*p.shape[:-1], number_of_harmonics(degree)))
    sector = np.full(z.shape, np.sqrt(0.25 / np.pi), dtype=np.complex128)
    for m in range(degree + 1):
        if m > 0:
            factor = np.sqrt((2 * m + 1) / (2 * m)) * (np.sqrt(2.0) if m == 1 else 1.0)
            sector = sector * (p[..., 0] + 1j * p[..., 1]) * factor
        before, here = np.zeros_like(sector), sector
        for l in range(m, degree + 1):  # noqa: E741  # the field's letter
            if l % 2 == 0:
                place = l * (l - 1) // 2 + l
                values[..., place + m] = here.real
                if m > 0:
                    values[..., place - m] = here.imag
            gain = np.sqrt((2 * l + 3) * (2 * l + 1) / ((l + 1) ** 2 - m**2))
            loss = np.sqrt((2 * l + 3) * (l * l - m * m) / ((2 * l - 1) * ((l + 1) ** 2 - m**2)))
            before, here = here, gain * z * here - (loss if l > m else 0.0) * before
    return values
