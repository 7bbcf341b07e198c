"""What a sweep's cases are compared by: the quantities that it answers with."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.engine.quantities import Quantity
from fibermelt.study.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["LEADS", "Response", "responses_of"]

LEADS = (
    "severity_fibers",
    "severity_melt",
    "void_critical_moisture_mean",
    "lowest_mean_2",
    "lowest_mean_1",
)
"""What a sweep is about, as far as it has it: how far voids grow, else what makes them."""

SAME = 1e-6
"""Relative range below which a response is the same in all cases: solvers go to 1e-8 or so."""

SAME_STEPS = 10.0
"""The same in tolerances of the flow, if that is more: bead heights differ by up to 2 of them."""

ENOUGH, MOST = 3, 6
"""With fewer responses than this others are looked for, until there are so many."""


@dataclass(frozen=True, eq=False)
class Response:
    """A number that each case has.

    Parameters
    ----------
    name : str
        Its name.
    title : str
        What it is, in a few words.
    unit : str
        Unit of its values; empty for a pure number.
    values : (cases,) ndarray
        The number of each case [unit]; NaN where there is none.
    meaning : str
        What it is, in a sentence's part; empty where the title says it all.
    same : float
        Relative range below which its values are the same.
    error : (cases,) ndarray, optional
        Estimate of the numerical error of each [unit]: its limit of detection; NaN where none is
        stated.
    """

    name: str
    title: str
    unit: str
    values: Array
    meaning: str = ""
    same: float = SAME
    error: Array | None = None

    @property
    def limit(self) -> Array:
        """Return the limit of detection of each case [unit]: its stated error, 0 without one."""
        return np.zeros(len(self.values)) if self.error is None else np.nan_to_num(self.error)

    @property
    def undetected(self) -> NDArray[np.bool_]:
        """Return which cases have a number that is not told from zero."""
        return np.isfinite(self.values) & (self.limit > 0) & (np.abs(self.values) <= self.limit)

    @property
    def heading(self) -> str:
        """Return its name and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    @property
    def varies(self) -> bool:
        """Tell whether it differs between cases by more than solvers and errors leave open."""
        known = np.isfinite(self.values)
        there, limit = self.values[known], self.limit[known]
        if there.size < 2:
            return False
        low, high = int(np.argmin(there)), int(np.argmax(there))
        open_ = max(self.same * float(np.max(np.abs(there))), float(limit[low] + limit[high]))
        return bool(there[high] - there[low] > open_)


def responses_of(
    collected: xr.Dataset,
    dimensions: Sequence[str],
    varied: Sequence[str] = (),
    tolerance: float = 0.0,
) -> tuple[Response, ...]:
    """Return what the cases of a collected sweep are compared by.

    Those that are declared as responses, in the order of the parts; where it has few of them other
    numbers of a case follow, by name, that vary.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep.
    dimensions : sequence of str
        The dimensions of its cases.
    varied : sequence of str
        Keys of what varied: a number of that name only repeats it, and is no response.
    tolerance : float
        Of the flows [-], ``numerics.flow_tolerance``: what differs by it is the same.
    """
    same = max(SAME, SAME_STEPS * tolerance)
    found: list[Response] = []
    for one in QUANTITIES.values():
        if one.response:
            values = one.derive(collected) if one.derive else collected.get(one.name)
            if values is not None and set(values.dims) == set(dimensions):
                error = collected.get(one.error)
                found.append(_response(one, values, dimensions, same, error))
    if len([one for one in found if one.varies]) < ENOUGH:
        known = {key.rpartition(".")[2] for key in varied} | {one.name for one in found}
        room = MOST - len(found)
        found += _others(collected, dimensions, known, same)[: max(0, room)]
    return tuple(found)


def _others(
    collected: xr.Dataset, dimensions: Sequence[str], known: Collection[str], same: float
) -> list[Response]:
    """Return other numbers of a case that vary, by name; of what is not declared as it is told."""
    no_answers = {one.name for one in QUANTITIES.values() if one.response is False}
    no_answers |= {one.error for one in QUANTITIES.values()}
    found = []
    for name in sorted(map(str, collected.data_vars)):
        values = collected[name]
        is_number = values.dtype.kind == "f" and set(values.dims) == set(dimensions)
        if not is_number or name in known or name in no_answers:
            continue
        told = Quantity(name, "", str(values.attrs.get("units", "1")), "")
        known_as = QUANTITIES.get(name, told)
        one = _response(known_as, values, dimensions, same, collected.get(known_as.error))
        if one.varies:
            found.append(one)
    return found


def _response(
    quantity: Quantity,
    values: xr.DataArray,
    dimensions: Sequence[str],
    same: float,
    error: xr.DataArray | None,
) -> Response:
    """Return a quantity of the cases as a response, in the unit that it is shown in."""
    title = quantity.title or quantity.name.replace("_", " ").capitalize()
    numbers = quantity.factor * _flat(values, dimensions)
    limit = None
    if error is not None and set(error.dims) == set(dimensions):
        stated = QUANTITIES.get(quantity.error)
        relative = stated is not None and stated.relative
        limit = _flat(error, dimensions) * (np.abs(numbers) if relative else quantity.factor)
    return Response(
        quantity.name, title, quantity.shown_unit, numbers, quantity.meaning, same, limit
    )


def _flat(values: xr.DataArray, dimensions: Sequence[str]) -> Array:
    return np.asarray(values.transpose(*dimensions).to_numpy(), dtype=float).ravel()
