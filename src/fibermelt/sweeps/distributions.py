"""The distributions that a sweep samples: exact shares below and above a value, and their inverses.

A sample is the value below which a share in (0, 1) of the distribution lies, so that a design of
points in the unit cube becomes one of values. Shares are told from both ends: near its upper end
the share above a value has digits that one less the share below has lost.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Protocol

__all__ = [
    "Distribution",
    "Histogram",
    "Lognormal",
    "Normal",
    "Sampled",
    "Truncated",
    "Uniform",
    "Weibull",
]


class Sampled(Protocol):
    """What can be sampled; values are in the SI unit of what varies."""

    def at(self, share: float) -> float:
        """Return the value below which a share lies, in (0, 1)."""


class Distribution(Sampled, Protocol):
    """What can be sampled whole, or truncated."""

    def below(self, value: float) -> float:
        """Return the share that lies below a value, the cumulative distribution."""

    def above(self, value: float) -> float:
        """Return the share that lies above a value."""

    def from_top(self, share: float) -> float:
        """Return the value above which a share lies, in (0, 1)."""


@dataclass(frozen=True)
class Uniform:
    """Every value from ``low`` to ``high`` alike."""

    low: float
    high: float

    def below(self, value: float) -> float:
        """Return the share that lies below a value."""
        return min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))

    def above(self, value: float) -> float:
        """Return the share that lies above a value."""
        return min(1.0, max(0.0, (self.high - value) / (self.high - self.low)))

    def at(self, share: float) -> float:
        """Return the value below which a share lies."""
        return self.low + share * (self.high - self.low)

    def from_top(self, share: float) -> float:
        """Return the value above which a share lies."""
        return self.high - share * (self.high - self.low)


@dataclass(frozen=True)
class Normal:
    """The normal distribution of a mean and a standard deviation ``std``."""

    mean: float
    std: float

    def below(self, value: float) -> float:
        """Return the share that lies below a value."""
        return _normal_share((value - self.mean) / self.std)

    def above(self, value: float) -> float:
        """Return the share that lies above a value."""
        return _normal_share((self.mean - value) / self.std)

    def at(self, share: float) -> float:
        """Return the value below which a share lies."""
        return self.mean + _normal_value(share) * self.std

    def from_top(self, share: float) -> float:
        """Return the value above which a share lies."""
        return self.mean - _normal_value(share) * self.std


@dataclass(frozen=True)
class Lognormal:
    """The distribution of what has a normal logarithm.

    Parameters
    ----------
    median : float
        Half lies below it.
    factor : float
        One standard deviation of the logarithm: 68 % lie from the median over it to the median
        times it.
    """

    median: float
    factor: float

    def below(self, value: float) -> float:
        """Return the share that lies below a value."""
        return _normal_share(self._deviation(value))

    def above(self, value: float) -> float:
        """Return the share that lies above a value."""
        return _normal_share(-self._deviation(value))

    def at(self, share: float) -> float:
        """Return the value below which a share lies."""
        return self.median * math.exp(_normal_value(share) * math.log(self.factor))

    def from_top(self, share: float) -> float:
        """Return the value above which a share lies."""
        return self.median * math.exp(-_normal_value(share) * math.log(self.factor))

    def _deviation(self, value: float) -> float:
        """Return how many standard deviations a value lies above the median."""
        if value <= 0.0:
            return -math.inf
        return math.log(value / self.median) / math.log(self.factor)


@dataclass(frozen=True)
class Weibull:
    """The Weibull distribution, ``1 - exp(-(x / scale)^shape)`` below ``x``.

    Lengths of short fibers follow it (Fu and Lauke, Compos. Sci. Technol. 56, 1996, 1179-1190, who
    write ``1 - exp(-a x^b)``: ``shape = b``, ``scale = a^(-1/b)``).

    Parameters
    ----------
    scale : float
        ``1 - 1/e``, 63 %, lie below it.
    shape : float
        Above 0 [-]: 1 is the exponential distribution, more is narrower.
    """

    scale: float
    shape: float

    def below(self, value: float) -> float:
        """Return the share that lies below a value."""
        return -math.expm1(-self._exponent(value))

    def above(self, value: float) -> float:
        """Return the share that lies above a value."""
        return math.exp(-self._exponent(value))

    def at(self, share: float) -> float:
        """Return the value below which a share lies."""
        return float(self.scale * (-math.log1p(-share)) ** (1.0 / self.shape))

    def from_top(self, share: float) -> float:
        """Return the value above which a share lies."""
        return float(self.scale * (-math.log(share)) ** (1.0 / self.shape))

    def _exponent(self, value: float) -> float:
        try:
            return float((max(value, 0.0) / self.scale) ** self.shape)
        except OverflowError:
            return math.inf


@dataclass(frozen=True)
class Histogram:
    """What was counted between edges; inside a bin every value alike.

    Parameters
    ----------
    edges : tuple of float
        Edges of the bins, rising.
    counts : tuple of float
        How many, or which share, each bin holds: one less than there are edges, none below 0, at
        least one above it.
    """

    edges: tuple[float, ...]
    counts: tuple[float, ...]

    @cached_property
    def _shares(self) -> tuple[float, ...]:
        """Return the share that lies below each edge."""
        total = math.fsum(self.counts)
        return tuple(found / total for found in accumulate(self.counts, initial=0.0))

    def below(self, value: float) -> float:
        """Return the share that lies below a value."""
        if value <= self.edges[0]:
            return 0.0
        if value >= self.edges[-1]:
            return 1.0
        k = bisect_right(self.edges, value) - 1
        part = (value - self.edges[k]) / (self.edges[k + 1] - self.edges[k])
        return self._shares[k] + part * (self._shares[k + 1] - self._shares[k])

    def above(self, value: float) -> float:
        """Return the share that lies above a value."""
        return 1.0 - self.below(value)

    def at(self, share: float) -> float:
        """Return the value below which a share lies: of an empty bin its upper edge."""
        # Rounding may leave the sum of all shares an ulp from 1: the last bin that holds any.
        last = max(k for k, count in enumerate(self.counts) if count)
        k = min(bisect_right(self._shares, share) - 1, last)
        held = self._shares[k + 1] - self._shares[k]
        part = min(1.0, (share - self._shares[k]) / held)
        return self.edges[k] + part * (self.edges[k + 1] - self.edges[k])

    def from_top(self, share: float) -> float:
        """Return the value above which a share lies."""
        return self.at(1.0 - share)


@dataclass(frozen=True)
class Truncated:
    """A distribution of which only what lies between two values is left.

    The value at a share ``u`` is that of the whole at ``(1 - u) F(low) + u F(high)``; if ``low``
    lies above the median the same from the top, where ``F`` near 1 has no digits left.

    Parameters
    ----------
    whole : Distribution
        The distribution.
    low, high : float
        What lies below and above is cut off.
    """

    whole: Distribution
    low: float
    high: float

    @property
    def kept(self) -> float:
        """Return which share of the whole is left."""
        if self._is_high:
            return self.whole.above(self.low) - self.whole.above(self.high)
        return self.whole.below(self.high) - self.whole.below(self.low)

    @property
    def _is_high(self) -> bool:
        return self.whole.below(self.low) > 0.5

    def at(self, share: float) -> float:
        """Return the value below which a share lies."""
        # Both terms are positive: their sum keeps the digits that a difference would lose.
        if self._is_high:
            top = (1.0 - share) * self.whole.above(self.low) + share * self.whole.above(self.high)
            value = self.whole.from_top(top)
        else:
            low, high = self.whole.below(self.low), self.whole.below(self.high)
            value = self.whole.at((1.0 - share) * low + share * high)
        # Rounding may take the inverse an ulp beyond a bound that a key does not pass.
        return min(max(value, self.low), self.high)


def _normal_share(deviation: float) -> float:
    """Return the share of the standard normal distribution below a value."""
    from scipy.special import ndtr  # noqa: PLC0415  lazy: most sweeps are grids

    return float(ndtr(deviation))


def _normal_value(share: float) -> float:
    """Return the value below which a share of the standard normal distribution lies."""
    from scipy.special import ndtri  # noqa: PLC0415  lazy: most sweeps are grids

    return float(ndtri(share))
