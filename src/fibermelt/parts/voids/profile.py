"""Voids from the bed to the free surface, and of the bead in all.

Every streamline carries the same share of the flux, and the finished bead moves as a whole: in
the order of their heights the streamlines are bands of equal thickness.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

__all__ = [
    "FELT",
    "SELECTIONS",
    "STATIONS",
    "bead_totals",
    "gas_share",
    "layer_profile",
    "layer_weights",
]

STATIONS = ("swell", "bed")
"""The end of the swell (zone 3, or the end of a path without zones), and a time on the bed."""

SELECTIONS = ("regular", "all")
"""Without the streamlines that pass close by a singular corner, and with them."""

FELT = "felt"
"""Basis of any direction with the most that fibers feel near singular corners (`fiber.corner`)."""

MOST_LIKELY = "isotropic 50 %"
"""Basis of the median isotropic fiber."""

SEVERITIES = ("severity_melt", "severity_fibers")
"""What ranks a bead and needs no nucleus."""


def gas_share(gas: ArrayLike) -> Array:
    """Return the share of gas [-] from its volume over that of melt and fibers [-]."""
    volume = np.asarray(gas)
    return np.asarray(volume / (1.0 + volume))


def layer_weights(height: Array, regular: NDArray[np.bool_], layers: int) -> Array:
    """Return the share of each streamline in each layer's flux, (layers, streamline).

    Parameters
    ----------
    height : (streamline,) array
        Height of each in the finished bead [m].
    regular : (streamline,) array of bool
        Which of them count; layers with none of them have no shares.
    layers : int
        Number of layers of equal flux, from the bed.
    """
    count = len(height)
    below = np.argsort(np.argsort(height, kind="stable"))
    floor = np.arange(layers)[:, None] / layers
    low, high = below / count, (below + 1) / count
    overlap = np.minimum(high, floor + 1 / layers) - np.maximum(low, floor)
    # An overlap of rounding would put a streamline into the layer next to its own.
    overlap = np.where((overlap > 1e-9 / layers) & regular, overlap, 0.0)
    total = overlap.sum(axis=1, keepdims=True)
    shares: Array = np.divide(overlap, total, out=np.zeros_like(overlap), where=total > 0.0)
    return shares


def layer_profile(
    found: Mapping[str, Any], regular: NDArray[np.bool_], layers: int
) -> dict[str, Any]:
    """Return the profile over the bead's height, with and without singular streamlines.

    Parameters
    ----------
    found : mapping
        The variables of voids along the streamlines, as arrays by their names.
    regular : (streamline,) array of bool
        Which streamlines pass no singular corner.
    layers : int
        Number of layers.
    """
    height = found["void_height"]
    bead = _bead_height(height)
    lowest, limit = found["void_lowest_pressure"], found["void_moisture_limit"]
    on_fibers, grown = (
        found[f"void_fiber_{name}"].mean(axis=-1) for name in ("lowest", "exponent")
    )
    parts: dict[str, list[Array]] = {}
    for chosen in (regular, np.ones_like(regular)):
        weights = layer_weights(height, chosen, layers)
        empty = ~np.any(weights > 0.0, axis=1)
        part = {
            "void_layer_lowest_pressure": _least(lowest, weights),
            "void_layer_mean_pressure": _hide(weights @ lowest, empty),
            "void_layer_fiber_pressure": _hide(weights @ on_fibers, empty),
            "void_layer_time_below": _hide(weights @ found["void_time_below"], empty),
            "void_layer_exponent": _hide(weights @ found["void_exponent"], empty),
            "void_layer_fiber_exponent": _hide(weights @ grown, empty),
            **_contents("void_layer_content", found, weights, empty),
            "void_layer_moisture": _least(limit, weights),
        }
        for name, values in part.items():
            parts.setdefault(name, []).append(values)
    return {
        "void_layer": (np.arange(layers) + 0.5) * bead / layers,
        **{name: np.stack(values) for name, values in parts.items()},
    }


def bead_totals(found: Mapping[str, Any], regular: NDArray[np.bool_]) -> dict[str, Any]:
    """Return what holds of the bead, or of all paths, with and without singular streamlines.

    Parameters as in `layer_profile`; no heights are needed. The critical moisture of the worst
    streamline, and the mean over the flux (over all paths of a flow from elsewhere), which
    takes saturation where no moisture suffices, as no polymer holds more.
    """
    lowest, limit = found["void_lowest_pressure"], found["void_moisture_limit"]
    most = found["void_saturation_moisture"]
    capped = np.where(np.isnan(limit), most, limit)
    grown = found["void_fiber_exponent"].mean(axis=-1)
    totals: dict[str, list[Array]] = {}
    for chosen in (regular, np.ones_like(regular)):
        everything = chosen[None, :] / max(int(chosen.sum()), 1)
        empty = np.array([not chosen.any()])
        part = {
            "void_bead_lowest_pressure": _least(lowest, everything),
            "void_bead_moisture": _least(limit, everything),
            "void_bead_mean_moisture": _hide(everything @ capped, empty),
            "void_bead_exponent": _hide(everything @ found["void_exponent"], empty),
            "void_bead_fiber_exponent": _hide(everything @ grown, empty),
            **_contents("void_bead_content", found, everything, empty),
            "void_bead_share_below": _hide(
                np.sum(found["void_margin"][chosen] < 0.0, axis=0)[None, :] / max(chosen.sum(), 1),
                empty,
            ),
        }
        for name, values in part.items():
            totals.setdefault(name, []).append(values[0])
    stacked = {name: np.stack(values) for name, values in totals.items()}
    basis = found["void_basis"]
    regularly = SELECTIONS.index("regular")
    return stacked | {
        "void_selection": list(SELECTIONS),
        **_severity(found, regular),
        **_fraction(*(stacked[f"void_bead_content{of}"][regularly] for of in ("", "_rest"))),
        "void_critical_moisture": stacked["void_bead_moisture"][regularly, basis.index("bounds")],
        "void_critical_moisture_mean": stacked["void_bead_mean_moisture"][
            regularly, basis.index(MOST_LIKELY)
        ],
    }


def _contents(
    name: str, found: Mapping[str, Any], weights: Array, empty: NDArray[np.bool_]
) -> dict[str, Array]:
    """Return the void content of layers, with and without fibers: volumes of gas add up."""
    return {
        f"{name}{of}": _hide(gas_share(weights @ found[f"void_gas{of}"]), empty)
        for of in ("", "_rest")
    }


def _fraction(content: Array, at_rest: Array) -> dict[str, float]:
    """Return the void content of the bead at the end of the swell, and its parts."""
    swell = STATIONS.index("swell")
    return {
        "void_fraction": content[swell],
        "void_fraction_tips": content[swell] - at_rest[swell],
        "void_fraction_rest": at_rest[swell],
    }


def _severity(found: Mapping[str, Any], regular: NDArray[np.bool_]) -> dict[str, float]:
    """Return the mean growth exponents of the melt and of what fibers add, with their errors."""
    if not regular.any():
        return dict.fromkeys((*SEVERITIES, *(f"{name}_error" for name in SEVERITIES)), np.nan)
    melt = found["void_basis"].index("melt")
    own, own_error, added, on_fibers_error = (
        float(np.mean(values[regular]))
        for values in (
            found["void_exponent"][:, melt],
            found["void_exponent_error"][:, melt],
            found["void_added_exponent"],
            found["void_fiber_exponent_error"],
        )
    )
    return {
        "severity_melt": own,
        "severity_melt_error": own_error,
        "severity_fibers": added,
        "severity_fibers_error": on_fibers_error + own_error,
    }


def _bead_height(height: Array) -> float:
    """Return the height of the bead [m]: the streamlines stand in the middle of their bands."""
    count = len(height)
    if count == 1:
        return 2.0 * float(height[0])
    return float(height.max() - height.min()) * count / (count - 1)


def _least(values: Array, weights: Array) -> Array:
    """Return the least value in each layer, (layers, ...); NaN where there is none."""
    here = (weights > 0.0)[..., None] & ~np.isnan(values)
    least = np.min(np.broadcast_to(values, here.shape), axis=1, where=here, initial=np.inf)
    return np.where(np.isfinite(least), least, np.nan)


def _hide(values: Array, empty: NDArray[np.bool_]) -> Array:
    """Return NaN where a layer has no streamline."""
    return np.where(empty.reshape(-1, *(1,) * (values.ndim - 1)), np.nan, values)
