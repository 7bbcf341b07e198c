"""The orientation tensor along streamlines as figures read it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fibermelt.report.kit.style import Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["angle_from", "closure_row", "component_along", "tensors"]


def tensors(results: xr.Dataset) -> Array:
    """Return the orientation tensor along the streamlines, (streamline, point, 3, 3)."""
    order = ("streamline", "point", "axis", "other_axis")
    found: Array = results["orientation"].transpose(*order).to_numpy()
    return found


def component_along(results: xr.Dataset) -> Array:
    """Return ``s.a.s`` along the streamlines, ``s`` their direction, (streamline, point)."""
    velocity = np.stack([results[name].to_numpy() for name in "uv"], axis=-1)
    s = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
    plane = tensors(results)[..., :2, :2]
    found: Array = np.einsum("...i,...ij,...j->...", s, plane, s)
    return found


def angle_from(a: Array) -> Array:
    """Return the preferred direction in the plane from the x axis [rad], (...).

    ``arctan2(2 a_xy, a_xx - a_yy)/2`` (the paper's Eq. 31), in (-pi/2, pi/2].
    """
    angle: Array = 0.5 * np.arctan2(2.0 * a[..., 0, 1], a[..., 0, 0] - a[..., 1, 1])
    return angle


def closure_row(results: xr.Dataset) -> int:
    """Return the row of the streamline along which the closure is judged."""
    number = int(results["closure_streamline"])
    return int(np.flatnonzero(results["streamline"].to_numpy() == number)[0])
