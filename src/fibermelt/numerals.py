"""Numbers in words: with the digits that the size of the thing asks for, none rounded away."""

from __future__ import annotations

import math

__all__ = ["ERROR_DIGITS", "measured", "number", "places", "rounded"]

NOISE = 1e-9
"""Smaller than this part of the size that it is told by, a number is what rounding left of zero."""

MOST = 7
"""Decimals at most; of smaller things numbers are told with a power of ten."""

SMALLEST, LARGEST = 1e-3, 1e6
"""Magnitudes between which a number that is told by itself has no power of ten."""

ERROR_DIGITS = 2
"""Significant digits of an error estimate: it is no better known."""


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


def number(value: float, digits: int = 4) -> str:
    """Return a number with so many significant digits, whole ones as they are.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        Significant digits.
    """
    if value == 0 or not math.isfinite(value):
        return f"{value:g}"
    if isinstance(value, int) or SMALLEST <= abs(value) < LARGEST:
        return rounded(value, value, digits) if value != int(value) else f"{value:.0f}"
    return f"{value:.{digits - 1}e}"


def measured(
    value: float, error: float = math.nan, *, size: float | None = None, digits: int = 4
) -> str:
    """Return a number with its error, written to the error's digits.

    Parameters
    ----------
    value, error : float
        The number and its error, in the same unit; an error that is not finite or not above
        zero is not told.
    size : float, optional
        Magnitude of what it is told of, in the same unit: the decimals of what has no error.
    digits : int
        Significant digits of what has no error.
    """
    if not (math.isfinite(error) and error > 0):
        return number(value, digits) if size is None else rounded(value, size, digits)
    decimals = max(0, ERROR_DIGITS - 1 - math.floor(math.log10(error)))
    if decimals > ERROR_DIGITS - math.log10(SMALLEST):
        return f"{number(value, 6)} ± {number(error, ERROR_DIGITS)}"
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"
