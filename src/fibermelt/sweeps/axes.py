"""What varies in a sweep: lists of values, ranges, and distributions that a design samples.

A distribution is told by the names in its table::

    { low = "2.8 mm", high = "3.2 mm" }                     # uniform
    { mean = "817 Pa s", std = "80 Pa s" }                  # normal
    { median = "42 um", factor = 1.4 }                      # lognormal
    { scale = 7, shape = 2 }                                # Weibull
    { edges = [2, 4, 6, 10], counts = [40, 120, 30] }       # measured, uniform inside each bin

All but the first may be cut off by ``between = [1, 50]``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise
from typing import Any, NoReturn

from fibermelt.engine.messages import unknown_key
from fibermelt.engine.overrides import SETTINGS
from fibermelt.engine.parameters import Declaration, declarations, excerpt
from fibermelt.errors import ConfigError, legible
from fibermelt.study.config import Config
from fibermelt.sweeps.distributions import Distribution, Kind
from fibermelt.units import parse, parse_difference

__all__ = ["MOST_CASES", "Axis", "distribution_told", "read_axis"]

MOST_CASES = 1_000_000
"""Cases of a sweep: beyond, a count was meant otherwise."""

LEAST_KEPT = 1e-6
"""Share of a distribution that is left between two values: of less, they are slips of the unit."""

MOST_FACTOR, LEAST_SHAPE, MOST_SHAPE = 1e3, 0.1, 1e3
"""Of a lognormal and a Weibull distribution: beyond, samples are further apart than numbers go."""

SAME_DIGITS = 12
"""Digits to which two values are the same: units bring roundings of some 1e-16 of a value."""

ENDS = frozenset(("from", "to", "count"))
BETWEEN = "between"

DISTRIBUTIONS: dict[frozenset[str], Kind] = {
    frozenset(("low", "high")): "uniform",
    frozenset(("mean", "std")): "normal",
    frozenset(("median", "factor")): "lognormal",
    frozenset(("scale", "shape")): "Weibull",
    frozenset(("edges", "counts")): "measured",
}
"""Which distribution a table of two entries stands for."""

TOLD = ("low", "high", "mean", "std", "median", "factor", "scale", "shape")
"""In which order the entries of a table are told: files written by machine have others."""

WAYS = (
    "a range is { from, to, count }, a distribution { low, high }, { mean, std }, "
    "{ median, factor }, { scale, shape } or { edges, counts }, all but the first with between "
    "= [low, high] if need be"
)


@dataclass(frozen=True)
class Axis:
    """What varies: one parameter, or some that vary together.

    Parameters
    ----------
    keys : tuple of str
        Their keys.
    values : tuple of tuple
        The values that it is given one by one, each as a person wrote it; empty for a
        distribution.
    distribution : Distribution, optional
        What a design samples; a range has one as well.
    told : str
        What is sampled, in words, as the study has it; empty for a list and for a range.
    """

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...] = ()
    distribution: Distribution | None = None
    told: str = ""

    @property
    def name(self) -> str:
        """Return the key under which its values are told."""
        return self.keys[0]


def read_axis(name: str, entry: object, known: Mapping[str, Declaration]) -> Axis:
    """Return what one key of the table ``[sweep]`` stands for.

    Parameters
    ----------
    name : str
        The key: that of a parameter, or of some, joined by commas.
    entry : object
        Its value, as TOML has it.
    known : mapping
        The parameters that there are.

    Raises
    ------
    ConfigError
        If it stands for nothing: the key, the value and the way out.
    """
    keys = tuple(key.strip() for key in name.split(","))
    for key in keys:
        if key not in known:
            _refuse_unquoted(key, entry, known)
            _refuse_unknown(key, known)
        if key == "study.parts":
            msg = "sweep: study.parts cannot vary: every case has the same results"
            raise ConfigError(msg)
    shown = f'sweep."{name}"'
    if isinstance(entry, Mapping):
        if len(keys) > 1:
            msg = f"{shown}: keys that vary together need a list of their values"
            raise ConfigError(msg)
        _refuse_range(shown, entry, known[keys[0]])
        return _Table(shown, entry, known[keys[0]].unit).axis(keys[0])
    if not isinstance(entry, list) or not entry:
        msg = f"{shown} = {excerpt(entry)}: must be a list of values, or a range"
        raise ConfigError(msg)
    for value in entry:
        if len(keys) > 1 and (not isinstance(value, list) or len(value) != len(keys)):
            msg = f"{shown}: {excerpt(value)}: must be a list of {len(keys)} values"
            raise ConfigError(msg)
    values = tuple((value,) if len(keys) == 1 else tuple(value) for value in entry)
    _refuse_repeated(shown, values, [known[key].unit for key in keys])
    return Axis(keys, values)


@dataclass(frozen=True)
class _Table:
    """The table of a range or of a distribution, read entry by entry.

    Parameters
    ----------
    shown : str
        Its key, for messages.
    entry : mapping
        What it holds.
    unit : str
        SI unit of the parameter.
    """

    shown: str
    entry: Mapping[str, Any]
    unit: str

    def axis(self, key: str) -> Axis:
        """Return the axis that it stands for."""
        if set(self.entry) == ENDS:
            return self._range(key)
        kind = DISTRIBUTIONS.get(frozenset(self.entry) - {BETWEEN})
        if kind is None:
            self._refuse(f": has {', '.join(map(excerpt, self.entry))}: {WAYS}")
        reading: dict[Kind, Callable[[], tuple[Any, Any]]] = {
            "uniform": self._uniform,
            "normal": self._normal,
            "lognormal": self._lognormal,
            "Weibull": self._weibull,
            "measured": self._measured,
        }
        numbers, between = reading[kind](), None
        if BETWEEN in self.entry:
            if kind == "uniform":
                self._refuse(": has low and high already: leave between away, or narrow them")
            between = self._between()
        found = Distribution(kind, numbers, between)
        if not found.kept >= LEAST_KEPT:
            self._wrong(
                BETWEEN,
                f"leaves {found.kept:.2g} of the distribution, at least {LEAST_KEPT:g} is "
                "needed: widen it, or correct the distribution",
            )
        return Axis((key,), (), found, self._told(found))

    def _told(self, found: Distribution) -> str:
        """Return a distribution in words, and what is left of one that is cut off."""
        if found.kind == "measured":
            edges, counts = self.entry["edges"], self.entry["counts"]
            told = f"measured, {len(counts)} bins from {edges[0]} to {edges[-1]}"
        else:
            given = [f"{name} {self.entry[name]}" for name in TOLD if name in self.entry]
            told = ", ".join([found.kind, *given])
        if found.between is None:
            return told
        low, high = self.entry[BETWEEN]
        return f"{told}, between {low} and {high} ({100 * found.kept:.3g} % of it)"

    def _range(self, key: str) -> Axis:
        count = self.entry["count"]
        if isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= MOST_CASES:
            self._refuse(f": count = {excerpt(count)}: must be a whole number, 2 to {MOST_CASES}")
        low, high = self._number("from"), self._number("to")
        if low == high:
            first, last = (excerpt(self.entry[name]) for name in ("from", "to"))
            self._refuse(
                f": from = {first}, to = {last}: are the same value: let them differ, or give a "
                "list of one"
            )
        values = tuple((low + (high - low) * k / (count - 1),) for k in range(count))
        return Axis((key,), values, Distribution("uniform", (low, high)))

    def _uniform(self) -> tuple[Any, Any]:
        low, high = self._number("low"), self._number("high")
        if not low < high:
            self._wrong("high", "must be above low")
        return low, high

    def _normal(self) -> tuple[Any, Any]:
        mean = self._number("mean")
        # The standard deviation is a difference: of 10 degC it is 10 K, not 283.
        std = self._parsed("std", lambda value: parse_difference(value, self.unit))
        if not std > 0:
            self._wrong("std", "must be above 0")
        return mean, std

    def _lognormal(self) -> tuple[Any, Any]:
        median = self._positive("median", self.unit)
        factor = self._number("factor", "")
        if not 1 < factor <= MOST_FACTOR:
            self._wrong(
                "factor",
                f"must be above 1 and at most {MOST_FACTOR:g}: 68 % lie from the median over it "
                "to the median times it",
            )
        return median, factor

    def _weibull(self) -> tuple[Any, Any]:
        scale, shape = self._positive("scale", self.unit), self._positive("shape", "")
        if not LEAST_SHAPE <= shape <= MOST_SHAPE:
            self._wrong("shape", f"must be from {LEAST_SHAPE:g} to {MOST_SHAPE:g}")
        return scale, shape

    def _measured(self) -> tuple[Any, Any]:
        edges, counts = self._numbers("edges", self.unit), self._numbers("counts", "")
        for one, other in pairwise(range(len(edges))):
            if not edges[one] < edges[other]:
                first, second = (excerpt(self.entry["edges"][k]) for k in (one, other))
                self._refuse(f": edges: {second} after {first}: must rise from bin to bin")
        if len(edges) != len(counts) + 1 or not counts:
            self._refuse(
                f": {len(edges)} edges and {len(counts)} counts: each bin has a count, and there "
                "is one edge more than there are bins"
            )
        for count, written in zip(counts, self.entry["counts"], strict=True):
            if count < 0:
                self._refuse(f": counts: {excerpt(written)}: must be at least 0")
        if not any(counts):
            self._refuse(": counts are all 0: at least one bin must hold something")
        return edges, counts

    def _between(self) -> tuple[float, float]:
        ends = self._numbers(BETWEEN, self.unit)
        if len(ends) != 2 or not ends[0] < ends[1]:
            self._wrong(BETWEEN, "must be two values, the lower one first")
        return ends[0], ends[1]

    def _number(self, name: str, unit: str | None = None) -> float:
        return self._parsed(name, lambda value: parse(value, self.unit if unit is None else unit))

    def _positive(self, name: str, unit: str) -> float:
        number = self._number(name, unit)
        if not number > 0:
            self._wrong(name, "must be above 0")
        return number

    def _parsed(self, name: str, read: Callable[[object], float]) -> float:
        try:
            return read(self.entry[name])
        except ConfigError as error:
            msg = f'{self.shown}: {name} = "{excerpt(self.entry[name])}" {error}'
            raise ConfigError(msg) from None

    def _numbers(self, name: str, unit: str) -> tuple[float, ...]:
        written = self.entry[name]
        if not isinstance(written, list):
            self._wrong(name, "must be a list of values")
        found = []
        for item, value in enumerate(written, 1):
            try:
                found.append(parse(value, unit))
            except ConfigError as error:
                msg = f'{self.shown}: {name}: item {item} = "{excerpt(value)}" {error}'
                raise ConfigError(msg) from None
        return tuple(found)

    def _wrong(self, name: str, what: str) -> NoReturn:
        self._refuse(f": {name} = {excerpt(self.entry[name])}: {what}")

    def _refuse(self, what: str) -> NoReturn:
        msg = f"{self.shown}{what}"
        raise ConfigError(msg)


def distribution_told(key: str, entry: object) -> str:
    """Return what a key of ``[sweep]`` samples, as `Axis.told`.

    Parameters
    ----------
    key : str
        The key.
    entry : object
        Its value, as TOML has it.
    """
    if not isinstance(entry, Mapping):
        return ""
    return read_axis(key, entry, {about.key: about for about in declarations(Config)}).told


def _refuse_unknown(key: str, known: Mapping[str, Declaration]) -> NoReturn:
    """Refuse a key that there is not, and tell the nearest parameter, or setting of a sweep."""
    bare = key.removeprefix("sweep.")
    if near := get_close_matches(bare, SETTINGS, n=1):
        msg = (
            f"sweep.{legible(key)}: unknown key; did you mean {near[0]}? In the table [sweep] it "
            f"stands without quotes, on the command line it is -s sweep.{near[0]}=..."
        )
        raise ConfigError(msg)
    msg = f"sweep.{unknown_key(bare, known)}"
    raise ConfigError(msg)


def _refuse_unquoted(key: str, entry: object, known: Mapping[str, Declaration]) -> None:
    """Refuse ``flow.gap = ...`` without quotes, which TOML takes for a table in a table."""
    inside = entry if isinstance(entry, Mapping) else {}
    meant = next((name for last in inside if (name := f"{key}.{last}") in known), None)
    if meant is not None:
        msg = f'sweep.{meant}: a key of [sweep] stands in quotes: write "{meant}" = ...'
        raise ConfigError(msg)


def _refuse_range(shown: str, entry: Mapping[str, Any], about: Declaration) -> None:
    """Refuse a range or a distribution of what is no number that may have any value."""
    if about.is_list:
        kind, example = "a list", "[[...], [...]]"
    elif about.choices:
        kind, example = "a word", json.dumps(about.choices[:2])
    elif isinstance(about.default, int):
        kind, example = "a whole number", f"[{about.default}, {2 * about.default}]"
    else:
        return
    told = ", ".join(f"{name} = {excerpt(value)}" for name, value in entry.items())
    msg = (
        f"{shown} = {{ {told} }}: {kind} has no range and is not sampled: give a list of "
        f'its values, such as {example}, with design = "grid" or "one-at-a-time"'
    )
    raise ConfigError(msg)


def _refuse_repeated(shown: str, values: Sequence[tuple[Any, ...]], units: Sequence[str]) -> None:
    """Refuse a value that is named twice: each would be a case, and count twice in every mean."""
    seen: dict[Hashable, tuple[Any, ...]] = {}
    for together in values:
        meant = tuple(_meant(value, unit) for value, unit in zip(together, units, strict=True))
        if meant in seen:
            first, second = (_written(one) for one in (seen[meant], together))
            what = f"{second} is there twice"
            if first != second:
                what = f"{first} and {second} are the same value"
            msg = f"{shown}: {what}: name it once"
            raise ConfigError(msg)
        seen[meant] = together


def _meant(value: object, unit: str) -> Hashable:
    """Return what is the same for values that mean the same; a wrong one stands for itself."""
    if isinstance(value, list):
        return tuple(_meant(item, unit) for item in value)
    try:
        # Adding 0 makes one zero of two.
        return f"{parse(value, unit) + 0.0:.{SAME_DIGITS}g}"
    except ConfigError:
        return repr(value)


def _written(together: Sequence[Any]) -> str:
    return ", ".join(excerpt(value) for value in together)
