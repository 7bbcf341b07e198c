"""Numbers from outside as arrays, and values whose arrays stay as they are.

Whatever takes an array takes it through `real_array`: numpy turns dates, masks, texts and units
into numbers without a word.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from datetime import date, timedelta
from decimal import Decimal
from numbers import Number, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, FibermeltError

__all__ = ["Unchanging", "read_only", "real_array"]

Array = NDArray[np.float64]

SECOND = np.timedelta64(1, "s")

VAGUE = ("generic", "Y", "M")
"""Units of ``timedelta64`` that are no number of seconds: none at all, years and months."""


def real_array(
    name: str,
    value: ArrayLike,
    *,
    error: type[FibermeltError] = ConfigError,
    duration: bool = False,
) -> Array:
    """Return real numbers as an array of floats, or refuse what is none.

    Parameters
    ----------
    name : str
        What the message calls it.
    value : array_like
        Numbers in SI: arrays, lists, or what numpy takes for one (pandas, xarray). NaN is a number
        here: ranges are the caller's.
    error : type
        What is raised.
    duration : bool
        Whether it is a time [s]: durations (``timedelta64`` of any unit but months and years, and
        Python's) then become seconds, each the float nearest to it.

    Returns
    -------
    array
        Of the shape given; the same memory if it is an array of floats.

    Raises
    ------
    FibermeltError
        If there is a masked value, a date, a duration where none is meant, a complex number, a
        truth value, a unit, a text, or rows of different lengths.
    """
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    _refuse_hidden(name, value, error)
    try:
        raw = np.asarray(value)
    except (TypeError, ValueError) as problem:
        raise error(_no_numbers(name)) from problem
    kind = _kind(raw)
    if kind == "f":
        return raw.astype(np.float64, copy=False)
    if kind == "m" and duration and not _is_vague(raw):
        return _seconds(raw)
    faults = {
        "M": f"{name} holds dates: give the time since the start in seconds, e.g. time - time[0]",
        "m": f"{name} holds durations: give numbers in SI" + ", seconds" * duration,
        "c": f"{name} is complex: give real numbers in SI",
        "b": f"{name} holds true and false: give numbers in SI",
    }
    raise error(faults.get(kind, _no_numbers(name)))


def _no_numbers(name: str) -> str:
    return f"{name} is no array of numbers: give numbers in SI, rows of one length"


def _refuse_hidden(name: str, value: Any, error: type[FibermeltError]) -> None:
    """Refuse masked values and units, which numpy would drop, also inside lists."""
    if isinstance(value, (list, tuple)):
        for item in value:
            if not isinstance(item, (int, float)):
                _refuse_hidden(name, item, error)
    elif isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            where = np.argwhere(np.ma.getmaskarray(value))[0].tolist()
            place = f"[{', '.join(map(str, where))}]" if where else ""
            msg = f"{name}{place} is masked: leave out or fill in what is missing before"
            raise error(msg)
    elif hasattr(value, "magnitude") or hasattr(value, "to_value"):
        msg = f"{name} carries a unit: give numbers in SI, such as its magnitude in base units"
        raise error(msg)


def _kind(raw: NDArray[Any]) -> str:
    """Return what an array holds: f for real numbers, else m, M, c, b as numpy has it, or O."""
    kind: str = raw.dtype.kind
    if kind != "O":
        return "f" if kind in "iu" else kind
    items = raw.ravel().tolist()
    if any(isinstance(item, date) for item in items):
        return "M"
    if any(isinstance(item, (bool, np.bool_)) for item in items):
        return "b"
    if all(isinstance(item, (timedelta, np.timedelta64)) for item in items):
        return "m"
    if all(isinstance(item, (Real, Decimal)) for item in items):
        return "f"
    return "c" if all(isinstance(item, Number) for item in items) else "O"


def _is_vague(raw: NDArray[Any]) -> bool:
    """Return whether durations are no number of seconds: months, years, or without a unit."""
    return raw.dtype.kind == "m" and np.datetime_data(raw.dtype)[0] in VAGUE


def _seconds(raw: NDArray[Any]) -> Array:
    """Return durations in seconds."""
    if raw.dtype.kind == "m":
        return np.asarray(raw / SECOND)
    seconds = [span.total_seconds() for span in raw.ravel()]
    return np.array(seconds, dtype=np.float64).reshape(raw.shape)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return a view of an array through which nobody can write."""
    view = array.view()
    view.setflags(write=False)
    return view


@dataclass(frozen=True, eq=False)
class Unchanging:
    """Base of values that keep what was computed from them: their arrays are read-only.

    A copy, by `copy` or by way of a pickle, is made anew from the fields that made the value: its
    arrays are read-only, too, and nothing that was kept comes along.
    """

    def __post_init__(self) -> None:
        """Lock the arrays."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, field.name, read_only(value))

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what makes the value again."""
        return type(self), tuple(getattr(self, field.name) for field in fields(self) if field.init)
