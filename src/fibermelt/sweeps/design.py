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
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from fibermelt.engine.files import canonical, digest
from fibermelt.engine.parameters import Value, declarations, excerpt, flatten
from fibermelt.engine.tables import Tables
from fibermelt.errors import ConfigError
from fibermelt.parts.interaction.config import interacting
from fibermelt.study.config import Config
from fibermelt.study.loading import resolve
from fibermelt.sweeps.axes import MOST_CASES, Axis, read_axis
from fibermelt.sweeps.distributions import Uniform
from fibermelt.sweeps.settings import SAMPLED, SETTINGS, Design, read_settings

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Section

__all__ = ["SAMPLED", "SETTINGS", "Case", "Sweep", "read_sweep"]


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
            {
                axis.name: axis.distribution.at(float(share))
                for axis, share in zip(self.axes, row, strict=True)
                if axis.distribution is not None
            }
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
        try:
            config = Config.model_validate({**self._sections, **written})
        except ValidationError:
            try:
                config = resolve({**self.tables, **written})
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
                if isinstance(axis.distribution, Uniform):
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
    settings = read_settings(table, [axis.name for axis in axes])
    sweep = Sweep(
        tables=study.tables,
        axes=axes,
        design=settings.design,
        samples=settings.samples,
        seed=settings.seed,
        weight=settings.weight,
        is_cold=cold,
    )
    _fits(sweep)
    return sweep


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
