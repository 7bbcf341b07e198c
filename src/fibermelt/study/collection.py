"""What a sweep keeps of each case: the numbers, not the fields.

Of the results of all stages of a case stays

- every variable whose dimensions are all among `COLLECTED_DIMENSIONS` (a number of the flow, an
  extreme's bounds and quantiles, a label), as it is;
- of a variable over the initial angles besides, in Pa or rad, its smallest and largest value and
  its mean over them, as ``<name>_min``, ``<name>_max`` and ``<name>_mean``. An angle of a fiber is
  that of a line, without head and tail: its mean is that of the lines, half the angle of
  ``sum exp(2 i angle)`` (Mardia and Jupp, Directional Statistics, 2000, section 9.1).

What lies over points, nodes or cells does not: 12 MB a case, that `fibermelt run` gives again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fibermelt.errors import StoreError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

__all__ = [
    "COLLECTED_DIMENSIONS",
    "COLLECTION",
    "Kept",
    "Reduced",
    "reduce_results",
    "stack",
]

COLLECTION = 1
"""Version of what is kept: raised whenever the same results give other numbers here."""

COLLECTED_DIMENSIONS = frozenset(("streamline", "location", "kind", "zone", "quantile", "side"))
"""Dimensions that are few: what has no others is kept."""

REDUCED_DIMENSION = "initial_angle"
"""The dimension over which extremes and means are taken."""

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
        others = set(dimensions) - COLLECTED_DIMENSIONS
        if not others:
            kept[name] = Kept(dimensions, variable.to_numpy(), units, long_name)
        elif others == {REDUCED_DIMENSION} and len(dimensions) > 1 and units in REDUCED_UNITS:
            axis = dimensions.index(REDUCED_DIMENSION)
            left = tuple(item for item in dimensions if item != REDUCED_DIMENSION)
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
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

    if units != "rad":
        return np.asarray(values.mean(axis))
    return np.asarray(np.angle(np.exp(2j * values).mean(axis)) / 2)


def stack(cases: Sequence[tuple[str, Reduced]]) -> list[xr.Dataset]:
    """Return what is kept of some cases as labelled data over ``case``.

    Parameters
    ----------
    cases : sequence of (str, Reduced)
        The key of each, and what is kept of it.

    Returns
    -------
    list of xarray.Dataset
        One for each set of dimensions and labels that occurs: mostly one. The variable ``key``
        tells the cases apart.

    Raises
    ------
    StoreError
        If a stage has a variable called ``case`` or ``key``.
    """
    groups: dict[Any, list[tuple[str, Reduced]]] = {}
    for key, reduced in cases:
        if taken := {"case", "key"} & set(reduced):
            msg = f"results: {min(taken)} is the name of what tells cases apart: rename it"
            raise StoreError(msg)
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


def _stacked(cases: Sequence[tuple[str, Reduced]]) -> xr.Dataset:
    import numpy as np  # noqa: PLC0415  lazy: see above
    import xarray as xr  # noqa: PLC0415

    variables: dict[str, Any] = {
        "key": (
            ("case",),
            np.array([key for key, _ in cases]),
            {"units": "1", "long_name": "key of the case's results"},
        )
    }
    for name, kept in cases[0][1].items():
        about = {"units": kept.units, "long_name": kept.long_name}
        if kept.is_label(name):
            variables[name] = (kept.dimensions, kept.values, about)
        else:
            values = np.stack([reduced[name].values for _, reduced in cases])
            variables[name] = (("case", *kept.dimensions), values, about)
    return xr.Dataset(variables)
