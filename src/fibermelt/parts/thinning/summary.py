"""What summary.json and the terminal say of what thinning does."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.engine.quantities import or_none
from fibermelt.parts.thinning.quantities import QUANTITIES
from fibermelt.voids.constants import ATMOSPHERE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["column", "summarize_thinning", "thinning_in_words"]

NAMES = {"confined-ellipse": "ellipse", "spheroid": "spheroid"}
"""What the models are called on the terminal."""


def summarize_thinning(results: xr.Dataset) -> dict[str, Any]:
    """Return what thinning does, in SI, pressures on fibers absolute.

    Parameters
    ----------
    results : xarray.Dataset
        With the variables of `fibermelt.parts.thinning.stages.effect_stage`.

    Returns
    -------
    dict
        Under ``"thinning"`` a list, one of each law: ``index``, ``consistency``, the flow's
        ``inlet_pressure`` and ``contact_point``; and by model ``period`` (times rate; None if it
        stalls), ``stall_angle``, ``peak`` (largest pressure in simple shear over viscosity and
        rate) with its ``peak_error``; and by cause, ``lowest``, the lowest pressure on a fiber
        from the exit to the end of the swell, mean over initial angles and streamlines that pass no
        sharp corner in any flow, ``deepest``, that of the worst of these streamlines, and
        ``bound``, that of any direction on any of them.
    """
    regular = results.isel(streamline=results["effect_regular"].to_numpy() == 1)
    laws = []
    for index in results["effect_index"].to_numpy():
        one = regular.sel(effect_index=index)
        numbers = ("consistency", "inlet_pressure", "contact_point")
        laws.append(
            {
                "index": float(index),
                **{name: float(one[f"effect_{name}"]) for name in numbers},
                **{
                    str(model): _of_model(one.sel(effect_model=model))
                    for model in results["effect_model"].to_numpy()
                },
            }
        )
    return {"thinning": laws}


def _of_model(one: xr.Dataset) -> dict[str, Any]:
    """Return the numbers of one model in one melt."""
    causes = {}
    for cause in one["effect_cause"].to_numpy():
        lowest, bound = (
            ATMOSPHERE + one[f"effect_{name}"].sel(effect_cause=cause).to_numpy()
            for name in ("lowest", "bound")
        )
        causes[str(cause)] = {
            "lowest": or_none(lowest.mean() if lowest.size else math.nan),
            "deepest": or_none(lowest.min() if lowest.size else math.nan),
            "bound": or_none(bound.min() if bound.size else math.nan),
        }
    names = ("period", "stall_angle", "peak", "peak_error")
    return {**{name: or_none(one[f"effect_{name}"]) for name in names}, **causes}


def column(name: str, rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a number of each row in the unit that it is shown in, to the digits of the largest.

    Parameters
    ----------
    name : str
        Its name in the rows; that of its quantity is ``effect_<name>``.
    rows : sequence of mapping
        As in the summary; a number may be None.
    """
    one = QUANTITIES[f"effect_{name}"]
    size = max((abs(row[name]) for row in rows if row[name] is not None), default=0.0)
    return ["none" if row[name] is None else one.written(row[name], size=size) for row in rows]


def thinning_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what thinning does as a table for a person.

    Parameters
    ----------
    summary : mapping
        The content of summary.json.
    """
    laws = summary["thinning"]
    rows = [("thinning", "index", [f"{law['index']:g}" for law in laws])]
    for name in ("inlet_pressure", "contact_point"):
        one = QUANTITIES[f"effect_{name}"]
        rows.append(("", f"{one.title.lower()} [{one.shown_unit}]", column(name, laws)))
    models = [model for model in NAMES if model in laws[0]]
    for model in models:
        name = NAMES[model]
        rows.append(
            ("", f"{name}: peak / (eta rate)", [f"{law[model]['peak']:.2f}" for law in laws])
        )
        for cause, words in (
            ("both", "lowest below nozzle [MPa]"),
            ("flow", "  the flow thins alone"),
            ("fiber", "  its own melt alone"),
        ):
            told = column("lowest", [law[model][cause] for law in laws])
            rows.append(("", f"{name}: {words}" if cause == "both" else words, told))
    return [
        f"{what:<16}{row:<36}" + "".join(f"{number:>8}" for number in numbers)
        for what, row, numbers in rows
    ]
