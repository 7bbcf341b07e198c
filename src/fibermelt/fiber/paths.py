"""What the fiber's verbs ask of a path, and the strain in its plane.

Every verb takes one history or several stacked and keeps the leading axes (written ``...`` in its
shapes).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import HistoryError, refuse_other
from fibermelt.history import FlowHistory

__all__ = [
    "checked_path",
    "refuse_another_path",
    "strain_polar",
]

Array = NDArray[np.float64]


def checked_path(path: FlowHistory) -> None:
    """Refuse what is no history (`ConfigError`), or one that leaves the plane (`HistoryError`).

    What is kept for a path is found again by the path itself, so that its numbers must stay.
    """
    refuse_other("path", path, FlowHistory)
    if not path.planar:
        msg = (
            "the path leaves the plane of x and y, where this fiber is known: take fiber.model = "
            '"spheroid" or "ellipsoid" (follow_spatial, follow_ellipsoids), in a melt that thins '
            'with fiber.melt = "local-viscosity"'
        )
        raise HistoryError(msg)


def refuse_another_path(path: FlowHistory, followed: FlowHistory) -> None:
    """Refuse a path other than the one that fibers were followed along; a copy is the same.

    Raises
    ------
    ConfigError
        If it is no path.
    HistoryError
        If its shape or a number differs.
    """
    refuse_other("path", path, FlowHistory)
    if path is followed:
        return
    way = "give the path that the fibers were followed along"
    if path.time.shape != followed.time.shape:
        shapes = path.time.shape, followed.time.shape
        here, there = (" x ".join(map(str, shape)) for shape in shapes)
        msg = f"the path has {here} points, the motion was followed over {there}: {way}"
        raise HistoryError(msg)
    for name in followed.quantities:
        own, other = getattr(path, name), getattr(followed, name)
        if not np.array_equal(own, other):
            where = tuple(int(k) for k in np.argwhere(own != other)[0])
            msg = (
                f"the motion was followed along another path: {name}{list(where)} is "
                f"{own[where]:.6g} here, {other[where]:.6g} there; {way}"
            )
            raise HistoryError(msg)


def strain_polar(gradient: Array) -> tuple[Array, Array]:
    """Return size ``d`` [1/s] and double angle ``2 beta`` [rad] of the in-plane strain rate.

    ``D = d [[cos 2 beta, sin 2 beta], [sin 2 beta, -cos 2 beta]]``: ``d = gamma_dot/2`` is its
    positive eigenvalue and ``beta`` the direction of stretching. In the axes of a fiber at
    ``theta``: ``D_11 = d cos(2 beta - 2 theta)``, ``D_12 = d sin(2 beta - 2 theta)``.

    Parameters
    ----------
    gradient : (..., 2, 2) or (..., 3, 3) array
        Velocity gradient [1/s]; a trace of rounding size is left out, and what is across the plane.
    """
    normal = 0.5 * (gradient[..., 0, 0] - gradient[..., 1, 1])
    shear = 0.5 * (gradient[..., 0, 1] + gradient[..., 1, 0])
    return np.hypot(normal, shear), np.arctan2(shear, normal)
