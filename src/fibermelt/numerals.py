"""Numbers in words: with the digits that the size of the thing asks for, none rounded away."""

from __future__ import annotations

import math

__all__ = ["places", "rounded"]

NOISE = 1e-9
"""Smaller than this part of the size that it is told by, a number is what rounding left of zero."""

MOST = 7
"""Decimals at most; of smaller things numbers are told with a power of ten."""


def places(size: float, digits: int) -> int:
    """Return how many decimals give a number of a size so many significant digits, 0 or more.

    Parameters
    ----------
    size : float
        A magnitude; zero asks for no decimals.
    digits : int
        Significant digits.
    """
    if size == 0 or not math.isfinite(size):
        return 0
    # The power of ten after rounding: 0.9996 has the size of 1.
    return max(0, digits - 1 - int(f"{abs(size):.{digits - 1}e}".split("e")[1]))


def rounded(value: float, size: float, digits: int = 3) -> str:
    """Return a number with the decimals that a size in the same unit asks for.

    ``rounded(0.0314, 3.2)`` is 0.03 and ``rounded(0.0314, 0.4)`` is 0.031. What these decimals
    would round to zero is told with one digit of its own, after ``e`` a power of ten if need be.

    Parameters
    ----------
    value : float
        The number.
    size : float
        Magnitude of what it is told of, such as the nozzle's width for a place in it [as value].
    digits : int
        Significant digits of a number of that size.
    """
    if abs(value) <= NOISE * abs(size):
        value = 0.0
    decimals = places(size, digits)
    if decimals > MOST:
        return f"{value:.{digits - 1}e}" if value else "0"
    text = f"{value:.{decimals}f}"
    return text if value == 0 or float(text) != 0 else f"{value:.1g}"
