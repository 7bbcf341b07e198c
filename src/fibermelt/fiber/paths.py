"""One flow history or many of equal length: what the fiber's stages read.

A `FlowHistory` is one path; `PathBundle` stacks the histories of a study with a leading axis, so
that all streamlines go through the same array operations. Every function of the fiber's stages
takes either and keeps the leading axes (written ``...`` in its shapes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import HistoryError
from fibermelt.history import FlowHistory

__all__ = ["Path", "PathBundle", "single_paths", "strain_polar", "stream_angle"]

Array = NDArray[np.float64]


class Path(Protocol):
    """What a fiber needs of a material point: a `FlowHistory` or a `PathBundle`."""

    def __hash__(self) -> int:
        """Return a number by which the path itself is known again, not its values."""

    @property
    def time(self) -> Array:
        """Time [s], shape (..., n), strictly increasing."""

    @property
    def position(self) -> Array:
        """Position [m], shape (..., n, 2)."""

    @property
    def velocity(self) -> Array:
        """Velocity of the melt [m/s], shape (..., n, 2)."""

    @property
    def gradient(self) -> Array:
        """Velocity gradient ``L[..., i, j] = d u_i/d x_j`` [1/s], shape (..., n, 2, 2)."""

    @property
    def pressure(self) -> Array:
        """Pressure of the melt [Pa], shape (..., n)."""


@dataclass(frozen=True, eq=False)
class PathBundle:
    """Histories of equal number of points, stacked along a leading axis.

    Parameters
    ----------
    histories : sequence of FlowHistory
        At least one, all with the same number of points.

    Raises
    ------
    HistoryError
        If there is none, or their numbers of points differ.
    """

    histories: tuple[FlowHistory, ...]
    time: Array
    position: Array
    velocity: Array
    gradient: Array
    pressure: Array

    def __init__(self, histories: Sequence[FlowHistory]) -> None:
        """Stack the histories; each has been validated by its own type."""
        lengths = sorted({len(history) for history in histories})
        if len(lengths) != 1:
            msg = (
                f"histories of {lengths or 'no'} points cannot be stacked: trace them with one "
                "number of points, or follow them one by one"
            )
            raise HistoryError(msg)
        object.__setattr__(self, "histories", tuple(histories))
        for name in ("time", "position", "velocity", "gradient", "pressure"):
            stacked = np.stack([getattr(history, name) for history in histories])
            stacked.setflags(write=False)
            object.__setattr__(self, name, stacked)

    def __len__(self) -> int:
        """Return the number of paths."""
        return len(self.histories)


def single_paths(path: Path) -> list[Path]:
    """Return the paths of a bundle one by one; a single path alone."""
    return list(path.histories) if isinstance(path, PathBundle) else [path]


def strain_polar(gradient: Array) -> tuple[Array, Array]:
    """Return size ``d`` [1/s] and double angle ``2 beta`` [rad] of the in-plane strain rate.

    ``D = d [[cos 2 beta, sin 2 beta], [sin 2 beta, -cos 2 beta]]``: ``d = gamma_dot/2`` is its
    positive eigenvalue and ``beta`` the direction of stretching. In the axes of a fiber at
    ``theta``: ``D_11 = d cos(2 beta - 2 theta)``, ``D_12 = d sin(2 beta - 2 theta)``.

    Parameters
    ----------
    gradient : (..., 2, 2) array
        Velocity gradient [1/s]; a trace of rounding size is left out.
    """
    normal = 0.5 * (gradient[..., 0, 0] - gradient[..., 1, 1])
    shear = 0.5 * (gradient[..., 0, 1] + gradient[..., 1, 0])
    return np.hypot(normal, shear), np.arctan2(shear, normal)


def stream_angle(path: Path) -> Array:
    """Return the angle of the velocity from the x axis [rad], continuous along the path, (..., n).

    A melt at rest has no direction; it is given the x axis.
    """
    angle = np.arctan2(path.velocity[..., 1], path.velocity[..., 0])
    return np.asarray(np.unwrap(angle, axis=-1))
