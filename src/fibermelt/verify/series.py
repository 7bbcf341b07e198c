"""The confined fiber by a series: a path to the cell's answer that shares nothing with its mesh.

Plane Stokes flow is ``u + i v = f(z) - z conj(f'(z)) - conj(g(z))``, ``p = -4 mu Re f'``, with
``f, g`` analytic in the ring between fiber and cell edge. Both are taken as growing powers of
``z`` and decaying powers of ``q``, ``z = c (q + m/q)``, which has ``|q| = 1`` on the ellipse;
leaving ``1/q`` out of ``g`` leaves out source and torque, so that the fiber is free. Coefficients
follow from no slip on both walls by least squares; what no slip misses bounds the error.

References: Goursat's representation, Langlois and Deville 2014, *Slow Viscous Flow*,
doi 10.1007/978-3-319-03835-3.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["SeriesCell"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class SeriesCell:
    """Shape factor and surface pressures of a fiber in its cell; lengths in half-lengths.

    Parameters
    ----------
    ratio : float
        ``r_e`` [-], above one.
    domain : float
        ``M``: the cell's radius is ``M/2``.
    terms : int
        Odd powers of each kind.
    points : int
        On each wall; more than there are unknowns.

    Attributes
    ----------
    shape_factor : float
        ``B`` [-].
    misfit : float
        Largest slip on the walls [1/s times the half-length] at unit strain.
    """

    def __init__(self, ratio: float, domain: float, terms: int = 80, points: int = 400) -> None:
        self._c, self._m = 0.5 * (1.0 + 1.0 / ratio), (ratio - 1.0) / (ratio + 1.0)
        self._radius, self._terms = 0.5 * domain, terms
        angle = 2.0 * np.pi * (np.arange(points) + 0.5) / points
        ellipse = np.exp(1j * angle)
        ring = self._radius * ellipse
        q = np.concatenate([ellipse, self._preimage(ring)])
        z = np.concatenate([self._map(ellipse), ring])
        on_fiber = np.arange(2 * points) < points
        solved = [
            self._solve(phase, np.where(on_fiber, 0.0, phase * np.conj(z)), z, q, on_fiber)
            for phase in (1.0 + 0.0j, 1.0j)
        ]
        self._coefficients = [coefficients for coefficients, _ in solved]
        self.misfit = max(misfit for _, misfit in solved)
        self.shape_factor = float(self._coefficients[1][-1])

    def _solve(
        self, phase: complex, target: Complex, z: Complex, q: Complex, on_fiber: NDArray[np.bool_]
    ) -> tuple[Array, float]:
        """Return the coefficients for one far field, with the spin last, and the largest slip."""
        basis = list(self._basis(z, q))
        columns = [phase * f - np.conj(phase) * z * np.conj(slope) for f, slope in basis]
        columns += [-np.conj(phase * f) for f, _ in basis]
        columns.append(np.where(on_fiber, -1j * z, 0.0))  # minus the fiber's own spin
        matrix = np.array(columns).T
        # 1/q in the second function: source or torque
        keep = np.delete(np.arange(matrix.shape[1]), 3 * self._terms)
        system = np.concatenate([matrix.real, matrix.imag])[:, keep]
        size = np.linalg.norm(system, axis=0)
        size[size == 0.0] = 1.0
        right = np.concatenate([target.real, target.imag])
        answer, *_ = np.linalg.lstsq(system / size, right, rcond=1e-14)
        full = np.zeros(matrix.shape[1])
        full[keep] = answer / size
        return full, float(np.max(np.abs(system / size @ answer - right)))

    def _map(self, q: Complex) -> Complex:
        return np.asarray(self._c * (q + self._m / q))

    def _preimage(self, z: Complex) -> Complex:
        root = z * np.sqrt(1.0 - 4.0 * self._c**2 * self._m / z**2)
        return np.asarray((z + root) / (2.0 * self._c))

    def _basis(self, z: Complex, q: Complex) -> Iterator[tuple[Complex, Complex]]:
        """Yield each function with its derivative by ``z``."""
        slope = 1.0 / (self._c * (1.0 - self._m / q**2))
        for n in range(1, 2 * self._terms, 2):
            power = (z / self._radius) ** n
            yield power, n * power / z
        for n in range(1, 2 * self._terms, 2):
            yield q**-n, -n * q ** (-n - 1) * slope

    def basis(self, surface: Array) -> Array:
        """Return ``P_1, P_2`` [-] at eccentric angles [rad], (n, 2), zero mean on the cell's edge.

        Parameters
        ----------
        surface : (n,) array
            Eccentric angles.
        """
        q = np.exp(1j * surface)
        ring = self._radius * np.exp(2j * np.pi * np.arange(800) / 800)
        places = ((self._map(q), q), (ring, self._preimage(ring)))
        pressures = []
        for phase, full in zip((1.0, 1.0j), self._coefficients, strict=True):
            on_fiber, on_edge = (
                sum(
                    -4.0 * np.real(phase * weight * slope)
                    for weight, (_, slope) in zip(full, self._basis(z, at), strict=False)
                )
                for z, at in places
            )
            pressures.append(on_fiber - np.mean(on_edge))
        return np.stack(pressures, axis=-1)
