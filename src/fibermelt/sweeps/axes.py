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

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NoReturn

from fibermelt.engine.parameters import Declaration, excerpt
from fibermelt.errors import ConfigError
from fibermelt.sweeps.distributions import (
    Distribution,
    Histogram,
    Lognormal,
    Normal,
    Sampled,
    Truncated,
    Uniform,
    Weibull,
)
from fibermelt.sweeps.refusals import (
    refuse_range,
    refuse_repeated,
    refuse_unknown,
    refuse_unquoted,
)
from fibermelt.units import parse, parse_difference

__all__ = ["DISTRIBUTIONS", "MOST_CASES", "Axis", "read_axis"]

MOST_CASES = 1_000_000
"""Cases of a sweep: beyond, a count was meant otherwise."""

LEAST_KEPT = 1e-6
"""Share of a distribution that is left between two values: of less, they are slips of the unit."""

MOST_FACTOR, LEAST_SHAPE, MOST_SHAPE = 1e3, 0.1, 1e3
"""Of a lognormal and a Weibull distribution: beyond, samples are further apart than numbers go."""

ENDS = frozenset(("from", "to", "count"))
BETWEEN = "between"

DISTRIBUTIONS = {
    frozenset(("low", "high")): "uniform",
    frozenset(("mean", "std")): "normal",
    frozenset(("median", "factor")): "lognormal",
    frozenset(("scale", "shape")): "Weibull",
    frozenset(("edges", "counts")): "measured",
}
"""Which distribution a table of two entries stands for."""

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
    distribution : Sampled, optional
        What a design samples [SI]; a range has one as well.
    """

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...] = ()
    distribution: Sampled | None = None

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
            refuse_unquoted(key, entry, known)
            refuse_unknown(key, known)
        if key == "study.parts":
            msg = "sweep: study.parts cannot vary: every case has the same results"
            raise ConfigError(msg)
    shown = f'sweep."{name}"'
    if isinstance(entry, Mapping):
        if len(keys) > 1:
            msg = f"{shown}: keys that vary together need a list of their values"
            raise ConfigError(msg)
        refuse_range(shown, entry, known[keys[0]])
        return _Table(shown, entry, known[keys[0]].unit).axis(keys[0])
    if not isinstance(entry, list) or not entry:
        msg = f"{shown} = {excerpt(entry)}: must be a list of values, or a range"
        raise ConfigError(msg)
    for value in entry:
        if len(keys) > 1 and (not isinstance(value, list) or len(value) != len(keys)):
            msg = f"{shown}: {excerpt(value)}: must be a list of {len(keys)} values"
            raise ConfigError(msg)
    values = tuple((value,) if len(keys) == 1 else tuple(value) for value in entry)
    refuse_repeated(shown, values, [known[key].unit for key in keys])
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
        reading: dict[str, Callable[[], Distribution]] = {
            "uniform": self._uniform,
            "normal": self._normal,
            "lognormal": self._lognormal,
            "Weibull": self._weibull,
            "measured": self._measured,
        }
        whole = reading[kind]()
        if BETWEEN not in self.entry:
            return Axis((key,), (), whole)
        if kind == "uniform":
            self._refuse(": has low and high already: leave between away, or narrow them")
        return Axis((key,), (), self._truncated(whole))

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
        return Axis((key,), values, Uniform(low, high))

    def _uniform(self) -> Distribution:
        low, high = self._number("low"), self._number("high")
        if not low < high:
            self._wrong("high", "must be above low")
        return Uniform(low, high)

    def _normal(self) -> Distribution:
        mean = self._number("mean")
        # The standard deviation is a difference: of 10 degC it is 10 K, not 283.
        std = self._parsed("std", lambda value: parse_difference(value, self.unit))
        if not std > 0:
            self._wrong("std", "must be above 0")
        return Normal(mean, std)

    def _lognormal(self) -> Distribution:
        median = self._positive("median", self.unit)
        factor = self._number("factor", "")
        if not 1 < factor <= MOST_FACTOR:
            self._wrong(
                "factor",
                f"must be above 1 and at most {MOST_FACTOR:g}: 68 % lie from the median over it "
                "to the median times it",
            )
        return Lognormal(median, factor)

    def _weibull(self) -> Distribution:
        scale, shape = self._positive("scale", self.unit), self._positive("shape", "")
        if not LEAST_SHAPE <= shape <= MOST_SHAPE:
            self._wrong("shape", f"must be from {LEAST_SHAPE:g} to {MOST_SHAPE:g}")
        return Weibull(scale, shape)

    def _measured(self) -> Distribution:
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
        return Histogram(edges, counts)

    def _truncated(self, whole: Distribution) -> Truncated:
        ends = self._numbers(BETWEEN, self.unit)
        if len(ends) != 2 or not ends[0] < ends[1]:
            self._wrong(BETWEEN, "must be two values, the lower one first")
        found = Truncated(whole, *ends)
        if not found.kept >= LEAST_KEPT:
            self._wrong(
                BETWEEN,
                f"leaves {found.kept:.2g} of the distribution, at least {LEAST_KEPT:g} is "
                "needed: widen it, or correct the distribution",
            )
        return found

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
