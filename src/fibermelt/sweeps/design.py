"""A study that is swept: the table ``[sweep]``, and the cases that it stands for.

Keys of the table are keys of a study, in quotes; keys that are joined by commas vary together::

    [sweep]
    "fiber.aspect_ratio" = [2, 4, 6]
    "flow.gap" = { from = "2.5 mm", to = "4 mm", count = 7 }
    "flow.inlet_width, flow.inlet_speed" = [["10 mm", "30.48 mm/s"], ["15 mm", "20.32 mm/s"]]
    "melt.viscosity" = { mean = "817 Pa s", std = "80 Pa s" }
    design = "grid"

A range or a distribution (`fibermelt.sweeps.axes`) is sampled where the design is a Latin
hypercube, a Sobol sequence, or Saltelli's scheme, that gives first and total Sobol indices.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, get_args

from pydantic import ValidationError

from fibermelt.engine.files import canonical, digest
from fibermelt.engine.overrides import SETTINGS
from fibermelt.engine.parameters import Value, declarations, excerpt, flatten
from fibermelt.engine.tables import Tables
from fibermelt.errors import ConfigError
from fibermelt.parts.interaction.config import interacting
from fibermelt.study.config import Config
from fibermelt.study.loading import renewed, resolve
from fibermelt.sweeps.axes import MOST_CASES, Axis, read_axis

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Section

__all__ = ["SAMPLED", "SETTINGS", "Case", "Sweep", "read_sweep", "swept"]

Design = Literal["grid", "one-at-a-time", "latin-hypercube", "sobol", "saltelli"]
SAMPLED = ("latin-hypercube", "sobol", "saltelli")
"""Designs whose cases are samples of distributions."""

UNUSED = {
    "samples": "draws no samples",
    "seed": "draws nothing at random",
    "weight": "has no population whose cases could be weighed",
}
"""Settings of samples, and why a design of another kind takes none of them."""


@dataclass(frozen=True)
class Case:
    """One study of a sweep.

    Parameters
    ----------
    index : int
        Its place in the sweep, from 0.
    point : dict
        The parameters that vary, resolved, in SI.
    config : Tables
        The whole study.
    """

    index: int
    point: Mapping[str, Value]
    config: Tables

    @property
    def id(self) -> str:
        """Return a name that depends on the resolved study only."""
        return digest(canonical(self.config.values()))[:20]


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
    weight : str
        Key of what varies by whose value the quantiles weigh a case as well; empty for none.
    is_cold : bool
        Whether no stage is to start from the result of a neighbouring case.
    """

    tables: Mapping[str, Any]
    axes: tuple[Axis, ...]
    design: Design = "grid"
    samples: int = 0
    seed: int = 0
    weight: str = ""
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
    def dimensions(self) -> tuple[str, ...]:
        """Return the dimensions of its collected cases: the axes of a grid, else ``case``."""
        return tuple(axis.name for axis in self.axes) if self.design == "grid" else ("case",)

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
        columns = [
            axis.distribution.at(shares).tolist()
            for axis, shares in zip(self.axes, self._samples().T, strict=True)
            if axis.distribution is not None
        ]
        names = [axis.name for axis in self.axes]
        return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]

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

    @cached_property
    def _sections(self) -> dict[str, Section]:
        """Return the sections of the study itself: where nothing varies, none is checked again."""
        config = resolve(self.tables)
        return {name: getattr(config, name) for name in type(config).model_fields}

    def _case(self, index: int, set_: Mapping[str, Any]) -> Case:
        varied: dict[str, dict[str, Any]] = {}
        for key, value in set_.items():
            section, _, name = key.partition(".")
            varied.setdefault(section, {})[name] = value
        written = {}
        for section, values in varied.items():
            below = self.tables.get(section, {})
            # What the study says of its own model is not true of another that is varied over.
            left = interacting(below, values) if section == "interaction" else below
            written[section] = {**left, **values}
        whole = renewed({**self.tables, **written}, varied)
        # What is lent may be another in each case: such tables are read anew, as they are written.
        lent = {key.partition(".")[0] for key in Config.lent(whole)}
        read = {name: table for name, table in self._sections.items() if name not in lent}
        anew = {name: whole[name] for name in {*written, *lent} if name in whole}
        try:
            config = Config.model_validate({**read, **anew})
        except ValidationError:
            try:
                config = resolve(whole)
            except ConfigError as error:
                what = ", ".join(f"{key} = {excerpt(value)}" for key, value in set_.items())
                msg = f"case {index + 1} of the sweep ({what}): {error}{self._way_out(str(error))}"
                raise ConfigError(msg) from None
        values = flatten(config)
        weight = values[self.weight] if self.weight else 1.0
        if not isinstance(weight, (int, float)) or not weight > 0:
            msg = (
                f'sweep.weight = "{self.weight}": is {excerpt(weight)} in case {index + 1}: a '
                "weight must be above 0"
            )
            raise ConfigError(msg)
        keys = [key for axis in self.axes for key in axis.keys]
        return Case(index, {key: values[key] for key in keys}, config)

    def _way_out(self, fault: str) -> str:
        """Return how a sample comes to lie within the bounds that it has left."""
        if self.design not in SAMPLED:
            return ""
        ways = []
        for axis in self.axes:
            if f"{axis.name} = " in fault:
                way = "is a distribution: cut it off with { ..., between = [low, high] }"
                if axis.distribution is not None and axis.distribution.kind == "uniform":
                    way = "is sampled from end to end: narrow it"
                ways.append(f'; sweep."{axis.name}" {way}')
        return "".join(ways)


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
            '"flow.gap" = ["2.5 mm", "3 mm"], or --over flow.gap="2.5 mm, 3 mm"; or use fibermelt '
            "run"
        )
        raise ConfigError(msg)
    return swept(table, study.tables, cold=cold)


def swept(
    table: Mapping[str, Any], tables: Mapping[str, Any] | None = None, *, cold: bool = False
) -> Sweep:
    """Return what a table ``[sweep]`` stands for.

    Parameters
    ----------
    table : mapping
        The table, as TOML has it.
    tables : mapping, optional
        The study that holds it, as written; without it there are no cases to make.
    cold : bool
        Whether no stage is to start from the result of a neighbouring case.

    Raises
    ------
    ConfigError
        As `read_sweep`.
    """
    known = {declaration.key: declaration for declaration in declarations(Config)}
    axes = tuple(
        read_axis(name, entry, known) for name, entry in table.items() if name not in SETTINGS
    )
    if not axes:
        msg = 'sweep: nothing varies: name a parameter, such as "flow.gap" = ["2.5 mm", "3 mm"]'
        raise ConfigError(msg)
    seen = [key for axis in axes for key in axis.keys]
    if twice := sorted({key for key in seen if seen.count(key) > 1}):
        msg = f"sweep: {twice[0]} varies twice: name it once"
        raise ConfigError(msg)
    design = table.get("design", "grid")
    if design not in get_args(Design):
        choices = " or ".join(f'"{name}"' for name in get_args(Design))
        msg = f'sweep.design = "{excerpt(design)}": must be {choices}'
        raise ConfigError(msg)
    samples, seed = _whole(table, "samples"), _whole(table, "seed")
    if design in SAMPLED:
        _refuse_samples(samples, design, len(axes))
    else:
        _refuse_unused(table, design)
    weight = _weight(table, [axis.name for axis in axes])
    sweep = Sweep(tables or {}, axes, design, samples, seed, weight, cold)
    _fits(sweep)
    return sweep


def _refuse_unused(table: Mapping[str, Any], design: str) -> None:
    """Refuse settings of samples where none are drawn: mostly the design was forgotten."""
    for name, why in UNUSED.items():
        if name not in table:
            continue
        value = table[name]
        shown = f'"{excerpt(value)}"' if isinstance(value, str) else excerpt(value)
        default = "" if "design" in table else ", which is meant where none is named,"
        msg = (
            f'sweep.{name} = {shown}: design = "{design}"{default} {why}: take design = '
            f'"latin-hypercube", "sobol" or "saltelli", or leave {name} away'
        )
        raise ConfigError(msg)


def _refuse_samples(samples: int, design: str, axes: int) -> None:
    """Refuse a number of samples that a design cannot have."""
    if samples < 1:
        msg = f'sweep.samples = {samples}: design = "{design}" needs at least one'
        raise ConfigError(msg)
    if design in {"saltelli", "sobol"} and samples.bit_count() != 1:
        below = 1 << (samples.bit_length() - 1)
        needs, rest = (
            ("a Saltelli design", f"each is a block of {axes + 2} cases")
            if design == "saltelli"
            else ("a Sobol sequence", 'a Latin hypercube, design = "latin-hypercube", takes any')
        )
        msg = (
            f"sweep.samples = {samples}: {needs} needs a power of two, such as {below} or "
            f"{2 * below}; {rest}"
        )
        raise ConfigError(msg)


def _whole(table: Mapping[str, Any], name: str) -> int:
    value = table.get(name, 0)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        msg = f"sweep.{name} = {excerpt(value)}: must be a whole number, at least 0"
        raise ConfigError(msg)
    return value


def _weight(table: Mapping[str, Any], varying: Sequence[str]) -> str:
    """Return the key by whose value cases are weighed."""
    if "weight" not in table:
        return ""
    weight = table["weight"]
    if weight not in varying:
        msg = (
            f'sweep.weight = "{excerpt(weight)}": must be one of the keys that are sampled, such '
            f"as {varying[0]}"
        )
        raise ConfigError(msg)
    return str(weight)


def _fits(sweep: Sweep) -> None:
    """Refuse a design that does not go with what varies, and a sweep without end."""
    sampled = sweep.design in SAMPLED
    for axis in sweep.axes:
        if sampled and axis.distribution is None:
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
    if sweep.count > MOST_CASES:
        msg = f"sweep: {sweep.count} cases, at most {MOST_CASES}: take fewer values, or samples"
        raise ConfigError(msg)
