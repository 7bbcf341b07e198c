"""What a number of the results is, declared once.

The attributes of the stored arrays follow from it, the words and units of the page and of the
terminal, what a sweep keeps of a case and answers with, and the documentation's list.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from fibermelt.errors import StoreError
from fibermelt.numerals import measured, number
from fibermelt.units import SHOWN

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Derive", "Quantity", "declared", "labelled", "or_none", "with_error"]

Derive = Callable[["xr.Dataset"], "xr.DataArray | None"]
"""From a collected sweep to a quantity of its cases, in SI; None where it lacks what is needed."""


@dataclass(frozen=True)
class Quantity:
    """A number, text or array of the results; ``<name>_error`` estimates the error of one.

    Parameters
    ----------
    name : str
        What results.nc calls it.
    dimensions : str
        Its dimensions, separated by spaces; a label has its own name.
    unit : str
        SI unit; 1 of a pure number and of a text.
    meaning : str
        What it is, in a sentence's part.
    title : str
        What tables and axes call it; a number of a case that has none is not told by itself.
    shown_in : str
        The unit that it is shown in, one of `fibermelt.units.SHOWN`; its SI unit by default.
    relative : bool
        Of an error: whether it is a share of what it is the error of.
    none : str
        What stands where there is none, for NaN.
    stored : bool
        Whether results.nc has it: not what a sweep derives, nor a dimension without labels.
    swept : {"", "kept", "reduced"}
        Of a label: what a sweep keeps of what lies over its dimension: nothing, all, or smallest,
        largest and mean values.
    kept_as : str
        Of a label of which each case has its own values: the name of the number that a sweep keeps.
    response : bool, optional
        Whether a sweep answers with it. None: only where it has few others. False: it tells of the
        computation.
    derive : callable, optional
        Finds the response in a collected sweep; by default it is what is collected by its name.
    """

    name: str
    dimensions: str
    unit: str
    meaning: str
    title: str = ""
    shown_in: str = ""
    relative: bool = False
    none: str = "–"
    stored: bool = True
    swept: Literal["", "kept", "reduced"] = ""
    kept_as: str = ""
    response: bool | None = None
    derive: Derive | None = None

    @property
    def shown_unit(self) -> str:
        """Return the unit that it is shown in; empty for a pure number."""
        return self.shown_in or ("" if self.unit == "1" else self.unit)

    @property
    def error(self) -> str:
        """Return the name of the quantity that estimates its error, if one does."""
        return f"{self.name}_error"

    @property
    def factor(self) -> float:
        """Return how many of the unit that it is shown in are one in SI."""
        return SHOWN[self.shown_in] if self.shown_in else 1.0

    def written(
        self, value: float, error: float = math.nan, *, size: float | None = None, digits: int = 4
    ) -> str:
        """Return a value ± its error in the unit that it is shown in, without the unit.

        Parameters
        ----------
        value, error : float
            In SI; an error that is not known, or zero, is not written.
        size : float, optional
            Magnitude in SI of what it is told of: the decimals of what has no error.
        digits : int
            Significant digits of what has no error.
        """
        if math.isnan(value):
            return self.none
        if isinstance(value, int):
            return number(value)
        size = None if size is None else self.factor * size
        return measured(self.factor * value, self.factor * error, size=size, digits=digits)

    def with_unit(
        self, value: float, error: float = math.nan, *, size: float | None = None, digits: int = 4
    ) -> str:
        """Return the same with its unit."""
        text = self.written(value, error, size=size, digits=digits)
        return text if math.isnan(value) else f"{text} {self.shown_unit}".rstrip()


def declared(*quantities: Quantity) -> dict[str, Quantity]:
    """Return quantities by name.

    Raises
    ------
    ValueError
        If one is declared twice.
    """
    found: dict[str, Quantity] = {}
    for one in quantities:
        if one.name in found:
            msg = f"{one.name} is declared twice: one would hide the other"
            raise ValueError(msg)
        found[one.name] = one
    return found


def labelled(arrays: Mapping[str, Any], known: Mapping[str, Quantity]) -> xr.Dataset:
    """Return arrays as a dataset with the declared dimensions, units and meanings.

    Parameters
    ----------
    arrays : mapping
        Arrays and numbers by name.
    known : mapping
        The quantities that they are.

    Raises
    ------
    StoreError
        If a name is not declared, or an array has not the declared number of dimensions.
    """
    import numpy as np  # noqa: PLC0415  lazy: a run that finds everything done needs neither
    import xarray as xr  # noqa: PLC0415

    variables = {}
    for name, values in arrays.items():
        if name not in known or not known[name].stored:
            msg = f"results: variable {name} is not declared: add it to the quantities of its part"
            raise StoreError(msg)
        quantity, array = known[name], np.asarray(values)
        dimensions = tuple(quantity.dimensions.split())
        if array.ndim != len(dimensions):
            msg = f"results: {name} has shape {array.shape}, declared are ({quantity.dimensions})"
            raise StoreError(msg)
        attributes = {"units": quantity.unit, "long_name": quantity.meaning}
        variables[name] = (dimensions, array, attributes)
    return xr.Dataset(variables)


def with_error(
    results: xr.Dataset, name: str, known: Mapping[str, Quantity]
) -> tuple[float, float]:
    """Return a number of the results and its estimated error, both in SI.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.
    name : str
        Which number.
    known : mapping
        The quantities, that of the error among them; NaN is the error of what has none.
    """
    one, value = known[name], results[name].item()
    if one.error not in results:
        return value, math.nan
    estimate = float(results[one.error])
    return value, abs(value) * estimate if known[one.error].relative else estimate


def or_none(value: Any) -> float | None:
    """Return a number of the results, None for the NaN of what does not exist."""
    found = float(value)
    return None if math.isnan(found) else found
