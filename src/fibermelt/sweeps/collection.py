"""What a sweep keeps of each case: the numbers, not the fields.

Of the results of all stages of a case stays

- every variable whose dimensions are all few, as their labels are declared to be (a number of the
  flow, an extreme's bounds and quantiles, a label), as it is;
- of a variable over the initial angles besides, in Pa or rad, its smallest and largest value and
  its mean over them, as ``<name>_min``, ``<name>_max`` and ``<name>_mean``. An angle of a fiber is
  that of a line, without head and tail: its mean is that of the lines, half the angle of
  ``sum exp(2 i angle)`` (Mardia and Jupp, Directional Statistics, 2000, section 9.1).

What lies over points, nodes or cells does not: 12 MB a case, that `fibermelt run` gives again.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.study.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

__all__ = [
    "COLLECTION",
    "Batch",
    "Kept",
    "Reduced",
    "reduce_results",
    "stack",
]

COLLECTION = 2
"""Version of what is kept: raised whenever the same results give other numbers here."""

KEPT, REDUCED = (
    frozenset(one.name for one in QUANTITIES.values() if one.swept == kind)
    for kind in ("kept", "reduced")
)
"""Dimensions, by their labels: what has no others is kept; those that extremes and means go over.
"""

OWN_LABELS = {one.name: one.kept_as for one in QUANTITIES.values() if one.kept_as}
"""Labels that every case has of its own, and the names under which they are kept as numbers.

As labels they would be united over all cases, which the last digits of the bead's height tell apart
already: of n cases every array over layers would have n times its size, most of it NaN."""

REDUCED_UNITS = ("Pa", "rad")
"""Units of what has a meaning as an extreme or a mean over the fibers."""


@dataclass(frozen=True)
class Kept:
    """One variable that is kept of a case.

    Parameters
    ----------
    dimensions : tuple of str
        Its dimensions.
    values : ndarray
        Its values.
    units, long_name : str
        What it is.
    """

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str

    def is_label(self, name: str) -> bool:
        """Tell whether it labels the dimension of its own name."""
        return self.dimensions == (name,)


Reduced = Mapping[str, Kept]
"""What is kept of a case, by name."""


def reduce_results(dataset: xr.Dataset) -> dict[str, Kept]:
    """Return what is kept of the results of a stage.

    Parameters
    ----------
    dataset : xarray.Dataset
        Its results, every variable with ``units`` and ``long_name``.
    """
    kept: dict[str, Kept] = {}
    for key, variable in dataset.variables.items():
        name, dimensions = str(key), tuple(map(str, variable.dims))
        units = str(variable.attrs.get("units", ""))
        long_name = str(variable.attrs.get("long_name", ""))
        others = set(dimensions) - KEPT
        if not others:
            own = OWN_LABELS.get(name, name)
            kept[own] = Kept(dimensions, _plain(variable.to_numpy()), units, long_name)
        elif len(others) == 1 < len(dimensions) and others <= REDUCED and units in REDUCED_UNITS:
            axis = dimensions.index(others.pop())
            left = dimensions[:axis] + dimensions[axis + 1 :]
            values = variable.to_numpy()
            found = {"min": values.min(axis), "max": values.max(axis)}
            found["mean"] = _mean(values, axis, units)
            words = {"min": "smallest", "max": "largest", "mean": "mean"}
            for short, array in found.items():
                told = f"{long_name}: {words[short]} of all initial angles"
                kept[f"{name}_{short}"] = Kept(left, array, units, told)
    return kept


def _mean(values: NDArray[np.float64], axis: int, units: str) -> NDArray[np.float64]:
    """Return the mean of numbers, or of the lines that have some angles [rad]."""
    if units != "rad":
        return np.asarray(values.mean(axis))
    return np.asarray(np.angle(np.exp(2j * values).mean(axis)) / 2)


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    """Return texts as an array of texts; netCDF gives them as an array of objects."""
    return values.astype(str) if values.dtype.kind == "O" else values


@dataclass(frozen=True)
class Batch:
    """What is kept of some cases with the same variables, dimensions and labels.

    Parameters
    ----------
    keys : tuple of str
        The key of each case.
    variables : dict
        What is kept, by name: labels as they are, all else over ``case`` first.
    """

    keys: tuple[str, ...]
    variables: Reduced

    def to_bytes(self) -> bytes:
        """Return it as an npz file: arrays of numbers and of texts, never of objects."""
        about = {
            name: [*kept.dimensions, kept.units, kept.long_name]
            for name, kept in self.variables.items()
        }
        arrays = {f"v_{name}": kept.values for name, kept in self.variables.items()}
        buffer = io.BytesIO()
        np.savez(
            buffer, allow_pickle=False, key=self.keys, about=np.array(json.dumps(about)), **arrays
        )
        return buffer.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> Batch:
        """Return what an npz file holds; an array of objects in it is refused."""
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            variables = {
                name: Kept(tuple(dimensions), file[f"v_{name}"], units, long_name)
                for name, (*dimensions, units, long_name) in json.loads(str(file["about"])).items()
            }
            return cls(tuple(map(str, file["key"])), variables)

    @staticmethod
    def keys_in(data: bytes) -> tuple[str, ...]:
        """Return the keys of the cases in an npz file, without reading the rest of it."""
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            return tuple(map(str, file["key"]))


def stack(cases: Sequence[tuple[str, Reduced]]) -> list[Batch]:
    """Return what is kept of some cases, together.

    Parameters
    ----------
    cases : sequence of (str, Reduced)
        The key of each, and what is kept of it.

    Returns
    -------
    list of Batch
        One for each set of dimensions and labels that occurs: mostly one.
    """
    groups: dict[Any, list[tuple[str, Reduced]]] = {}
    for key, reduced in cases:
        groups.setdefault(_layout(reduced), []).append((key, reduced))
    return [_stacked(group) for group in groups.values()]


def _layout(reduced: Reduced) -> Any:
    """Return what cases must have in common to lie in one dataset."""
    return tuple(
        (
            name,
            kept.dimensions,
            kept.values.shape,
            kept.values.dtype.kind,
            tuple(kept.values.tolist()) if kept.is_label(name) else None,
        )
        for name, kept in sorted(reduced.items())
    )


def _stacked(cases: Sequence[tuple[str, Reduced]]) -> Batch:
    variables: dict[str, Kept] = {}
    for name, kept in cases[0][1].items():
        if kept.is_label(name):
            variables[name] = kept
        else:
            values = np.stack([reduced[name].values for _, reduced in cases])
            variables[name] = replace(kept, dimensions=("case", *kept.dimensions), values=values)
    return Batch(tuple(key for key, _ in cases), variables)
