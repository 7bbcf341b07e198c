"""One flow history or many of equal length: what the fiber's stages read.

A `FlowHistory` is one path; `PathBundle` stacks the histories of a study with a leading axis, so
that all streamlines go through the same array operations. Every function of the fiber's stages
takes either and keeps the leading axes (written ``...`` in its shapes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fibermelt.arrays import Unchanging
from fibermelt.errors import HistoryError, refuse_other
from fibermelt.history import FlowHistory

__all__ = [
    "Path",
    "PathBundle",
    "checked_path",
    "refuse_another_path",
    "single_paths",
    "strain_polar",
    "stream_angle",
]

Array = NDArray[np.float64]


QUANTITIES = ("time", "position", "velocity", "gradient", "pressure")
"""What is known at the points of a path."""


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
class PathBundle(Unchanging):
    """Histories of equal number of points, stacked along a leading axis.

    Parameters
    ----------
    histories : sequence of FlowHistory
        At least one, all with the same number of points.

    Raises
    ------
    HistoryError
        If there is none, or their numbers of points differ.
    ConfigError
        If one is no history.
    """

    histories: Sequence[FlowHistory]
    time: Array = field(init=False)
    position: Array = field(init=False)
    velocity: Array = field(init=False)
    gradient: Array = field(init=False)
    pressure: Array = field(init=False)

    def __post_init__(self) -> None:
        """Stack the histories; each has been validated by its own type."""
        refuse_other("histories", self.histories, Sequence)
        histories = tuple(self.histories)
        for k, history in enumerate(histories):
            refuse_other(f"histories[{k}]", history, FlowHistory)
        lengths = sorted({len(history) for history in histories})
        if len(lengths) != 1:
            msg = (
                f"histories of {lengths or 'no'} points cannot be stacked: trace them with one "
                "number of points, or follow them one by one"
            )
            raise HistoryError(msg)
        object.__setattr__(self, "histories", histories)
        for name in QUANTITIES:
            stacked = np.stack([getattr(history, name) for history in histories])
            object.__setattr__(self, name, stacked)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of paths."""
        return len(self.histories)


def single_paths(path: Path) -> list[Path]:
    """Return the paths of a bundle one by one; a single path alone."""
    return list(path.histories) if isinstance(path, PathBundle) else [path]


def checked_path(path: Path) -> None:
    """Refuse what is neither a history nor a bundle of them (`ConfigError`).

    What is kept for a path is found again by the path itself, so that its numbers must stay.
    """
    refuse_other("path", path, (FlowHistory, PathBundle))


def refuse_another_path(path: Path, followed: Path) -> None:
    """Refuse a path other than the one that fibers were followed along; a copy is the same.

    Raises
    ------
    ConfigError
        If it is no path.
    HistoryError
        If its shape or a number differs.
    """
    checked_path(path)
    if path is followed:
        return
    way = "give the path that the fibers were followed along"
    if path.time.shape != followed.time.shape:
        shapes = path.time.shape, followed.time.shape
        here, there = (" x ".join(map(str, shape)) for shape in shapes)
        msg = f"the path has {here} points, the motion was followed over {there}: {way}"
        raise HistoryError(msg)
    for name in QUANTITIES:
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
