"""What a sweep's cases are compared by: a few numbers of each, in units that a person reads."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["Response", "responses_of"]

MM, MPA, PERCENT = 1e3, 1e-6, 100.0
"""Millimetres in a metre, megapascals in a pascal, hundredths in one."""

SAME = 1e-6
"""Relative range below which a response is the same in all cases: solvers go to 1e-8 or so."""

SAME_STEPS = 10.0
"""The same in tolerances of the flow, if that is more: bead heights differ by up to 2 of them."""

ENOUGH, MOST = 3, 6
"""With fewer responses than this others are looked for, until there are so many."""

NOT_RESPONSES = (
    *("newton_steps", "unknowns", "elements", "field_order", "cell_unknowns"),
    *("mass_imbalance", "kinematic_residual", "status", "reason"),
)
"""Numbers that tell of the computation, not of the bead or the fiber."""


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
        import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

        there = self.values[np.isfinite(self.values)]
        return there.size > 1 and bool(np.ptp(there) > self.same * np.max(np.abs(there)))


def _plain(name: str) -> Callable[[xr.Dataset], xr.DataArray | None]:
    """Return the function that looks a variable up."""
    return lambda collected: collected.get(name)


def _lowest_mean(location: int) -> Callable[[xr.Dataset], xr.DataArray | None]:
    """Return the function that finds the lowest mean extreme at a location.

    Of each streamline that passes no singular corner the lowest surface pressure at the location,
    mean over the initial angles; of those the lowest.
    """

    def lowest(collected: xr.Dataset) -> xr.DataArray | None:
        if not {"extreme_mean", "near_singularity"} <= set(map(str, collected)):
            return None
        if not {"location", "kind", "streamline"} <= set(map(str, collected["extreme_mean"].dims)):
            return None
        if location not in collected["location"].to_numpy():
            return None
        extreme = collected["extreme_mean"].sel(location=location, kind="min")
        return extreme.where(collected["near_singularity"] == 0).min("streamline")

    return lowest


def _moisture(collected: xr.Dataset) -> xr.DataArray | None:
    """Return the critical moisture; saturation where any moisture that can be is harmless."""
    if "void_critical_moisture" not in collected:
        return None
    worst = collected["void_critical_moisture"]
    needed = ("void_critical_moisture_mean", "void_saturation_moisture")
    if not all(name in collected for name in needed):
        return worst
    mean, most = (collected[name] for name in needed)
    return worst.where(~(worst.isnull() & mean.notnull()), most)


Find = Callable[["xr.Dataset"], "xr.DataArray | None"]

RESPONSES: tuple[tuple[str, str, str, float, Find], ...] = (
    ("contact_point", "Contact point", "mm", MM, _plain("contact_point")),
    ("inlet_pressure", "Inlet pressure", "MPa", MPA, _plain("inlet_pressure")),
    ("bead_height", "Bead height", "mm", MM, _plain("bead_height")),
    ("lowest_mean_0", "Lowest mean extreme", "MPa", MPA, _lowest_mean(0)),
    ("lowest_mean_1", "Lowest mean extreme, Loc. 1", "MPa", MPA, _lowest_mean(1)),
    ("lowest_mean_2", "Lowest mean extreme, Loc. 2", "MPa", MPA, _lowest_mean(2)),
    ("void_critical_moisture", "Critical moisture, worst fiber", "%", PERCENT, _moisture),
    (
        "void_critical_moisture_mean",
        "Critical moisture, median fiber",
        "%",
        PERCENT,
        _plain("void_critical_moisture_mean"),
    ),
    ("tip_pressure", "Tip pressure over μγ̇", "", 1.0, _plain("tip_pressure")),
)
"""Name, title, unit, factor from SI, and where it is found, in the order of the report."""


_EXTREME = (
    "lowest pressure on a fiber's surface, over the melt's, {where} the middle of the capillary: "
    "the mean over the initial angles, on the streamline where it is lowest"
)

MEANINGS = {
    "contact_point": "x of where the upstream surface meets the bed; the nozzle's axis is at 0",
    "inlet_pressure": "mean over the inlet, over the air's",
    "lowest_mean_0": _EXTREME.replace(", {where} the middle of the capillary", ""),
    "lowest_mean_1": _EXTREME.format(where="above"),
    "lowest_mean_2": _EXTREME.format(where="below"),
    "void_critical_moisture": (
        "moisture below which no bubble can grow on a fiber, whatever its direction, wherever it is"
    ),
    "void_critical_moisture_mean": (
        "the same for the median fiber of an isotropic start, the mean by flux over the streamlines"
    ),
    "tip_pressure": "largest surface pressure on a fiber in simple shear, over any direction",
}
"""What the responses are, where their titles do not say it."""


def responses_of(
    collected: xr.Dataset,
    dimensions: Sequence[str],
    varied: Sequence[str] = (),
    tolerance: float = 0.0,
) -> tuple[Response, ...]:
    """Return what the cases of a collected sweep are compared by.

    Where it has few of `RESPONSES` other numbers of a case follow, by name, that vary.

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
    for name, title, unit, factor, find in RESPONSES:
        values = find(collected)
        if values is not None and set(values.dims) == set(dimensions):
            numbers = factor * _flat(values, dimensions)
            found.append(Response(name, title, unit, numbers, MEANINGS.get(name, ""), same))
    if len([one for one in found if one.varies]) < ENOUGH:
        known = {key.rpartition(".")[2] for key in varied} | {one.name for one in found}
        room = MOST - len(found)
        found += _others(collected, dimensions, known, same)[: max(0, room)]
    return tuple(found)


def _others(
    collected: xr.Dataset, dimensions: Sequence[str], known: Collection[str], same: float
) -> list[Response]:
    """Return other numbers of a case that vary, by name."""
    found = []
    for name in sorted(map(str, collected.data_vars)):
        values = collected[name]
        is_number = values.dtype.kind == "f" and set(values.dims) == set(dimensions)
        if not is_number or name in known or name in NOT_RESPONSES or name.endswith("_error"):
            continue
        unit = str(values.attrs.get("units", "1"))
        title = name.replace("_", " ").capitalize()
        numbers = _flat(values, dimensions)
        one = Response(name, title, "" if unit == "1" else unit, numbers, same=same)
        if one.varies:
            found.append(one)
    return found


def _flat(values: xr.DataArray, dimensions: Sequence[str]) -> Array:
    import numpy as np  # noqa: PLC0415  lazy: see above

    return np.asarray(values.transpose(*dimensions).to_numpy(), dtype=float).ravel()
