"""Linear maps of the director that remember how far they have turned.

The director equation ``p_dot = (W + B D) p - (p.B D p) p`` is the direction of a linear system,
``F_dot = (W + B D) F``: ``p = F p_0/|F p_0|``. In the plane ``F`` has determinant one and is known
with a *lift*: the angle ``turn``, continuous in time, by which ``F`` turns ``e_x``. It carries
every other direction with it: for ``r`` in [-pi/2, pi/2)

    turn(r + k pi) = k pi + turn + arctan2(det F sin r, (F e_x).(F p(r))),

because ``cross(F e_x, F p) = det F sin r`` never changes sign. Tumbling through any number of
turns therefore needs no unwrapping in time, and all initial angles cost one arctangent each.

Matrices are kept with norm one and the logarithm of their scale beside them: nothing overflows,
however long the shear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import read_only

__all__ = ["Propagator", "compose", "cumulate", "exponential", "identity"]

Array = NDArray[np.float64]

SERIES_BOUND = 1e-3
"""Below it ``sinh(x)/x`` is summed by four terms of its series, whose next one is 3e-30."""


@dataclass(frozen=True, eq=False)
class Propagator:
    """Maps ``F = exp(scale) matrix`` of determinant one, with the lifted angle of ``F e_x``.

    Parameters
    ----------
    matrix : (..., 2, 2) array
        ``F`` over its Frobenius norm [-].
    scale : (...) array
        Logarithm of that norm [-].
    turn : (...) array
        Angle of ``F e_x`` from the x axis [rad], continuous from zero at ``F = I``.
    """

    matrix: Array
    scale: Array
    turn: Array

    def read_only(self) -> Propagator:
        """Return the same maps, through which nobody can write."""
        return Propagator(*map(read_only, (self.matrix, self.scale, self.turn)))

    def part(self, index: slice) -> Propagator:
        """Return the maps at a slice of the last leading axis."""
        return Propagator(
            self.matrix[..., index, :, :], self.scale[..., index], self.turn[..., index]
        )

    def line(self, k: int) -> Propagator:
        """Return the maps of one path, counted over all leading axes but the last: (n,)."""
        n = self.turn.shape[-1]
        return Propagator(
            self.matrix.reshape(-1, n, 2, 2)[k],
            self.scale.reshape(-1, n)[k],
            self.turn.reshape(-1, n)[k],
        )

    def then(self, later: Propagator) -> Propagator:
        """Return these maps followed by others along the last leading axis."""
        return Propagator(
            np.concatenate([self.matrix, later.matrix], axis=-3),
            np.concatenate([self.scale, later.scale], axis=-1),
            np.concatenate([self.turn, later.turn], axis=-1),
        )

    def angles(self, angle: Array) -> Array:
        """Return the lifted image of directions [rad]; ``angle`` broadcasts with ``turn``."""
        half_turns = np.floor(angle / np.pi + 0.5)
        rest = angle - half_turns * np.pi
        g = self.matrix
        square = g[..., 0, 0] ** 2 + g[..., 1, 0] ** 2
        mixed = g[..., 0, 0] * g[..., 0, 1] + g[..., 1, 0] * g[..., 1, 1]
        cross = np.exp(-2.0 * self.scale) * np.sin(rest)
        ahead = np.arctan2(cross, square * np.cos(rest) + mixed * np.sin(rest))
        image: Array = half_turns * np.pi + self.turn + ahead
        return image


def identity(shape: tuple[int, ...]) -> Propagator:
    """Return maps that leave every direction as it is."""
    matrix = np.zeros((*shape, 2, 2))
    matrix[..., 0, 0] = matrix[..., 1, 1] = np.sqrt(0.5)
    return Propagator(matrix, np.full(shape, 0.5 * np.log(2.0)), np.zeros(shape))


def exponential(generator: Array) -> Propagator:
    """Return ``exp(generator)`` of traceless matrices that turn by less than half a turn.

    ``Omega^2 = q I`` with ``q = -det Omega``, hence ``exp Omega = cosh(sqrt q) I +
    sinh(sqrt q)/sqrt q Omega``, circular functions for ``q < 0``.

    Parameters
    ----------
    generator : (..., 2, 2) array
        Traceless; only ``[0, 0]``, ``[0, 1]`` and ``[1, 0]`` are read.
    """
    a, b, c = generator[..., 0, 0], generator[..., 0, 1], generator[..., 1, 0]
    q = a * a + b * c
    root = np.sqrt(np.abs(q))
    shift = np.where(q > 0.0, root, 0.0)
    series = 1.0 + q / 6.0 * (1.0 + q / 20.0 * (1.0 + q / 42.0))
    decay = np.exp(-2.0 * shift)
    safe = np.where(root > SERIES_BOUND, root, 1.0)
    # cosh and sinh over exp(shift), so that a strong stretch does not overflow
    even = np.where(q > 0.0, 0.5 * (1.0 + decay), np.cos(root))
    odd = np.where(q > 0.0, 0.5 * (1.0 - decay), np.sin(root)) / safe
    odd = np.where(root > SERIES_BOUND, odd, series * np.exp(-shift))
    matrix = np.empty(generator.shape)
    matrix[..., 0, 0] = even + odd * a
    matrix[..., 0, 1] = odd * b
    matrix[..., 1, 0] = odd * c
    matrix[..., 1, 1] = even - odd * a
    turn = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
    return _normalise(matrix, shift, turn)


def compose(second: Propagator, first: Propagator) -> Propagator:
    """Return ``second`` after ``first``; the lift of the product is the product of the lifts."""
    s, f = second.matrix, first.matrix
    product = np.empty(np.broadcast_shapes(s.shape, f.shape))
    for i in range(2):
        for j in range(2):
            product[..., i, j] = s[..., i, 0] * f[..., 0, j] + s[..., i, 1] * f[..., 1, j]
    return _normalise(product, second.scale + first.scale, second.angles(first.turn))


def cumulate(steps: Propagator) -> Propagator:
    """Return ``F_0 = I, F_1, F_2 F_1, ...`` along the last leading axis, one longer than it.

    A parallel prefix product: ``log2 n`` passes over all paths at once, whose rounding grows with
    ``log n`` instead of ``n``.
    """
    *lead, n = steps.turn.shape
    total = identity((*lead, 1)).then(steps)
    reach = 1
    while reach <= n:
        joined = compose(total.part(slice(reach, None)), total.part(slice(n + 1 - reach)))
        total = total.part(slice(reach)).then(joined)
        reach *= 2
    return total


def _normalise(matrix: Array, scale: Array, turn: Array) -> Propagator:
    """Return maps of norm one; the lift keeps its count of turns, the matrix gives the rest."""
    norm = np.sqrt(np.einsum("...ij,...ij->...", matrix, matrix))
    direct = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
    whole = 2.0 * np.pi * np.round((turn - direct) / (2.0 * np.pi))
    return Propagator(matrix / norm[..., None, None], scale + np.log(norm), direct + whole)
