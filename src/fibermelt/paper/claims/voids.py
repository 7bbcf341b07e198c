"""What claims on voids over the bead are judged by; see `claims.measures`.

The profile goes from the bed to the free surface. Each quantity is the rank correlation of a
layer's height and its lowest pressure: 1 where the risk falls from each layer to the one above.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import spearmanr

from fibermelt.paper.claims.measures import Measure, NotStoredError, needing

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["VOIDS"]

VOIDS: dict[str, Measure] = {}
"""The quantities of voids over the bead, by their names."""

needs = partial(needing, VOIDS, part="voids")

FEWEST_LAYERS = 3
"""Layers that a trend takes."""


def _rise(results: xr.Dataset, name: str, selection: str, basis: str = "") -> float:
    """Return Spearman's rank correlation of height and a pressure of the profile."""
    layers = results[name].sel(void_selection=selection)
    if basis:
        layers = layers.sel(void_basis=basis)
    pressure, height = layers.to_numpy(), results["void_layer"].to_numpy()
    there = ~np.isnan(pressure)
    if np.count_nonzero(there) < FEWEST_LAYERS or not np.ptp(pressure[there]):
        msg = "fewer than three layers of the bead differ: there is no trend to judge"
        raise NotStoredError(msg)
    return float(spearmanr(height[there], pressure[there]).statistic)


@needs("void_layer_fiber_pressure")
def void_profile_of_fibers(results: xr.Dataset) -> float:
    """Return the trend of the mean over the initial angles, without singular streamlines."""
    return _rise(results, "void_layer_fiber_pressure", "regular")


@needs("void_layer_fiber_pressure")
def void_profile_of_fibers_all(results: xr.Dataset) -> float:
    """Return the trend of the mean over the initial angles, with all streamlines."""
    return _rise(results, "void_layer_fiber_pressure", "all")


@needs("void_layer_mean_pressure")
def void_profile_of_bounds(results: xr.Dataset) -> float:
    """Return the trend of a fiber in its worst direction, without singular streamlines."""
    return _rise(results, "void_layer_mean_pressure", "regular", "bounds")


@needs("void_layer_mean_pressure")
def void_profile_of_bounds_all(results: xr.Dataset) -> float:
    """Return the trend of a fiber in its worst direction, with all streamlines."""
    return _rise(results, "void_layer_mean_pressure", "all", "bounds")


@needs("void_layer_mean_pressure")
def void_profile_of_spheroids(results: xr.Dataset) -> float:
    """Return the trend of an unbounded spheroid in any direction, without singular streamlines."""
    return _rise(results, "void_layer_mean_pressure", "regular", "spheroid")
