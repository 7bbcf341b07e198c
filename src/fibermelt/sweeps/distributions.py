"""The distributions that a sweep samples: scipy's, by the numbers that a study names.

A sample is the value below which a share in (0, 1) of the distribution lies, so that a design of
points in the unit cube becomes one of values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["Distribution", "Kind"]

Kind = Literal["uniform", "normal", "lognormal", "Weibull", "measured"]


@dataclass(frozen=True)
class Distribution:
    """What a parameter is sampled from, in its SI unit.

    Parameters
    ----------
    kind : str
        ``"uniform"``: every value from ``low`` to ``high`` alike; ``"normal"``, of ``mean`` and
        standard deviation ``std``; ``"lognormal"``: half lies below ``median``, 68 % from it over
        ``factor`` to it times that; ``"Weibull"``: ``1 - exp(-(x / scale)^shape)`` lies below
        ``x``, as of the lengths of short fibers (Fu and Lauke, Compos. Sci. Technol. 56, 1996,
        1179-1190, who write ``1 - exp(-a x^b)``: ``shape = b``, ``scale = a^(-1/b)``);
        ``"measured"``: ``counts`` between ``edges``, inside a bin every value alike.
    numbers : tuple
        Those of its kind, in this order.
    between : tuple of float, optional
        What lies below the first and above the second is cut off.
    """

    kind: Kind
    numbers: tuple[Any, ...]
    between: tuple[float, float] | None = None

    def at(self, shares: Array) -> Array:
        """Return the values below which shares in (0, 1) lie.

        Cut off they are those of the whole at ``(1 - u) F(low) + u F(high)``; if ``low`` lies above
        the median the same from the top, where ``F`` near 1 has no digits left.
        """
        import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

        whole = self._whole
        if self.between is None:
            return np.asarray(whole.ppf(shares), dtype=float)
        share, value = (whole.sf, whole.isf) if self._is_high else (whole.cdf, whole.ppf)
        # Both terms are positive: their sum keeps the digits that a difference would lose.
        low, high = map(share, self.between)
        # Rounding may take the inverse an ulp beyond a bound that a key does not pass.
        values: Array = np.clip(value((1.0 - shares) * low + shares * high), *self.between)
        return values

    @property
    def kept(self) -> float:
        """Return which share of the whole is left."""
        if self.between is None:
            return 1.0
        low, high = map(self._whole.sf if self._is_high else self._whole.cdf, self.between)
        return float(abs(high - low))

    @property
    def _is_high(self) -> bool:
        return self.between is not None and self._whole.cdf(self.between[0]) > 0.5

    @cached_property
    def _whole(self) -> Any:
        """Return scipy's distribution."""
        from scipy import stats  # noqa: PLC0415  lazy: most sweeps are grids

        one, other = self.numbers
        if self.kind == "uniform":
            return stats.uniform(one, other - one)
        if self.kind == "normal":
            return stats.norm(one, other)
        if self.kind == "lognormal":
            return stats.lognorm(math.log(other), scale=one)
        if self.kind == "Weibull":
            return stats.weibull_min(other, scale=one)
        return stats.rv_histogram((other, one), density=False)
