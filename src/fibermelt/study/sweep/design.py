"""A study that is swept: the table ``[sweep]``, and the cases that it stands for.

Keys of the table are keys of a study, in quotes; keys that are joined by commas vary together::

    [sweep]
    "fiber.aspect_ratio" = [2, 4, 6]
    "flow.gap" = { from = "2.5 mm", to = "4 mm", count = 7 }
    "flow.inlet_width, flow.inlet_speed" = [["10 mm", "30.48 mm/s"], ["15 mm", "20.32 mm/s"]]
    "melt.viscosity" = { mean = "817 Pa s", std = "80 Pa s" }
    design = "grid"

A range or a distribution is sampled where the design is a Latin hypercube, a Sobol sequence, or
Saltelli's scheme, that gives first and total Sobol indices.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, get_args

from fibermelt.errors import ConfigError
from fibermelt.study.config import Config
from fibermelt.study.files import canonical, digest
from fibermelt.study.loading import merged, resolve
from fibermelt.study.messages import unknown_key
from fibermelt.study.parameters import Declaration, Value, declarations, excerpt, flatten
from fibermelt.units import parse

if TYPE_CHECKING:
    from fibermelt.study.loading import Study

__all__ = ["MOST_CASES", "SAMPLED", "SETTINGS", "Axis", "Case", "Sweep", "read_sweep"]

Design = Literal["grid", "one-at-a-time", "latin-hypercube", "sobol", "saltelli"]
DESIGNS: tuple[str, ...] = get_args(Design)
SAMPLED = ("latin-hypercube", "sobol", "saltelli")
"""Designs whose cases are samples of distributions."""

MOST_CASES = 1_000_000
"""Cases of a sweep: beyond, a count was meant otherwise."""

SETTINGS = ("design", "samples", "seed")
"""Keys of the table that are no parameters."""
ENDS = frozenset(("from", "to", "count"))
DISTRIBUTIONS = {
    frozenset(("mean", "std")): "normal",
    frozenset(("median", "factor")): "lognormal",
    frozenset(("low", "high")): "uniform",
}
"""Which distribution a table of two numbers stands for."""


@dataclass(frozen=True)
class Axis:
    """What varies: one parameter, or some that vary together.

    Parameters
    ----------
    keys : tuple of str
        Their keys.
    values : tuple of tuple
        The values that it is given one by one, each as a person wrote it; empty for a range that
        a design samples.
    distribution : str
        ``"uniform"``, ``"normal"`` or ``"lognormal"`` of what is sampled, else empty.
    first, second : float
        Low and high, mean and standard deviation, or median and factor [SI].
    """

    keys: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...] = ()
    distribution: str = ""
    first: float = 0.0
    second: float = 0.0

    @property
    def name(self) -> str:
        """Return the key under which its values are told."""
        return self.keys[0]

    def at(self, share: float) -> float:
        """Return the value [SI] below which a share of its distribution lies, in (0, 1)."""
        from scipy.special import ndtri  # noqa: PLC0415  lazy: most sweeps are grids

        if self.distribution == "uniform":
            return self.first + share * (self.second - self.first)
        deviation = float(ndtri(share))
        if self.distribution == "normal":
            return self.first + deviation * self.second
        return self.first * math.exp(deviation * math.log(self.second))


@dataclass(frozen=True)
class Case:
    """One study of a sweep.

    Parameters
    ----------
    index : int
        Its place in the sweep, from 0.
    point : dict
        The parameters that vary, resolved, in SI.
    config : Config
        The whole study.
    """

    index: int
    point: Mapping[str, Value]
    config: Config

    @property
    def id(self) -> str:
        """Return a name that depends on the resolved study only."""
        return digest(canonical(flatten(self.config)))[:20]


@dataclass(frozen=True)
class Sweep:
    """A study and what of it varies.

    Parameters
    ----------
    tables : mapping
        The study as written, without its sweep.
    axes : tuple of Axis
        What varies.
    design : str
        ``"grid"``: every combination; ``"one-at-a-time"``: the study itself, then each value with
        all else as in the study; ``"latin-hypercube"`` and ``"sobol"``: samples; ``"saltelli"``:
        for each sample a block of cases, as many as there are axes and two (Saltelli et al.,
        Comput. Phys. Commun. 181, 2010, 259-270).
    samples : int
        Number of samples.
    seed : int
        Of the samples.
    is_cold : bool
        Whether no stage is to start from the result of a neighbouring case.
    """

    tables: Mapping[str, Any]
    axes: tuple[Axis, ...]
    design: Design = "grid"
    samples: int = 0
    seed: int = 0
    is_cold: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the number of values on each axis of a grid, else the number of cases."""
        counts = tuple(len(axis.values) for axis in self.axes)
        if self.design == "grid":
            return counts
        if self.design == "one-at-a-time":
            return (1 + sum(counts),)
        block = len(self.axes) + 2 if self.design == "saltelli" else 1
        return (self.samples * block,)

    @property
    def count(self) -> int:
        """Return the number of cases."""
        return math.prod(self.shape)

    def told(self) -> str:
        """Return what varies, in words: ``flow.bed_speed with flow.inlet_speed x flow.gap``."""
        over = [" with ".join(axis.keys) for axis in self.axes]
        return " x ".join(over) if self.design == "grid" else f"{', '.join(over)} ({self.design})"

    def settings(self) -> list[dict[str, Any]]:
        """Return what each case sets, by key, as written or in SI."""
        if self.design == "grid":
            chosen = product(*(axis.values for axis in self.axes))
            return [self._set(values) for values in chosen]
        if self.design == "one-at-a-time":
            single = [
                dict(zip(axis.keys, value, strict=True))
                for axis in self.axes
                for value in axis.values
            ]
            return [{}, *single]
        return [
            {axis.name: axis.at(float(share)) for axis, share in zip(self.axes, row, strict=True)}
            for row in self._samples()
        ]

    def cases(self) -> list[Case]:
        """Return every case, resolved and checked.

        Raises
        ------
        ConfigError
            If one is no valid study: its settings, and what is wrong.
        """
        return list(self.stream())

    def stream(self) -> Iterator[Case]:
        """Yield every case, one by one: a sweep of many need not be in memory at once.

        Raises
        ------
        ConfigError
            As `cases`.
        """
        for index, set_ in enumerate(self.settings()):
            yield self._case(index, set_)

    def _set(self, values: Sequence[tuple[Any, ...]]) -> dict[str, Any]:
        return {
            key: value
            for axis, together in zip(self.axes, values, strict=True)
            for key, value in zip(axis.keys, together, strict=True)
        }

    def _samples(self) -> Any:
        """Return points of the unit cube, (cases, axes)."""
        if self.design == "saltelli":
            from SALib.sample import sobol  # noqa: PLC0415  lazy: 0.6 s

            names = [axis.name for axis in self.axes]
            cube = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
            return sobol.sample(cube, self.samples, calc_second_order=False, seed=self.seed)
        from scipy.stats import qmc  # noqa: PLC0415  lazy: most sweeps are grids

        if self.design == "latin-hypercube":
            return qmc.LatinHypercube(d=len(self.axes), rng=self.seed).random(self.samples)
        return qmc.Sobol(d=len(self.axes), rng=self.seed).random(self.samples)

    def _case(self, index: int, set_: Mapping[str, Any]) -> Case:
        tables: dict[str, Any] = dict(self.tables)
        for key, value in set_.items():
            section, _, name = key.partition(".")
            tables = merged(tables, {section: {name: value}})
        try:
            config = resolve(tables)
        except ConfigError as error:
            what = ", ".join(f"{key} = {excerpt(value)}" for key, value in set_.items())
            msg = f"case {index + 1} of the sweep ({what}): {error}"
            raise ConfigError(msg) from None
        values = flatten(config)
        keys = [key for axis in self.axes for key in axis.keys]
        return Case(index, {key: values[key] for key in keys}, config)


def read_sweep(study: Study, *, cold: bool = False) -> Sweep:
    """Return the sweep that a study holds.

    With ``cold`` no stage is to start from the result of a neighbouring case.

    Raises
    ------
    ConfigError
        If it holds none, or one that cannot be: the key, the value and the way out.
    """
    table = study.sweep
    if table is None:
        msg = (
            f"{study.name}: has no table [sweep]: name in it what varies, such as "
            '"flow.gap" = ["2.5 mm", "3 mm"]; or use fibermelt run'
        )
        raise ConfigError(msg)
    known = {declaration.key: declaration for declaration in declarations(Config)}
    axes = tuple(_axis(name, entry, known) for name, entry in table.items() if name not in SETTINGS)
    if not axes:
        msg = 'sweep: nothing varies: name a parameter, such as "flow.gap" = ["2.5 mm", "3 mm"]'
        raise ConfigError(msg)
    seen = [key for axis in axes for key in axis.keys]
    if twice := sorted({key for key in seen if seen.count(key) > 1}):
        msg = f"sweep: {twice[0]} varies twice: name it once"
        raise ConfigError(msg)
    design = table.get("design", "grid")
    if design not in DESIGNS:
        choices = " or ".join(f'"{name}"' for name in DESIGNS)
        msg = f'sweep.design = "{excerpt(design)}": must be {choices}'
        raise ConfigError(msg)
    sweep = Sweep(
        tables=study.tables,
        axes=axes,
        design=design,
        samples=_whole(table, "samples", 0),
        seed=_whole(table, "seed", 0),
        is_cold=cold,
    )
    _fits(sweep)
    return sweep


def _whole(table: Mapping[str, Any], name: str, default: int) -> int:
    value = table.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        msg = f"sweep.{name} = {excerpt(value)}: must be a whole number, at least 0"
        raise ConfigError(msg)
    return value


def _fits(sweep: Sweep) -> None:
    """Refuse a design that does not go with what varies, and a sweep without end."""
    sampled = sweep.design in SAMPLED
    for axis in sweep.axes:
        if sampled and not axis.distribution:
            msg = (
                f'sweep."{", ".join(axis.keys)}": a list cannot be sampled: give a range '
                '{ low = ..., high = ... }, or take design = "grid"'
            )
            raise ConfigError(msg)
        if not sampled and not axis.values:
            msg = (
                f'sweep."{axis.name}": a distribution is sampled: take design = '
                '"latin-hypercube", "sobol" or "saltelli" with a number of samples'
            )
            raise ConfigError(msg)
    if sampled and sweep.samples < 1:
        msg = f'sweep.samples = {sweep.samples}: design = "{sweep.design}" needs at least one'
        raise ConfigError(msg)
    if sweep.design == "saltelli" and sweep.samples.bit_count() != 1:
        below = 1 << (sweep.samples.bit_length() - 1)
        msg = (
            f"sweep.samples = {sweep.samples}: a Saltelli design needs a power of two, such as "
            f"{below} or {2 * below}; each is a block of {len(sweep.axes) + 2} cases"
        )
        raise ConfigError(msg)
    if sweep.count > MOST_CASES:
        msg = f"sweep: {sweep.count} cases, at most {MOST_CASES}: take fewer values, or samples"
        raise ConfigError(msg)


def _axis(name: str, entry: object, known: Mapping[str, Declaration]) -> Axis:
    """Return what one key of the table stands for."""
    keys = tuple(key.strip() for key in name.split(","))
    for key in keys:
        if key not in known:
            msg = f"sweep.{unknown_key(key, known)}"
            raise ConfigError(msg)
        if key == "study.parts":
            msg = "sweep: study.parts cannot vary: every case has the same results"
            raise ConfigError(msg)
    shown = f'sweep."{name}"'
    if isinstance(entry, Mapping):
        if len(keys) > 1:
            msg = f"{shown}: keys that vary together need a list of their values"
            raise ConfigError(msg)
        return _range(shown, keys[0], entry, known[keys[0]])
    if not isinstance(entry, list) or not entry:
        msg = f"{shown} = {excerpt(entry)}: must be a list of values, or a range"
        raise ConfigError(msg)
    if len(keys) == 1:
        return Axis(keys, tuple((value,) for value in entry))
    for value in entry:
        if not isinstance(value, list) or len(value) != len(keys):
            msg = f"{shown}: {excerpt(value)}: must be a list of {len(keys)} values"
            raise ConfigError(msg)
    return Axis(keys, tuple(tuple(value) for value in entry))


def _range(shown: str, key: str, entry: Mapping[str, Any], declaration: Declaration) -> Axis:
    """Return the axis of ``{ from, to, count }`` or of a distribution."""

    def number(name: str, unit: str) -> float:
        try:
            return parse(entry[name], unit)
        except ConfigError as error:
            msg = f'{shown}: {name} = "{excerpt(entry[name])}" {error}'
            raise ConfigError(msg) from None

    unit = declaration.unit
    if set(entry) == ENDS:
        count = entry["count"]
        if isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= MOST_CASES:
            msg = f"{shown}: count = {excerpt(count)}: must be a whole number, 2 to {MOST_CASES}"
            raise ConfigError(msg)
        low, high = number("from", unit), number("to", unit)
        values = tuple((low + (high - low) * k / (count - 1),) for k in range(count))
        return Axis((key,), values, "uniform", low, high)
    distribution = DISTRIBUTIONS.get(frozenset(entry))
    if distribution is None:
        msg = (
            f"{shown}: has {', '.join(map(excerpt, entry))}: a range is {{ from, to, count }}, a "
            "distribution { low, high }, { mean, std } or { median, factor }"
        )
        raise ConfigError(msg)
    names = {"uniform": ("low", "high"), "normal": ("mean", "std")}.get(
        distribution, ("median", "factor")
    )
    second_unit = "" if names[1] == "factor" else unit
    return Axis((key,), (), distribution, number(names[0], unit), number(names[1], second_unit))
