"""What summary.json says of fibers in the bead, as a function of the results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import or_none
from fibermelt.engine.results import table_of
from fibermelt.numerals import rounded
from fibermelt.parts.bead.checks import LONGEST_FIBER
from fibermelt.parts.bead.config import Fiber
from fibermelt.parts.bead.quantities import QUANTITIES as FIBER
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.melt.melt import melt_of
from fibermelt.units import PERCENT

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["bead_in_words", "melt_met", "summarize_bead"]

PLACES = {0: "on the way", 1: "before the capillary", 2: "in the swell"}
"""The locations of extremes, in words."""

ENDS = {
    "outlet": "leave the flow",
    "wall": "end at a wall",
    "stagnation": "end where the melt stands",
    "time": "end as their time is over",
    "file": "as they were given",
}
"""Why paths end, in words."""

MOST_NOTES = 4
"""Faults of paths that the words tell: more are in the summary."""

MOST_NAMED = 12
"""Streamlines that the words list by their numbers: more do not fit on a line."""


def summarize_bead(results: xr.Dataset) -> dict[str, Any]:
    """Return what summary.json says of fibers in the bead, in SI.

    Parameters
    ----------
    results : xarray.Dataset
        The results, as in results.nc.

    Returns
    -------
    dict
        ``flow``, ``paths``, ``streamlines``, ``left_out``, ``cell``, ``extremes`` and
        ``orientation``. The ``error_estimate`` of the flow has one of each number that has any. A
        flow that was not solved here has paths and what its melt goes through, and no nozzle's
        numbers; ``field`` has the ``notes`` on how its file was read.
        Extremes
        are surface pressure less streamline pressure [Pa]; their statistics run over the
        initial angles, and ``x``, ``y`` [m] are their mean position. ``bounds`` hold for every
        orientation, ``quantiles`` (5, 50 and 95 %) for an isotropic start. Orientation is the
        angle to the streamline [rad], seen along z. What is told of all streamlines leaves out
        those that pass a sharp corner: ``left_out`` has their numbers, their ``share`` of the
        flux (of the paths where these stand for none), and ``felt_lowest``, by how much the
        pressure on their fibers falls below the melt's at most [Pa] (`fibermelt.fiber.corner`);
        None where there are none, or nobody knows where the corners are. A fiber in an unbounded
        melt has no ``domain_size``, no unknowns and no error. Of the melt there are the lowest
        viscosity and the highest rate of deformation on streamlines that pass no sharp corner,
        and ``outside_law``, the share of it at rates that its law was not measured at: of each
        streamline's time, mean by flux; None where nobody says what was measured.
    """
    told = [name for name, one in FLOW.items() if one.title and name in results]
    flow: dict[str, Any] = {name: results[name].item() for name in told} | melt_met(results)
    error = {name: results[f"{name}_error"].item() for name in told if f"{name}_error" in results}
    if error:
        flow["error_estimate"] = error
    notes = str(results["field_notes"].item()).split("\n") if "field_notes" in results else []
    return {
        "flow": flow,
        **({"field": {"notes": [note for note in notes if note]}} if notes else {}),
        "paths": _paths(results),
        "streamlines": _streamlines(results),
        "left_out": _singular(results),
        "cell": _cell(results),
        "extremes": _extremes(results),
        "orientation": _orientation(results),
    }


def melt_met(results: xr.Dataset) -> dict[str, float | None]:
    """Return what the melt goes through, as `summarize_bead` says."""
    regular = results.isel(streamline=results["near_singularity"].to_numpy() == 0)
    told = regular if regular.sizes["streamline"] else results
    known = melt_of(table_of(results, "melt", Melt)).rates
    return {
        "lowest_viscosity": float(told["viscosity"].min()),
        "highest_rate": float(told["shear_rate"].max()),
        "outside_law": None if known is None else _outside(results, *known),
    }


def _outside(results: xr.Dataset, slowest: float, fastest: float) -> float:
    """Return the share of the melt at rates beyond two [1/s], of time along, mean by flux."""
    time, rate = (
        results[name].transpose("streamline", "point").to_numpy() for name in ("time", "shear_rate")
    )
    beyond = (rate < slowest) | (rate > fastest)
    spent = np.diff(time, axis=-1) * 0.5 * (beyond[:, 1:].astype(float) + beyond[:, :-1])
    return float(np.mean(spent.sum(axis=-1) / (time[:, -1] - time[:, 0])))


def _paths(results: xr.Dataset) -> list[dict[str, Any]]:
    """Return how each path goes, and how far it can be trusted.

    The gradient's error is the median along the path over the median rate; the divergence what was
    taken out of the gradient, None where nothing was; the consistency what ``dx/dt = u`` or
    ``du/dt = L u`` misses; the fiber's scale its length over that on which the gradient changes by
    its largest.
    """
    time, rate = (
        results[name].transpose("streamline", "point").to_numpy() for name in ("time", "shear_rate")
    )
    error: list[float | None] = [None] * len(time)
    if "gradient_error" in results:
        median = np.median(results["gradient_error"].transpose("streamline", "point"), axis=-1)
        error = (median / np.median(rate, axis=-1)).tolist()
    trace: list[float | None] = [None] * len(time)
    if "path_divergence" in results:
        trace = results["path_divergence"].to_numpy().tolist()
    scale = _fiber_scale(results)
    return [
        {
            "index": int(results["streamline"][k]),
            "transit_time": float(time[k, -1] - time[k, 0]),
            "gradient_error": error[k],
            "divergence": trace[k],
            "consistency": float(results["path_consistency"][k]),
            "fiber_scale": scale[k],
            "end": str(results["path_end"][k].item()),
            "told": [note for note in str(results["path_notes"][k].item()).split("; ") if note],
        }
        for k in range(len(time))
    ]


def _fiber_scale(results: xr.Dataset) -> list[float]:
    """Return ``2 a max |dL/ds| / max |L|`` of each path [-]: how far a fiber outgrows its model."""
    names = [name for name in "xyz" if name in results]
    place = np.stack([results[name].transpose("streamline", "point") for name in names], axis=-1)
    L = results["gradient"].transpose("streamline", "point", "row", "column").to_numpy()
    size = np.linalg.norm(L, axis=(-2, -1)).max(axis=-1)
    way = np.maximum(np.linalg.norm(np.diff(place, axis=1), axis=-1), np.finfo(float).tiny)
    change = np.linalg.norm(np.diff(L, axis=1), axis=(-2, -1)) / way
    moving = np.isfinite(change) & (size[:, None] > 0.0)
    length = 2.0 * table_of(results, "fiber", Fiber).half_length
    steepest = np.where(moving, change, 0.0).max(axis=-1)
    return [float(value) for value in length * steepest / np.where(size > 0.0, size, 1.0)]


def _streamlines(results: xr.Dataset) -> list[dict[str, Any]]:
    drift = "stream_function_drift"
    return [
        {
            "index": int(results["streamline"][k]),
            "transit_time": float(results["time"][k, -1]),
            **({drift: float(results[drift][k])} if drift in results else {}),
            "near_singularity": bool(results["near_singularity"][k]),
        }
        for k in range(results.sizes["streamline"])
    ]


def _singular(results: xr.Dataset) -> dict[str, Any]:
    """Return which streamlines pass a singular corner, their share, and what is felt on them."""
    near = results["near_singularity"].to_numpy() > 0
    known = near.any() and "felt_lowest" in results
    felt = results["felt_lowest"].transpose("streamline", ...).to_numpy()[near] if known else None
    return {
        "streamlines": results["streamline"].to_numpy()[near].tolist(),
        "share": float(near.mean()),
        "felt_lowest": None if felt is None else float(felt.min()),
    }


def _cell(results: xr.Dataset) -> dict[str, Any]:
    known = {"thinning": _thinning(results)} if "thinning_rate" in results else {}
    return known | {
        "aspect_ratio": float(results["aspect_ratio"]),
        "domain_size": or_none(results["domain_size"]),
        "shape_factor": float(results["shape_factor"]),
        "stall_angle": or_none(results["stall_angle"]),
        "tip_pressure": float(results["tip_pressure"]),
        "error_estimate": {
            "shape_factor": float(results["shape_factor_error"]),
            "tip_pressure": float(results["tip_pressure_error"]),
        },
        "unknowns": int(results["cell_unknowns"]),
    }


def _thinning(results: xr.Dataset) -> dict[str, Any]:
    """Return how the fiber answers in its melt at the lowest and the highest rate of its table.

    At one of any rate both are the same. The shape factor is that of a turn in simple shear, from
    the spins along and across the flow.
    """
    rate = results["thinning_rate"].to_numpy()
    spin = results["thinning_spin"].transpose("thinning_rate", ...).to_numpy()
    factor = spin @ (-1.0) ** np.arange(spin.shape[1])
    low, high = (
        results[f"thinning_{side}"].transpose("thinning_rate", ...).to_numpy()
        for side in ("lowest", "highest")
    )
    largest = 0.5 * np.maximum(-low.min(axis=1), high.max(axis=1))
    ends = [0, -1]
    return {
        "rates": rate[ends].tolist(),
        "shape_factors": factor[ends].tolist(),
        "largest_pressures": largest[ends].tolist(),
        "error_estimate": {
            "spin": float(results["thinning_spin_error"]),
            "pressure": float(results["thinning_pressure_error"]),
        },
    }


def _extremes(results: xr.Dataset) -> list[dict[str, Any]]:
    dims = ("streamline", "location", "kind", "initial_angle")
    values, x, y = (
        results[name].transpose(*dims).to_numpy() for name in ("extreme", "extreme_x", "extreme_y")
    )
    error = results["extreme_error"].transpose(*dims).to_numpy()
    z = results["extreme_z"].transpose(*dims).to_numpy() if "extreme_z" in results else None
    bounds = results["extreme_bounds"].transpose(*dims[:3], "side").to_numpy()
    quantiles = results["extreme_quantiles"].transpose(*dims[:3], "quantile").to_numpy()
    labels = [results[name].to_numpy() for name in dims[:3]]
    return [
        {
            "streamline": int(labels[0][at[0]]),
            "location": int(labels[1][at[1]]),
            "kind": str(labels[2][at[2]]),
            "mean": float(values[at].mean()),
            "median": float(np.median(values[at])),
            "lowest": float(values[at].min()),
            "highest": float(values[at].max()),
            "x": float(x[at].mean()),
            "y": float(y[at].mean()),
            **({} if z is None else {"z": float(z[at].mean())}),
            "error": float(error[at].max()),
            "bounds": bounds[at].tolist(),
            "quantiles": quantiles[at].tolist(),
        }
        for at in np.ndindex(values.shape[:3])
    ]


def _orientation(results: xr.Dataset) -> list[dict[str, Any]]:
    if "zone_angle" not in results:
        return []
    return _at_zones(results)


def _at_zones(results: xr.Dataset) -> list[dict[str, Any]]:
    """Return the spread of the fibers' directions at each zone that their path reaches.

    A fiber has no head: its angle is known up to half turns. Each is taken within a quarter
    turn of the mean director ``arg(mean exp(2 i theta)) / 2``, where their mean makes sense.
    """
    angle = results["zone_angle"].transpose("streamline", "zone", "initial_angle").to_numpy()
    director = np.angle(np.exp(2j * angle).mean(axis=-1, keepdims=True)) / 2
    near = director + np.angle(np.exp(2j * (angle - director))) / 2
    return [
        {
            "streamline": int(results["streamline"][k]),
            "zone": int(results["zone"][z]),
            "mean": float(near[k, z].mean()),
            "lowest": float(near[k, z].min()),
            "highest": float(near[k, z].max()),
        }
        for k, z in np.ndindex(near.shape[:2])
        if np.isfinite(near[k, z]).all()
    ]


def bead_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what a summary says of fibers in the bead as a few lines for a person.

    Parameters
    ----------
    summary : mapping
        The content of summary.json.
    """
    flow, cell = summary["flow"], summary["cell"]
    stall = cell["stall_angle"]
    motion = "tumbles" if stall is None else f"stalls at {math.degrees(stall):.2f} deg"
    # Adding zero takes the sign off a circle's, which is zero but for rounding.
    factor = round(cell["shape_factor"], 4) + 0.0
    lines = [
        *(_bead(flow) if "bead_height" in flow else _given(summary["paths"])),
        *(f"as read         {note}" for note in summary.get("field", {"notes": ()})["notes"]),
        f"fiber           B = {factor:.4f}: in simple shear it {motion}",
        *_in_its_melt(cell),
    ]
    word = "streamline" if "bead_height" in flow else "path"
    flagged = [line["index"] for line in summary["streamlines"] if line["near_singularity"]]
    for location, place in PLACES.items():
        found = [
            extreme
            for extreme in summary["extremes"]
            if extreme["location"] == location
            and extreme["kind"] == "min"
            and extreme["streamline"] not in flagged
        ]
        if not found:
            continue
        worst = min(found, key=lambda extreme: float(extreme["lowest"]))
        depth = FIBER["extreme"].with_unit(-worst["lowest"], size=worst["lowest"], digits=3)
        lines.append(
            f"lowest {place:<20}  {depth} below the melt's own pressure, on "
            f"{word} {worst['streamline']}"
        )
    return (
        lines
        + _left_out(summary["left_out"], of=len(summary["streamlines"]), word=word)
        + _long(summary, word)
    )


def _bead(flow: Mapping[str, Any]) -> list[str]:
    """Return the lines on a bead that was solved for."""
    height = flow["bead_height"]
    from_axis = " from the nozzle's axis"
    lines = (
        ("bead_height", height, 4, ""),
        ("bead_width", height, 4, ""),
        ("inlet_pressure", flow["inlet_pressure"], 3, ""),
        ("contact_point", height, 4, from_axis),
        ("front", height, 3, from_axis),
    )
    return [
        f"{FLOW[name].title.lower():<16}"
        f"{FLOW[name].with_unit(flow[name], size=size, digits=digits)}{whence}"
        for name, size, digits, whence in lines
        if name in flow
    ]


def _given(paths: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines on the paths of a flow from elsewhere: where they end, what does not fit."""
    ends = [path["end"] for path in paths]
    told = ", ".join(f"{ends.count(end)} {ENDS[end]}" for end in ENDS if end in ends)
    slowest = max(path["transit_time"] for path in paths)
    lines = [f"paths           {len(paths)}: {told}; up to {rounded(slowest, slowest)} s"]
    notes = dict.fromkeys(note for path in paths for note in path["told"])
    return lines + [f"                {note}" for note in [*notes][:MOST_NOTES]]


def _in_its_melt(cell: Mapping[str, Any]) -> list[str]:
    """Return the line on a fiber in a melt that thins: the one before is of a Newtonian melt."""
    if "thinning" not in cell:
        return []
    known, tip = cell["thinning"], cell["tip_pressure"]
    told = [
        f"B = {factor:.4f} and {largest / tip:.3f} of the pressure"
        for factor, largest in zip(known["shape_factors"], known["largest_pressures"], strict=True)
    ]
    if len(set(told)) == 1:
        return [f"                as the melt thins {told[0]}"]
    slow, fast = known["rates"]
    return [
        f"                as the melt thins {told[0]} up to {slow:.2g} 1/s, {told[1]} "
        f"from {fast:.2g} 1/s"
    ]


def _long(summary: Mapping[str, Any], word: str) -> list[str]:
    """Return the line on fibers that are long beside what the gradient changes over."""
    flagged = [line["near_singularity"] for line in summary["streamlines"]]
    found = [
        path
        for path, near in zip(summary["paths"], flagged, strict=True)
        if not near and path["fiber_scale"] > LONGEST_FIBER
    ]
    if not found:
        return []
    worst = max(found, key=lambda path: float(path["fiber_scale"]))
    which = ", ".join(str(path["index"]) for path in found[:MOST_NAMED])
    which += ", ..." if found[MOST_NAMED:] else ""
    return [
        f"fiber's length  {worst['fiber_scale']:.2g} of that over which the gradient changes on "
        f"{word} {worst['index']}; above {LONGEST_FIBER:g} on {which}: what a fiber feels "
        "there is only roughly that of its middle"
    ]


def _left_out(left_out: Mapping[str, Any], of: int, word: str) -> list[str]:
    """Return the lines on those whose lowest pressure depends on the mesh."""
    flagged = left_out["streamlines"]
    if not flagged:
        return []
    if len(flagged) == of:
        lines = [f"lowest pressure not told: every {word} passes a sharp corner"]
    else:
        which = ", ".join(map(str, flagged[:MOST_NAMED]))
        which += ", ..." if flagged[MOST_NAMED:] else ""
        one = len(flagged) == 1
        share = f"{PERCENT * left_out['share']:.3g}"
        lines = [
            f"left out        {word}{'' if one else 's'} {which}, "
            f"{share} % of the {'flux' if word == 'streamline' else 'paths'}: "
            f"{'it passes' if one else 'they pass'} a sharp corner"
        ]
    if (felt := left_out["felt_lowest"]) is not None:
        depth = FIBER["felt_lowest"].with_unit(-felt, size=felt, digits=3)
        lines.append(f"                no fiber there comes more than {depth} below the melt's own")
    return lines
