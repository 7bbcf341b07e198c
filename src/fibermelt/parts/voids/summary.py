"""What summary.json and the words say of voids, as a function of the results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import or_none
from fibermelt.parts.voids.answer import LABELS, answered, by_layer
from fibermelt.parts.voids.profile import FELT, gas_share
from fibermelt.parts.voids.quantities import QUANTITIES
from fibermelt.report.kit.tables import number
from fibermelt.units import PERCENT, ZERO_CELSIUS
from fibermelt.voids.constants import ATMOSPHERE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["BESIDE", "summarize_voids", "voids_in_words", "worst_line"]

BASIS = "bounds"
"""Whose pressure is told where only one can be: a fiber of the study in its worst direction."""

OF_A_BEAD = "void_layer"
"""A variable that only voids of a flow that was solved here have: others have no bed."""

BESIDE = ("streamline", "near_singularity")
"""What is read beside the variables of voids, where the results have it."""

_ON_LINE = (
    "lowest_pressure",
    "time_below",
    "margin",
    "log10_rate",
    "critical_radius",
    "critical_time",
    "residence_margin",
    "required_wetting",
    "required_angle",
)
"""What is told of each streamline, by the names of its variables without ``void_``."""


def summarize_voids(results: xr.Dataset) -> dict[str, Any]:
    """Return what summary.json says of voids: ``{"voids": {...}}``, in SI, pressures absolute.

    Parameters
    ----------
    results : xarray.Dataset
        The results, as in results.nc, or the variables of voids alone with `BESIDE`.

    Returns
    -------
    dict
        The numbers on top hold for a fiber in its worst direction and without the streamlines that
        pass close by a singular corner; ``including_singular`` with them, by the most that fibers
        feel there (basis "felt") where the corners are known. ``by_basis`` has the
        same numbers of other pressures (see ``void_basis``), ``profile`` goes from the bed to the
        free surface; a flow that was not solved here has neither, and its paths no heights. None
        stands for what there is none of: a critical radius or a rate where no
        bubble can grow, a critical moisture where no moisture that the polymer can hold suffices.
        A critical moisture of 0 says that the melt is under tension: no drying helps.
        ``growth_exponent`` of a streamline is that on its fibers, over the initial angles;
        ``severity`` its mean by flux, of what fibers add and of the melt's own pressure, and
        ``rest`` tells whether the melt boils in the air at rest. ``void_fraction`` is the share of
        gas at the end of the swell, ``void_fraction_on_bed`` that after the time on the bed: what
        the same nuclei have without fibers is ``rest``, what fibers add to it ``tips``.
    """
    labels = [str(label) for label in results["void_basis"].to_numpy()]
    regular, everything = (_totals(results, selection) for selection in ("regular", "all"))
    voids = {
        "material": {
            "key": str(results["void_material"].item()),
            "name": str(results["void_material_name"].item()),
            "estimates": _lines(results["void_estimates"]),
            "missing": _lines(results["void_missing"]),
        },
        "moisture": float(results["void_moisture"]),
        "temperature": float(results["void_temperature"]),
        "threshold_rate": float(10.0 ** results["void_threshold"]),
        "saturation_moisture": float(results["void_saturation_moisture"]),
        "saturation_pressure": float(results["void_saturation_pressure"]),
        "vapor_pressure": float(results["void_vapor_pressure"]),
        "rest": _rest(results),
        "speed_exponent": or_none(results["void_speed_exponent"]),
        "basis": BASIS,
        **regular[BASIS],
        **{
            f"severity{kind}": {
                of: or_none(results[f"severity_{of}{kind}"]) for of in ("fibers", "melt")
            }
            for kind in ("", "_error")
        },
        **_content(results.sel(void_selection="regular"), "bead"),
        "including_singular": everything.get(FELT, everything[BASIS]),
        "by_basis": {label: regular[label] for label in labels},
        "streamlines": _streamlines(results, labels),
        "profile": _profile(results, labels) if OF_A_BEAD in results else [],
    }
    return {"voids": {**voids, "answer": answered(voids)}}


def _lines(text: xr.DataArray) -> list[str]:
    return [line for line in str(text.item()).split("\n") if line]


def _rest(results: xr.Dataset) -> dict[str, Any]:
    """Return whether the melt boils where it is at rest in the air, and from which moisture on."""
    return {
        "boils": bool(results["void_vapor_pressure"] > ATMOSPHERE),
        "boiling_moisture": or_none(results["void_boiling_moisture"]),
    }


def _content(results: xr.Dataset, of: str) -> dict[str, dict[str, float | None]]:
    """Return the void content of the bead or of a layer: in all, by tips, and without fibers."""
    found = {}
    for name, station in (("void_fraction", "swell"), ("void_fraction_on_bed", "bed")):
        whole, alone = (
            float(results[f"void_{of}_content{kind}"].sel(void_station=station))
            for kind in ("", "_rest")
        )
        parts = {"bead": whole, "tips": whole - alone, "rest": alone}
        found[name] = {part: or_none(value) for part, value in parts.items()}
    return found


def _totals(results: xr.Dataset, selection: str) -> dict[str, dict[str, float | None]]:
    """Return the numbers of the bead in all by basis."""
    here = results.sel(void_selection=selection)
    vapor = float(results["void_vapor_pressure"])
    found = {}
    for k, label in enumerate(results["void_basis"].to_numpy()):
        lowest = float(here["void_bead_lowest_pressure"][k])
        found[str(label)] = {
            "lowest_pressure": or_none(lowest),
            "margin": or_none(lowest - vapor),
            "critical_moisture": or_none(here["void_bead_moisture"][k]),
            "mean_critical_moisture": or_none(here["void_bead_mean_moisture"][k]),
            "share_below": or_none(here["void_bead_share_below"][k]),
            "growth_exponent": or_none(here["void_bead_exponent"][k]),
        }
    return found


def _streamlines(results: xr.Dataset, labels: Sequence[str]) -> list[dict[str, Any]]:
    told = results.sel(void_basis=BASIS)
    arrays = {
        name: told[f"void_{name}"].to_numpy()
        for name in (*_ON_LINE, "lowest_x", "lowest_y", "moisture_limit")
    }
    height = told["void_height"].to_numpy() if OF_A_BEAD in results else None
    z = told["void_lowest_z"].to_numpy() if "void_lowest_z" in told else None
    lowest, exponent = (
        results[f"void_{name}"].transpose("streamline", "void_basis").to_numpy()
        for name in ("lowest_pressure", "exponent")
    )
    fibers = results["void_fiber_exponent"].transpose("streamline", "initial_angle").to_numpy()
    gas = results["void_gas"].sel(void_station="swell").to_numpy()
    return [
        {
            "index": int(results["streamline"][k]),
            "near_singularity": bool(results["near_singularity"][k]),
            **({} if height is None else {"height": float(height[k])}),
            **{name: or_none(arrays[name][k]) for name in _ON_LINE},
            "critical_moisture": or_none(arrays["moisture_limit"][k]),
            "x": float(arrays["lowest_x"][k]),
            "y": float(arrays["lowest_y"][k]),
            **({} if z is None else {"z": float(z[k])}),
            "lowest_by_basis": dict(zip(labels, map(float, lowest[k]), strict=True)),
            "growth_exponent": {
                "mean": float(fibers[k].mean()),
                "median": float(np.median(fibers[k])),
                "highest": float(fibers[k].max()),
            },
            "exponent_by_basis": dict(zip(labels, map(float, exponent[k]), strict=True)),
            "void_fraction": or_none(gas_share(gas[k])),
        }
        for k in range(results.sizes["streamline"])
    ]


def _profile(results: xr.Dataset, labels: Sequence[str]) -> list[dict[str, Any]]:
    without, with_them = (
        _layers(results.sel(void_selection=selection), labels) for selection in ("regular", "all")
    )
    heights = map(float, results["void_layer"].to_numpy())
    return [
        {"height": height, **layer, "including_singular": other}
        for height, layer, other in zip(heights, without, with_them, strict=True)
    ]


def _layers(results: xr.Dataset, labels: Sequence[str]) -> list[dict[str, Any]]:
    """Return what is told of each layer, of one selection of streamlines."""
    told, vapor = results.sel(void_basis=BASIS), float(results["void_vapor_pressure"])
    names = ("lowest_pressure", "mean_pressure", "time_below", "moisture", "fiber_pressure")
    arrays = {name: told[f"void_layer_{name}"].to_numpy() for name in names}
    own = results.sel(void_basis="melt")["void_layer_exponent"].to_numpy()
    added = results["void_layer_fiber_exponent"].to_numpy() - own
    mean = results["void_layer_mean_pressure"].transpose("void_layer", "void_basis").to_numpy()
    return [
        {
            "lowest_pressure": or_none(arrays["lowest_pressure"][k]),
            "margin": or_none(arrays["lowest_pressure"][k] - vapor),
            "mean_pressure": or_none(arrays["mean_pressure"][k]),
            "time_below": or_none(arrays["time_below"][k]),
            "critical_moisture": or_none(arrays["moisture"][k]),
            "fiber_pressure": or_none(arrays["fiber_pressure"][k]),
            "mean_by_basis": dict(zip(labels, map(or_none, mean[k]), strict=True)),
            "severity": {"fibers": or_none(added[k]), "melt": or_none(own[k])},
            **_content(results.isel(void_layer=k), "layer"),
        }
        for k in range(results.sizes["void_layer"])
    ]


def voids_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return what a summary says of voids as a few lines for a person.

    Parameters
    ----------
    summary : mapping
        With the content of `summarize_voids`, and ``"held"`` in it where it is of a run with
        another melt.
    """
    voids = summary["voids"]
    celsius = voids["temperature"] - ZERO_CELSIUS
    lines = [
        f"vapor pressure  {_shown('vapor_pressure', voids['vapor_pressure'])} of "
        f"{PERCENT * voids['moisture']:.3g} % moisture in {voids['material']['name']} at "
        f"{celsius:.0f} degC"
    ]
    worst = worst_line(voids)
    if worst is None:
        word = "streamline" if voids["profile"] else "path"
        lines.append(f"lowest local    not told: every {word} passes a sharp corner")
    else:
        lines += _worst(voids, worst)
    if "against" in voids:
        ratios = ", ".join(number(one["ratio"], 2) for one in by_layer(voids))
        lines.append(
            f"by layer        of what fibers add on {voids['against']['name']}, from the bed up: "
            f"{ratios} times"
        )
    lines += [f"{LABELS[one['question']]:<15} {one['answer']}" for one in voids["answer"]]
    if "held" in voids:
        lines.append(f"held            {voids['held']}")
    lines += [f"not known       {line}" for line in voids["material"]["missing"]]
    if estimates := voids["material"]["estimates"]:
        lines.append(f"estimates       {', '.join(estimates)}")
    return lines


def worst_line(found: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the streamline of the lowest pressure; None if all pass a singular corner."""
    regular = [line for line in found["streamlines"] if not line["near_singularity"]]
    return min(regular, key=lambda line: float(line["lowest_pressure"]), default=None)


def _worst(voids: Mapping[str, Any], worst: Mapping[str, Any]) -> list[str]:
    """Return the lines on the lowest pressure, met on ``worst``, and on the profile."""
    highest = max((float(layer["height"]) for layer in voids["profile"]), default=0.0)

    def height(of: Mapping[str, Any]) -> str:
        return _shown("height", of["height"], size=highest)

    where = f"path {worst['index']}"
    if voids["profile"]:
        where = f"streamline {worst['index']}, which ends {height(worst)} up in the bead"
    lines = [
        f"lowest local    {_shown('lowest_pressure', worst['lowest_pressure'])} absolute on a "
        f"fiber in its worst direction, on {where}",
    ]
    if (in_space := voids["by_basis"].get("spheroid")) is not None:
        lowest = _shown("bead_lowest_pressure", in_space["lowest_pressure"])
        lines.append(f"                {lowest} on an unbounded spheroid in space")
    if nucleation := _nucleation(voids, worst):
        lines.append(f"nucleation      {nucleation}")
    layers = [layer for layer in voids["profile"] if layer["mean_pressure"] is not None]
    if not layers:
        return lines
    deepest = min(layers, key=lambda layer: float(layer["mean_pressure"]))
    first, low, last = (
        _shown("layer_mean_pressure", layer["mean_pressure"])
        for layer in (layers[0], deepest, layers[-1])
    )
    return [
        *lines,
        f"over the bead   {first} at the bed, {low} at {height(deepest)}, {last} at the free "
        "surface",
    ]


def _shown(name: str, value: float, size: float | None = None, digits: int = 3) -> str:
    """Return a number of voids with its unit and the digits that a size, its own, asks for."""
    return QUANTITIES[f"void_{name}"].with_unit(
        value, size=value if size is None else size, digits=digits
    )


def _nucleation(voids: Mapping[str, Any], worst: Mapping[str, Any]) -> str:
    """Return what a bubble without any gas to start from would take; nothing if that is unknown."""
    if not worst["critical_radius"]:
        return ""
    told = f"critical radius {_shown('critical_radius', worst['critical_radius'], digits=2)}"
    if (rate := worst["log10_rate"]) is None:
        return told
    threshold = math.log10(voids["threshold_rate"])
    told += f"; log10 of the rate {rate:.3g} in the melt itself, {threshold:.3g} counts as onset"
    if rate >= threshold:
        return f"{told}: bubbles start"
    if (wetting := worst["required_wetting"]) is None:
        return told
    return f"{told}: starts where a surface leaves {PERCENT * wetting:.2g} % of the barrier"
