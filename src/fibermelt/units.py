"""Units at the door: ``"24 mm/s"`` becomes 0.024, and everything inside is an SI float.

This is the only module that knows anything but SI: what is read is parsed here, and what is shown
takes its factors from here. pint is loaded when the first quantity with a unit is read.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import cache
from tokenize import TokenError
from typing import TYPE_CHECKING, Any

from fibermelt.errors import LONGEST, ConfigError, legible

if TYPE_CHECKING:
    from pint import UnitRegistry

__all__ = [
    "DEGREES",
    "KPA",
    "MM",
    "MPA",
    "MS",
    "NM",
    "PERCENT",
    "SHOWN",
    "UM",
    "ZERO_CELSIUS",
    "celsius_meant",
    "in_celsius",
    "parse",
    "parse_difference",
    "parse_plane",
    "shown",
]

_QUANTITY = re.compile(
    r"\s*+(?P<number>[+-]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][+-]?\d++)?)"
    r"\s*+(?P<unit>(?:1\s*+/|[^\d\s]).*)?",
    re.DOTALL,
)
_UNIT = re.compile(r"(?:1?\s*+/)?(?:[\s*/()]|[A-Za-z%µμ]++(?:\^?[+-]?\d)?)*+")
_PLANE = re.compile(r"\s*([xyz])\s*(?:=\s*(\S.*?)\s*)?")
_SEPARATED = re.compile(r"[,_]\d")
_EXPONENT = re.compile(r"([A-Za-zµμ])([+-]?\d)")

MINUS = "\N{MINUS SIGN}"
"""What the report's page has for ``-``."""

_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
"""Raised digits, as the report's page writes ``kg/m³``, to those of ``kg/m3``."""

_PRODUCT = str.maketrans("·⋅∙", "***")
"""Dots of a product: the middle dot, the operator of Unicode, which is not the same, the bullet."""

_SIGNS = {"℃": "degC", "°C": "degC", "°": "deg", "%": "percent"}
"""Signs to the names that the unit library has for them, the longer ones first."""

POWER_OF_TEN_TOLERANCE = 1e-12
"""Largest distance of log10(factor) from an integer that is rounding in the unit library."""

MM, UM, NM, MS = 1e3, 1e6, 1e9, 1e3
"""Millimetres, micrometres and nanometres in a metre, milliseconds in a second."""

KPA, MPA = 1e-3, 1e-6
"""Kilopascals and megapascals in a pascal."""

PERCENT, DEGREES = 100.0, 180.0 / math.pi
"""Hundredths in one, degrees in a radian."""

SHOWN = {
    "mm": MM,
    "mm²": MM**2,
    "µm": UM,
    "nm": NM,
    "ms": MS,
    "kPa": KPA,
    "MPa": MPA,
    "%": PERCENT,
    "°": DEGREES,
}
"""Units that results are shown in: how many of each are one of its SI unit."""

ZERO_CELSIUS = 273.15
"""0 degC [K]."""

MANY = 2.0**20
"""Units that are converted for the factor of a scale with a zero of its own: beside so many, its
255 K (0 degF) cost no digits."""

LINEARITY_TOLERANCE = 1e-9
"""Largest part by which two units may miss the double of one: above rounding, below a decibel."""


@cache
def _registry() -> UnitRegistry[float]:
    """Return the one unit registry, made at first use: it costs half a second."""
    import pint  # noqa: PLC0415  lazy: help and closed forms never need it

    return pint.UnitRegistry()


def _pint_unit(unit: str) -> str:
    """Return a unit as the unit library spells it: ``m3`` is ``m^3``, ``Pa·s`` a product."""
    spelled = unit.strip().translate(_PRODUCT).replace("**", "^")
    for sign, name in _SIGNS.items():
        spelled = spelled.replace(sign, name)
    spelled = spelled.translate(_RAISED)
    if len(spelled) > LONGEST or not _UNIT.fullmatch(spelled):
        raise ValueError(unit)
    return _EXPONENT.sub(r"\1^\2", "1" + spelled if spelled.startswith("/") else spelled)


@cache
def _scale(unit: str, si_unit: str) -> tuple[float, float]:
    """Return ``(factor, offset)`` such that the SI value is ``factor * number + offset``.

    Raises
    ------
    ConfigError
        If ``unit`` is not known, is logarithmic, or is of another dimension than ``si_unit``.
    """
    import pint  # noqa: PLC0415  lazy, see _registry

    registry = _registry()
    named = f'has the unit "{legible(unit)}", which'
    try:
        source = registry.parse_units(_pint_unit(unit))
    except (pint.PintError, ValueError, AssertionError, AttributeError, TokenError) as error:
        msg = f"{named} is not known"
        raise ConfigError(msg) from error
    target = registry.parse_units(_pint_unit(si_unit) if si_unit else "dimensionless")
    try:
        zero, one, two = (_converted(count, source, target) for count in (0.0, 1.0, 2.0))
    except pint.DimensionalityError as error:
        wanted = "an angle" if si_unit == "rad" else _kind(target)
        msg = f"{named} measures {_kind(source)}, not {wanted}"
        raise ConfigError(msg) from error
    except (pint.PintError, OverflowError) as error:
        msg = f"{named} cannot be converted to {si_unit or 'a pure number'}"
        raise ConfigError(msg) from error
    step = one - zero
    if not (math.isfinite(step) and step > 0):
        msg = f"{named} cannot be converted to {si_unit or 'a pure number'}"
        raise ConfigError(msg)
    if abs(two - one - step) > LINEARITY_TOLERANCE * max(abs(step), abs(two)):
        msg = f"{named} is logarithmic: write the value itself"
        raise ConfigError(msg)
    return (_converted(MANY, source, target) - zero) / MANY if zero else step, zero


def _converted(count: float, source: Any, target: Any) -> float:
    """Return so many of a unit in another."""
    return float(_registry().Quantity(count, source).to(target).magnitude)


def _kind(unit: object) -> str:
    """Return the dimension of a unit in words, such as ``length / time``."""
    words = str(getattr(unit, "dimensionality", "")).replace("[", "").replace("]", "")
    return "a pure number" if words in {"", "dimensionless"} else words.replace("**", "^")


def _scaled(number: str, factor: float) -> float:
    """Return ``number * factor``; an exact decimal shift where the factor is a power of ten.

    So ``"3.175 mm"`` is the very float 0.003175 and addresses the same stored result.
    """
    plain = float(number)
    exponent = math.log10(factor)
    if plain and math.isfinite(plain) and abs(exponent - round(exponent)) < POWER_OF_TEN_TOLERANCE:
        return float(Decimal(number).scaleb(round(exponent)))
    return plain * factor


def parse(value: object, unit: str) -> float:
    """Return a quantity in SI.

    Parameters
    ----------
    value : str, int or float
        ``"24 mm/s"``, ``"30 deg"``, ``"8.4 %"``, ``"230 degC"``; or a number, which is SI already.
        A text without a unit is accepted only where ``unit`` is empty.
    unit : str
        The SI unit expected, such as ``"m/s"`` or ``"Pa s"``; empty for a pure number.

    Returns
    -------
    float
        The value in ``unit``; finite.

    Raises
    ------
    ConfigError
        If the value is no number with a unit, or has another dimension. The message does not
        name the key: who reads the configuration knows it and puts it in front.

    Examples
    --------
    >>> parse("24 mm/s", "m/s")
    0.024
    >>> parse(0.003, "m")
    0.003
    """
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        msg = f"is not a number{_with_unit(unit)}"
        raise ConfigError(msg)
    if not isinstance(value, str):
        number = _float(value)
    else:
        match = _QUANTITY.fullmatch(value.replace(MINUS, "-"))
        if match is None:
            msg = f"is not a number{_with_unit(unit)}"
            raise ConfigError(msg)
        given, given_number = (match["unit"] or "").strip(), match["number"]
        if unit and not given:
            msg = f"has no unit: write one, or the bare number {legible(given_number)} for {unit}"
            raise ConfigError(msg)
        if _SEPARATED.match(given):
            msg = (
                f'has "{given[0]}" in its number: write a decimal point, and nothing between '
                "thousands"
            )
            raise ConfigError(msg)
        factor, offset = _scale(given, unit) if given else (1.0, 0.0)
        number = _scaled(given_number, factor) + offset
    if not math.isfinite(number):
        msg = "is not finite"
        raise ConfigError(msg)
    return number


def parse_plane(text: str) -> tuple[int, float]:
    """Return the axis (0, 1 or 2) and the place on it [m] of a plane across x, y or z.

    Parameters
    ----------
    text : str
        ``"y = 2 mm"``; ``"y"`` alone for ``y = 0``.

    Raises
    ------
    ConfigError
        If it is none; without the key, as of `parse`.
    """
    match = _PLANE.fullmatch(text)
    if match is None:
        msg = 'must be "x", "y" or "z", or such as "y = 2 mm"'
        raise ConfigError(msg)
    axis, place = match.groups()
    return "xyz".index(axis), parse(place, "m") if place else 0.0


def celsius_meant(value: float, unit: str) -> str:
    """Return what to add to the refusal of a temperature that is too low; else nothing.

    No melt is below the freezing point of water: a bare number there was meant in degrees Celsius.

    Parameters
    ----------
    value : float
        What was refused [unit].
    unit : str
        Its SI unit.
    """
    return in_celsius(value) if unit == "K" and -ZERO_CELSIUS <= value < ZERO_CELSIUS else ""


def in_celsius(value: float) -> str:
    """Return how to write a number that was taken for kelvin as degrees Celsius."""
    return f'; a number without unit is in K: for degrees Celsius write "{value:g} degC"'


def parse_difference(value: object, unit: str) -> float:
    """Return the difference of two quantities in SI: of temperatures without their zero.

    Parameters
    ----------
    value, unit
        As in `parse`.

    Raises
    ------
    ConfigError
        As `parse`.

    Examples
    --------
    >>> parse_difference("10 degC", "K")
    10.0
    """
    number = parse(value, unit)
    match = _QUANTITY.fullmatch(value.replace(MINUS, "-")) if isinstance(value, str) else None
    given = (match["unit"] or "").strip() if match else ""
    if match is None or not given:
        return number
    return _scaled(match["number"], _scale(given, unit)[0])


def _float(number: float) -> float:
    """Return a number as a float; an integer beyond the largest one is infinite."""
    try:
        return float(number)
    except OverflowError:
        return math.inf


def _with_unit(unit: str) -> str:
    return f" in {unit}" if unit else ""


def shown(value: float, unit: str, like: str = "") -> str:
    """Return an SI value as a person writes it.

    Parameters
    ----------
    value : float
        The value in ``unit``.
    unit : str
        Its SI unit; may be empty.
    like : str
        Another unit of the same dimension to show it in, such as ``"mm"``.
    """
    if like and like != unit:
        factor, offset = _scale(like, unit)
        return f"{(value - offset) / factor:.12g} {like}"
    return f"{value:.12g} {unit}".rstrip()
