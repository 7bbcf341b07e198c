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

__all__ = ["Response", "responses_of"]

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
    """

    name: str
    title: str
    unit: str
    values: Array
    meaning: str = ""
    same: float = SAME

    @property
    def heading(self) -> str:
        """Return its name and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    @property
    def varies(self) -> bool:
        """Tell whether it is not the same in all cases that have it, of at least two."""
        there = self.values[np.isfinite(self.values)]
        return there.size > 1 and bool(np.ptp(there) > self.same * np.max(np.abs(there)))


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
                found.append(_response(one, values, dimensions, same))
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
        one = _response(QUANTITIES.get(name, told), values, dimensions, same)
        if one.varies:
            found.append(one)
    return found


def _response(
    quantity: Quantity, values: xr.DataArray, dimensions: Sequence[str], same: float
) -> Response:
    """Return a quantity of the cases as a response, in the unit that it is shown in."""
    title = quantity.title or quantity.name.replace("_", " ").capitalize()
    numbers = quantity.factor * _flat(values, dimensions)
    return Response(quantity.name, title, quantity.shown_unit, numbers, quantity.meaning, same)


def _flat(values: xr.DataArray, dimensions: Sequence[str]) -> Array:
    return np.asarray(values.transpose(*dimensions).to_numpy(), dtype=float).ravel()
