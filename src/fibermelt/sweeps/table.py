"""A collected sweep as a table: what varied, what became of the cases, and how they responded.

A collected sweep is what `fibermelt.sweeps.collect.collect_sweep` returns. Of a grid its cases
come in the order of its axes, the last one fastest; of any other design as they are.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.parameters import Declaration, declarations
from fibermelt.errors import ConfigError, StoreError
from fibermelt.study.config import Config
from fibermelt.sweeps.design import SAMPLED, Sweep, swept
from fibermelt.sweeps.responses import Response, responses_of
from fibermelt.units import parse

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["DIGITS", "Scale", "SweepTable", "Varied", "sweep_table", "written_in"]

TOLERANCE = "numerics.flow_tolerance"

DIGITS = 5
"""Significant digits of a value in a label: as many as anybody writes."""


@dataclass(frozen=True, eq=False)
class Varied:
    """What varied: one parameter, or some that varied together, told by the first of them.

    Parameters
    ----------
    keys : tuple of str
        Their keys.
    title : str
        What it is called.
    unit : str
        Unit of the values, the one that its default is written in; empty for pure numbers.
    values : (cases,) ndarray
        Its value in each case [unit]; the place among `labels` of what is no number.
    labels : tuple of str
        What its values are, if they are no numbers.
    """

    keys: tuple[str, ...]
    title: str
    unit: str
    values: Array
    labels: tuple[str, ...] = ()

    @property
    def heading(self) -> str:
        """Return its name and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    @property
    def levels(self) -> list[float]:
        """Return its different values in rising order."""
        return sorted(set(self.values.tolist()))

    def written(self, value: float) -> str:
        """Return one of its values with its unit."""
        if self.labels:
            return self.labels[int(value)]
        return f"{value:.{DIGITS}g} {self.unit}".rstrip().replace("-", "−")


@dataclass(frozen=True, eq=False)
class SweepTable:
    """The cases of a sweep.

    Parameters
    ----------
    title : str
        Name of the study.
    design : str
        As in `fibermelt.sweeps.design.Sweep`.
    axes : tuple of Varied
        What varied.
    shape : tuple of int
        Values along each axis of a grid, else the number of cases.
    groups : tuple of tuple of int
        Of a design one at a time: the cases of each axis, the study itself first; else empty.
    status, reason : tuple of str
        What became of each case (``"done"``, ``"failed"``, ``"pending"``), and why it failed.
    responses : tuple of Response
        What is looked at, as far as the cases have it.
    weighing : Varied, optional
        What a case is weighed by, beside its number.
    """

    title: str
    design: str
    axes: tuple[Varied, ...]
    shape: tuple[int, ...]
    groups: tuple[tuple[int, ...], ...]
    status: tuple[str, ...]
    reason: tuple[str, ...]
    responses: tuple[Response, ...]
    weighing: Varied | None = None

    @property
    def is_sampled(self) -> bool:
        """Tell whether its cases are samples of distributions."""
        return self.design in SAMPLED

    @property
    def varying(self) -> tuple[Response, ...]:
        """Return the responses that are not the same in all cases."""
        return tuple(one for one in self.responses if one.varies)

    @property
    def missing(self) -> str:
        """Return how many cases have no answer, and why in a word; empty if all have one."""
        told = []
        for status, word in (("failed", "failed"), ("pending", "not finished")):
            if count := self.status.count(status):
                told.append(f"{count} {word}")
        return f"of {len(self.status)} cases {', '.join(told)}" if told else ""

    def point(self, case: int) -> str:
        """Return what a case is, in words."""
        if self.groups and case == 0:
            return "the study itself"
        axes = [axis for axis, group in zip(self.axes, self.groups, strict=False) if case in group]
        told = axes or self.axes
        return ", ".join(f"{axis.title} {axis.written(axis.values[case])}" for axis in told)


def sweep_table(collected: xr.Dataset) -> SweepTable:
    """Return the table of a collected sweep.

    Parameters
    ----------
    collected : xarray.Dataset
        As `fibermelt.sweeps.collect.collect_sweep` returns it.

    Raises
    ------
    StoreError
        If it does not say what varied.
    """
    try:
        sweep = swept(json.loads(collected.attrs["sweep"]))
        dimensions = sweep.dimensions
        shape = tuple(int(collected.sizes[name]) for name in dimensions)
        status = _flat(collected, "status", dimensions)
        axes = _axes(collected, sweep, shape)
    except (ConfigError, KeyError, ValueError, AttributeError, TypeError) as error:
        msg = (
            f"the collected sweep does not say what varied ({_in_words(error)}): collect it "
            "from its results folder again"
        )
        raise StoreError(msg) from error
    return SweepTable(
        title=str(collected.attrs.get("title", "")).removeprefix("fibermelt sweep ") or "unnamed",
        design=sweep.design,
        axes=axes,
        shape=shape,
        groups=_groups(sweep) if sweep.design == "one-at-a-time" else (),
        status=tuple(map(str, status)),
        reason=tuple(map(str, _flat(collected, "reason", dimensions))),
        responses=responses_of(
            collected,
            dimensions,
            [key for axis in sweep.axes for key in axis.keys],
            _flow_tolerance(collected),
        ),
        weighing=next((axis for axis in axes if axis.keys == (sweep.weight,)), None),
    )


def _flow_tolerance(collected: xr.Dataset) -> float:
    """Return the tolerance of the flows [-], the largest if it varies; 0 if nothing tells it."""
    if TOLERANCE in collected:
        return float(collected[TOLERANCE].max())
    section, _, name = TOLERANCE.partition(".")
    written = tomllib.loads(str(collected.attrs.get("config", ""))).get(section, {})
    return float(written.get(name, 0.0))


def _in_words(error: Exception) -> str:
    """Return what is wrong, on one line."""
    return f"{type(error).__name__}: {error}".splitlines()[0]


def _flat(collected: xr.Dataset, name: str, dimensions: Sequence[str]) -> Any:
    """Return a variable over all cases, one by one."""
    return collected[name].transpose(*dimensions).to_numpy().ravel()


def _groups(sweep: Sweep) -> tuple[tuple[int, ...], ...]:
    """Return the cases of each axis of a design one at a time, the study itself first."""
    ends = list(accumulate((len(axis.values) for axis in sweep.axes), initial=1))
    return tuple((0, *range(*between)) for between in pairwise(ends))


def _axes(collected: xr.Dataset, sweep: Sweep, shape: tuple[int, ...]) -> tuple[Varied, ...]:
    dimensions, keys = sweep.dimensions, [axis.keys for axis in sweep.axes]
    known = {declaration.key: declaration for declaration in declarations(Config)}
    names = [one[0].partition(".")[2] for one in keys]
    found = []
    for place, together in enumerate(keys):
        values = collected[together[0]].to_numpy()
        if len(dimensions) > 1:
            over = [1] * len(dimensions)
            over[place] = len(values)
            values = np.broadcast_to(values.reshape(over), shape)
        flat = values.ravel()
        name, about = names[place], known[together[0]]
        # Two tables may have a key of the same name: then both are told with their tables.
        title = together[0] if names.count(name) > 1 else name
        if len(together) > 1:
            title += " with " + ", ".join(key.partition(".")[2] for key in together[1:])
        title = title.replace("_", " ").replace(".", " ")
        if flat.dtype.kind == "f":
            scale = written_in(about)
            values = (flat - scale.zero) / scale.size
            found.append(Varied(together, title, scale.unit, values))
        else:
            labels = tuple(dict.fromkeys(map(str, flat)))
            at = np.array([labels.index(str(value)) for value in flat], dtype=float)
            found.append(Varied(together, title, "", at, labels))
    return tuple(found)


@dataclass(frozen=True)
class Scale:
    """The unit that values of a parameter are told in: ``size`` and ``zero`` of it in SI."""

    unit: str
    size: float = 1.0
    zero: float = 0.0


def written_in(about: Declaration) -> Scale:
    """Return the unit that a parameter's default is written in.

    Parameters
    ----------
    about : Declaration
        The parameter.
    """
    if not about.unit:
        return Scale("")
    unit = about.written_unit
    # Degrees Celsius have a zero of their own.
    zero, one = (parse(f"{count} {unit}", about.unit) for count in (0, 1))
    return Scale({"deg": "°", "degC": "°C"}.get(unit, unit), one - zero, zero)
