"""A closed curve from its samples, with the expansions that finding its extreme points takes."""

from __future__ import annotations

from functools import cached_property
from math import factorial

import numpy as np
from numpy.typing import NDArray

__all__ = ["TrigonometricCurve", "fold_angle"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

OVERSAMPLING = 4
"""Expansion points per sample: half a spacing is then 0.4 rad of the highest harmonic."""

TAYLOR_ORDER = 7
"""Terms of the local expansions: ``0.4^8/8!`` is below 1e-7 of a harmonic that is itself tiny."""

POWERS = np.arange(1.0, TAYLOR_ORDER + 1)
"""Factors that the terms of an expansion get when it is differentiated."""

NEWTON_STEPS = 6
"""Newton steps on ``P'(s).e = 0``: quadratic from half an expansion spacing, three suffice."""


SEARCH_STRIDE = 2
"""Expansion points between those that are searched: Newton's method walks the rest."""

CANDIDATES = 3
"""Local maxima that are followed to their tops: under-resolved surfaces have near ties."""


class TrigonometricCurve:
    """A closed curve given by samples, with Taylor expansions that replace its Fourier sum.

    Parameters
    ----------
    samples : (m, 2) array
        Points of the curve at the angles ``2 pi j/m``, repeated after half of them.
    """

    def __init__(self, samples: Array) -> None:
        half = samples[: samples.shape[0] // 2]
        n = half.shape[0]
        modes = np.fft.rfft(half, axis=0)
        if n % 2 == 0:
            modes[-1] *= 0.5  # the Nyquist mode is shared by both signs
        self.n = OVERSAMPLING * n
        self.spacing = np.pi / self.n
        wave = 2.0j * np.arange(modes.shape[0])[:, None]
        self.terms = np.stack(
            [
                np.fft.irfft(modes * wave**k, n=self.n, axis=0) * (OVERSAMPLING / factorial(k))
                for k in range(TAYLOR_ORDER + 1)
            ]
        )

    def point(self, angle: Array) -> Array:
        """Return the curve at the angles ``s`` [rad], shape ``s.shape + (2,)``."""
        index, offset = self._nearest(angle)
        value: Array = _horner(self.terms[:, index, :], offset[..., None])
        return value

    def derivatives(self, angle: Array) -> tuple[Array, Array]:
        """Return the first and the second derivative at the angles ``s``, ``s.shape + (2,)``."""
        index, offset = self._nearest(angle)
        first = _derivative(self.terms[:, index, :])
        x = offset[..., None]
        return _horner(first, x), _horner(_derivative(first), x)

    def _nearest(self, angle: Array) -> tuple[Index, Array]:
        scaled = np.asarray(angle) / self.spacing
        nearest = np.rint(scaled)
        return nearest.astype(np.intp) % self.n, (scaled - nearest) * self.spacing

    def maximise(self, phase: Array, start: Array) -> Array:
        """Return the local maximum of ``e(phase).P(s)`` next to ``start`` [rad].

        Newton's method; where the curve is flat along ``e`` (nothing to choose) it stays.
        """
        direction = np.stack([np.cos(phase), np.sin(phase)], axis=-1)
        s = np.array(start, dtype=np.float64)
        for _ in range(NEWTON_STEPS):
            index, offset = self._nearest(s)
            height = np.einsum("k...i,...i->k...", self.terms[:, index, :], direction)
            slope = _derivative(height)
            first, second = _horner(slope, offset), _horner(_derivative(slope), offset)
            concave = second < 0.0
            step = np.where(concave, -first / np.where(concave, second, -1.0), 0.0)
            s += np.clip(step, -self.spacing, self.spacing)
        return s

    @cached_property
    def farthest(self) -> float:
        """Return the largest distance from the origin, ``max_s |P(s)|``, to rounding.

        The farthest point is the extreme one in its own direction: a few rounds of both.
        """
        near = np.argsort(np.hypot(*self.terms[0].T))[-4:]
        s = near * self.spacing
        for _ in range(NEWTON_STEPS):
            point = self.point(s)
            s = self.maximise(np.arctan2(point[:, 1], point[:, 0]), s)
        return float(np.max(np.hypot(*self.point(s).T)))

    def search(self, phase: Array) -> Array:
        """Return the global maximum of ``e(phase).P(s)`` as an angle in (-pi/2, pi/2] [rad].

        The highest of the local maxima among the expansion points are all refined: which of two
        near ties is the higher cannot be seen before.
        """
        flat = np.ravel(phase)
        found = np.empty(flat.shape)
        coarse = self.terms[0][::SEARCH_STRIDE]
        block = max(1, (1 << 20) // coarse.shape[0])
        for at in range(0, flat.size, block):
            part = flat[at : at + block]
            heights = np.stack([np.cos(part), np.sin(part)], axis=-1) @ coarse.T
            candidates = _highest_tops(heights)
            phases = np.broadcast_to(part[:, None], candidates.shape)
            refined = self.maximise(phases, candidates * (SEARCH_STRIDE * self.spacing))
            point = self.point(refined)
            value = np.cos(phases) * point[..., 0] + np.sin(phases) * point[..., 1]
            best = np.argmax(value, axis=1)
            found[at : at + block] = refined[np.arange(part.size), best]
        return fold_angle(found).reshape(np.shape(phase))


def _highest_tops(heights: Array) -> Index:
    """Return the places of the highest local maxima of each row, a ring; ``heights`` is used up.

    A row with fewer of them than `CANDIDATES` has its first place instead.
    """
    higher = heights[:, 1:] > heights[:, :-1]
    seam = heights[:, 0] > heights[:, -1]
    lower = heights[:, 1:] < heights[:, :-1]
    edge = heights[:, 0] < heights[:, -1]
    below = np.empty(heights.shape, dtype=bool)
    below[:, 1:], below[:, 0] = lower, edge
    below[:, :-1] |= higher
    below[:, -1] |= seam
    heights[below] = -np.inf
    rows = np.arange(len(heights))
    tops = np.empty((len(heights), CANDIDATES), dtype=np.intp)
    for k in range(CANDIDATES):
        tops[:, k] = np.argmax(heights, axis=1)
        heights[rows, tops[:, k]] = -np.inf
    return tops


def _horner(coefficients: Array, x: Array) -> Array:
    value: Array = coefficients[-1]
    for term in coefficients[-2::-1]:
        value = value * x + term
    return value


def _derivative(coefficients: Array) -> Array:
    powers = POWERS[: len(coefficients) - 1].reshape((-1,) + (1,) * (coefficients.ndim - 1))
    derived: Array = coefficients[1:] * powers
    return derived


def fold_angle(angle: Array) -> Array:
    """Return the angle in (-pi/2, pi/2] [rad]: the two ends of a fiber are not told apart."""
    folded: Array = angle - np.pi * np.ceil(angle / np.pi - 0.5)
    return folded
