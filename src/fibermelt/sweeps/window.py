"""The process window of a sweep: critical moisture against print speed and gap, and its advice.

A collected sweep is a dataset with a dimension for each thing that varies, named by its key, and
the variables of the cases over them; cases that failed are NaN. That is all that is asked of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fibermelt.errors import ConfigError

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

__all__ = ["GAP", "SPEED", "critical_moistures", "drying_advice"]

SPEED, GAP = "flow.bed_speed", "flow.gap"
"""Keys of a study that the window's axes are named by."""

MEASURES = ("void_critical_moisture", "void_critical_moisture_mean")
"""For any direction of a fiber at the worst place; for the median fiber, mean by flux."""


def critical_moistures(collected: xr.Dataset) -> tuple[Array, Array]:
    """Return critical moistures [-] of the worst fiber and of the median one, (speed, gap).

    Where no moisture that the polymer can hold starts a void the worst fiber's is saturation; NaN
    is a case that has no numbers.

    Parameters
    ----------
    collected : xarray.Dataset
        A collected sweep over `SPEED` and `GAP` of a study with the part "voids".

    Raises
    ------
    ConfigError
        If it varies by something else, or has no voids.
    """
    if missing := [
        name for name in (*MEASURES, "void_saturation_moisture") if name not in collected
    ]:
        msg = f'the sweep has no {missing[0]}: name "voids" in study.parts and run it again'
        raise ConfigError(msg)
    if set(collected[MEASURES[0]].dims) != {SPEED, GAP}:
        over = ", ".join(map(str, collected[MEASURES[0]].dims)) or "nothing"
        msg = f"a process window is a sweep over {SPEED} and {GAP}, this one is over {over}"
        raise ConfigError(msg)
    worst, median = (collected[name].transpose(SPEED, GAP).to_numpy() for name in MEASURES)
    # The median's mean is there wherever the case is; the worst's NaN then says: none suffices.
    most = np.broadcast_to(collected["void_saturation_moisture"].max().to_numpy(), worst.shape)
    return np.where(np.isnan(worst) & ~np.isnan(median), most, worst), median


def drying_advice(collected: xr.Dataset) -> str:
    """Return what a process window advises on drying, in one sentence.

    Parameters and errors as of `critical_moistures`.
    """
    worst, median = critical_moistures(collected)
    if np.all(np.isnan(worst)):
        return "No case of the sweep has a critical moisture: there is no advice on drying."
    speeds, gaps = (1e3 * collected[name].to_numpy() for name in (SPEED, GAP))
    best = np.unravel_index(np.nanargmax(worst), worst.shape)
    at = f"{speeds[best[0]]:.3g} mm/s and a gap of {gaps[best[1]]:.3g} mm"
    easiest = np.unravel_index(np.nanargmax(median), median.shape)
    if worst[best] <= 0.0:
        return (
            "No drying keeps every fiber free of voids at any of these speeds and gaps: slow "
            f"down; half of the fibers stay free of them on average below "
            f"{100 * median[easiest]:.2g} % at {speeds[easiest[0]]:.3g} mm/s and a gap of "
            f"{gaps[easiest[1]]:.3g} mm."
        )
    good = np.any(worst > 0.0, axis=1)
    lost = ~good & np.any(~np.isnan(worst), axis=1) & (speeds > speeds[good].max())
    hopeless = sorted(float(speed) for speed in speeds[lost])
    beyond = f"; from {hopeless[0]:.3g} mm/s on, drying alone does not do" if hopeless else ""
    return (
        f"Dry below {100 * worst[best]:.2g} % and print at {at} to keep every fiber free of "
        f"voids{beyond}."
    )
