"""The orientation distribution of fibers as a series on the sphere, and its moments."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError
from fibermelt.orientation.harmonics import (
    LOWEST_DEGREE,
    evaluate_harmonics,
    moment_tables,
    number_of_harmonics,
)

__all__ = ["UNIFORM", "Distribution", "isotropic_distribution", "tail"]

Array = NDArray[np.float64]

UNIFORM = math.sqrt(0.25 / math.pi)
"""Coefficient of the constant harmonic in every distribution: ``int psi = 1``."""

UNIT_TOLERANCE = 1e-10
"""Largest ``| |p|^2 - 1 |`` of a direction at which a density is asked for."""


@dataclass(frozen=True, eq=False)
class Distribution:
    """How many fibers point where: ``psi(p)`` over the whole sphere, of integral one.

    Parameters
    ----------
    coefficients : (..., N) array
        Of the real harmonics of even degree (`fibermelt.orientation.harmonics`), degree by degree;
        leading axes are any batch, such as times.
    degree : int
        Largest degree, even, at least four; ``N = (degree + 1)(degree + 2)/2``.
    truncation : float
        Share of the two highest degrees in the series' root mean square [-], the largest of a
        batch. It is the size of the error of ``psi``; moments are off by about its square.
    residual : float
        For a steady state, the rate ``|d psi/dt|`` left over ``(|L| + D_r) |psi|`` [-]; zero else.

    Raises
    ------
    ConfigError
        If the number of coefficients is not that of the degree.
    """

    coefficients: Array
    degree: int
    truncation: float = 0.0
    residual: float = 0.0

    def __post_init__(self) -> None:
        """Take the numbers over, and refuse a series that is not of its degree."""
        object.__setattr__(self, "coefficients", real_array("coefficients", self.coefficients))
        if self.degree < LOWEST_DEGREE or self.degree % 2:
            msg = f"degree = {self.degree}: must be even and at least {LOWEST_DEGREE}"
            raise ConfigError(msg)
        expected = number_of_harmonics(self.degree)
        if self.coefficients.shape[-1:] != (expected,):
            msg = (
                f"coefficients have shape {self.coefficients.shape}, expected (..., {expected}) "
                f"of degree {self.degree}"
            )
            raise ConfigError(msg)

    def second(self) -> Array:
        """Return ``a_ij = int p_i p_j psi`` [-], shape (..., 3, 3): exact for the series."""
        return self._moment(moment_tables()[0])

    def fourth(self) -> Array:
        """Return ``a_ijkl = int p_i p_j p_k p_l psi`` [-], shape (..., 3, 3, 3, 3)."""
        return self._moment(moment_tables()[1])

    def density(self, direction: ArrayLike) -> Array:
        """Return ``psi`` at unit vectors [1/sr].

        A truncated series can fall below zero where ``psi`` is all but zero, by the size of the
        truncation; it is returned as it is.

        Parameters
        ----------
        direction : (k, 3) array_like
            Unit vectors [-].

        Returns
        -------
        (..., k) array
            One axis of directions behind the batch.

        Raises
        ------
        ConfigError
            If a direction is not a unit vector.
        """
        p = real_array("direction", direction)
        if p.ndim != 2 or p.shape[1] != 3:
            msg = f"direction has shape {p.shape}, expected (k, 3)"
            raise ConfigError(msg)
        off = np.abs(np.einsum("ki,ki->k", p, p) - 1.0)
        if not np.all(off <= UNIT_TOLERANCE):
            where = int(np.flatnonzero(~(off <= UNIT_TOLERANCE))[0])
            msg = (
                f"direction[{where}] = {p[where].tolist()}: must be a unit vector (bound "
                f"{UNIT_TOLERANCE:g} on its square); divide by the length before"
            )
            raise ConfigError(msg)
        return np.asarray(self.coefficients @ evaluate_harmonics(self.degree, p).T)

    def raised(self, degree: int) -> Array:
        """Return the coefficients up to another degree; those that are not there are zero."""
        size, own = number_of_harmonics(degree), self.coefficients.shape[-1]
        if size <= own:
            return self.coefficients[..., :size].copy()
        grown = np.zeros((*self.coefficients.shape[:-1], size))
        grown[..., :own] = self.coefficients
        return grown

    def _moment(self, table: Array) -> Array:
        low = self.coefficients[..., : table.shape[-1]]
        # one product of matrices: moments of a long history are asked for at once
        flat = low @ table.reshape(-1, table.shape[-1]).T
        return np.asarray(flat.reshape(*low.shape[:-1], *table.shape[:-1]))


def isotropic_distribution(degree: int = LOWEST_DEGREE) -> Distribution:
    """Return ``psi = 1/(4 pi)``: every direction alike."""
    coefficients = np.zeros(number_of_harmonics(degree))
    coefficients[0] = UNIFORM
    return Distribution(coefficients, degree)


def tail(coefficients: Array, degree: int) -> float:
    """Return the share of the two highest degrees in the root mean square, largest of a batch."""
    low = number_of_harmonics(degree - 4)
    share = np.linalg.norm(coefficients[..., low:], axis=-1) / np.linalg.norm(coefficients, axis=-1)
    return float(np.max(share))
