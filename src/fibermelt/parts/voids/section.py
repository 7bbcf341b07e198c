"""Where the bead can void: vapor pressure, lowest pressures and profile, in tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.voids.answer import MOISTURE
from fibermelt.parts.voids.summary import worst_line
from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table, number, percent, sized
from fibermelt.units import MM, MPA, MS, NM, PERCENT, ZERO_CELSIUS

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["voids"]

MOST = 200.0
"""Length of the longest bar of a lever [%]: what leaves more is told by its number."""

WHOSE = {
    "melt": "the melt itself, without fibers",
    "fibers": "worst of the initial angles",
    "bounds": "any direction of a fiber",
    "felt": "the same, with the most that is felt near sharp corners",
    "spheroid": "any direction of an unbounded spheroid",
    "oriented tips": "tips of spheroids, mean over their orientation",
}
"""Whose lowest pressure, in words; what is not here is a share of isotropic fibers."""


@section("risk", "Where it can void", place=80, needs="voids")
def voids(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return where the bead can void: vapor pressure, lowest pressures, profile, assumptions."""
    found = summary["voids"]
    size = _size(found["by_basis"].values(), "lowest_pressure", "margin")
    return {
        "found": found,
        "celsius": f"{found['temperature'] - ZERO_CELSIUS:.0f}",
        "MPA": MPA,
        "nucleation": _nucleation(found, float(results["void_threshold"])),
        "by_basis": _by_basis(found, size),
        "with_singular": _mpa(found["including_singular"]["lowest_pressure"], size),
        "profile": _profile(found) if found["profile"] else None,
        "lines": _lines(found),
        "levers": _levers(found),
        "doubts": _doubts(found),
    }


def _levers(found: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the levers, the one first that changes most, each with bars of what it leaves [%]."""
    boils = found["rest"]["boils"]
    told = []
    for one in found.get("levers", ()):
        shares = {
            "fibers": one["fibers_ratio"],
            "melt": one["melt_ratio"],
            "dry": one["dry_ratio"],
        }
        strength = shares["dry" if boils and one["key"] != MOISTURE else "fibers"]
        bars = {
            name: {"share": number(PERCENT * share, 3), "width": min(PERCENT * share, MOST) / MOST}
            for name, share in shares.items()
            if share is not None
        }
        content = number(_of(PERCENT, one["void_fraction"]), 2)
        told.append(
            {**one, "bars": bars, "content": content, "strength": abs(1.0 - (strength or 1.0))}
        )
    return sorted(told, key=lambda one: -float(one["strength"]))


def _doubts(found: Mapping[str, Any]) -> Table | None:
    """Return by which factors the severity may be off, the largest first."""
    columns = (
        Column("Source of doubt", is_text=True),
        Column("Factor"),
        Column("How it is known", is_text=True),
    )
    rows = [
        (one["source"], number(one["factor"], 3), one["basis"])
        for one in found.get("uncertainty", ())
    ]
    return Table("By which factors what fibers add may be off", columns, rows) if rows else None


def _nucleation(found: Mapping[str, Any], threshold: float) -> str:
    """Return what a bubble without any gas to start from would take.

    ``threshold`` is log10 of the rate that counts as its onset, as ``log10_rate`` is.
    """
    worst = worst_line(found)
    if worst is None or not worst["critical_radius"]:
        return ""
    told = f"A new bubble there would have to reach {number(NM * worst['critical_radius'], 2)} nm."
    rate, wetting = worst["log10_rate"], worst["required_wetting"]
    starts = rate is not None and rate >= threshold
    if rate is not None:
        told += (
            " The classical rate of nucleation in the melt itself, in 1/(m³ s), has the decimal "
            f"logarithm {number(rate, 3)}; counted as onset is {number(threshold, 3)}: "
            f"{'bubbles start' if starts else 'none starts'}."
        )
    if wetting is not None and not starts:
        told += (
            " It starts only on a surface that leaves no more than "
            f"{number(PERCENT * wetting, 2)} % of the barrier"
        )
        angle = worst["required_angle"]
        # Stored as Young's angle, through the melt: a surface that the melt does not wet.
        told += (
            "." if angle is None else f": a contact angle of {math.degrees(angle):.0f}° or more."
        )
    return told


def _mpa(value: float | None, size: float) -> str:
    """Return a pressure [MPa] with the digits that a size [Pa] asks for, four of the largest."""
    return sized(_of(MPA, value), MPA * size, 4)


def _size(rows: Iterable[Mapping[str, Any]], *names: str) -> float:
    """Return the largest magnitude in columns of a table, by which their numbers are told."""
    return max(
        (abs(row[name]) for row in rows for name in names if row[name] is not None), default=0.0
    )


def _moisture(value: float | None) -> str:
    """Return a critical moisture [%]; where none suffices, there is none to tell."""
    return "none" if value is None else number(PERCENT * value, 2)


def _whose(basis: str) -> str:
    share = basis.removeprefix("isotropic ")
    return WHOSE.get(basis, f"{share} of randomly entering fibers see less")


def _by_basis(found: Mapping[str, Any], size: float) -> Table:
    columns = (
        Column("Whose pressure", is_text=True),
        Column("Lowest", "MPa"),
        Column("Margin to vapor", "MPa"),
        Column("Critical moisture", "%"),
        Column("its mean by flux", "%"),
        Column("Share of the melt below vapor", "%"),
    )
    rows = [
        (
            _whose(basis),
            _mpa(one["lowest_pressure"], size),
            _mpa(one["margin"], size),
            _moisture(one["critical_moisture"]),
            _moisture(one["mean_critical_moisture"]),
            percent(one["share_below"], 0),
        )
        for basis, one in found["by_basis"].items()
    ]
    where = "in the bead" if found["profile"] else "on the paths"
    return Table(f"Lowest local pressure {where}", columns, rows)


def _profile(found: Mapping[str, Any]) -> Table:
    columns = (
        Column("Height in the bead", "mm"),
        Column("Fibers of the initial angles, mean", "MPa"),
        Column("Any direction, mean", "MPa"),
        Column("Any direction, lowest", "MPa"),
        Column("Time below vapor", "ms"),
        Column("Critical moisture", "%"),
        Column("Any direction, mean, with those past sharp corners", "MPa"),
        Column("Growth exponent of the melt"),
        Column("what fibers add"),
    )
    layers = found["profile"]
    height, time = (_size(layers, name) for name in ("height", "time_below"))
    size = _size(layers, "fiber_pressure", "mean_pressure", "lowest_pressure")
    rows = [
        (
            sized(MM * layer["height"], MM * height),
            _mpa(layer["fiber_pressure"], size),
            _mpa(layer["mean_pressure"], size),
            _mpa(layer["lowest_pressure"], size),
            sized(_of(MS, layer["time_below"]), MS * time),
            "–" if layer["lowest_pressure"] is None else _moisture(layer["critical_moisture"]),
            _mpa(layer["including_singular"]["mean_pressure"], size),
            number(layer["severity"]["melt"], 3),
            number(layer["severity"]["fibers"], 3),
        )
        for layer in reversed(layers)
    ]
    caption = "From the free surface down to the bed, means by flux"
    return Table(caption, columns, rows, scrolls=True)


def _lines(found: Mapping[str, Any]) -> Table:
    lines = found["streamlines"]
    heights = ("height",) if found["profile"] else ()
    word = "streamline" if found["profile"] else "path"
    columns = (
        Column(word.capitalize(), is_text=True),
        *(Column(f"{name.capitalize()} in the bead", "mm") for name in heights),
        Column("Lowest", "MPa"),
        Column("at x", "mm"),
        Column("at y", "mm"),
        Column("Time below vapor", "ms"),
        Column("Critical radius", "nm"),
        Column("log10 of the rate", "1/(m³ s)"),
        Column("Barrier left at onset", "%"),
        Column("Critical moisture", "%"),
    )
    place, time = _size(lines, *heights, "x", "y"), _size(lines, "time_below")
    size = _size(lines, "lowest_pressure")
    rows = [
        (
            f"{line['index']}{'*' if line['near_singularity'] else ''}",
            *(sized(MM * line[name], MM * place) for name in heights),
            _mpa(line["lowest_pressure"], size),
            sized(MM * line["x"], MM * place),
            sized(MM * line["y"], MM * place),
            sized(_of(MS, line["time_below"]), MS * time),
            number(_of(NM, line["critical_radius"]), 3),
            number(line["log10_rate"], 3),
            number(_of(PERCENT, line["required_wetting"]), 2),
            _moisture(line["critical_moisture"]),
        )
        for line in lines
    ]
    caption = f"Each {word}, any direction of a fiber; * passes close to a sharp corner"
    return Table(caption, columns, rows)


def _of(factor: float, value: float | None) -> float | None:
    return None if value is None else factor * value
