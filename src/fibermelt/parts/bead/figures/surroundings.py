"""What surrounds a fiber, to be drawn: its outline, and fields on the net of its cell.

Lengths are in units of the half-length, in the flow's axes around the fiber's centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.patches import Polygon
from matplotlib.tri import Triangulation, TriContourSet

from fibermelt.fiber.surroundings import FlowAround, Surroundings
from fibermelt.report.kit.drawing import plain
from fibermelt.report.kit.style import INK, Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "FIBER",
    "LEVELS",
    "Instant",
    "draw_contours",
    "draw_fiber",
    "net",
    "read_instant",
    "rotation",
    "stored_surroundings",
]

FIBER = "#f4ead2"
"""What fibers are filled with."""

ROUGH = 1e-3
"""Isobars are true to this, in half-lengths: a few hundredths of a millimetre on paper."""

_PARTS = np.array([0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0])
LEVELS = np.r_[-_PARTS[:0:-1], _PARTS]
"""Isobars over the pressure scale's end: closer where it is low, as it is in most of the cell."""


def rotation(angle: float) -> Array:
    """Return the matrix that turns the fiber's axes to the flow's."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def net(results: xr.Dataset, angle: float = 0.0, of: str = "cell") -> Triangulation:
    """Return the triangles around a fiber at an angle, of its cell or of what was solved for it."""
    points = results[f"{of}_point"].to_numpy() @ rotation(angle).T
    return Triangulation(points[:, 0], points[:, 1], results[f"{of}_triangle"].to_numpy())


def draw_fiber(axes: Axes, results: xr.Dataset, angle: float = 0.0) -> None:
    """Draw the fiber itself."""
    s = results["surface_angle"].to_numpy()
    rim = np.stack([np.cos(s), np.sin(s) / float(results["aspect_ratio"])], axis=-1)
    axes.add_patch(
        Polygon(rim @ rotation(angle).T, facecolor=FIBER, edgecolor=INK, linewidth=0.8, zorder=4)
    )


def draw_contours(
    axes: Axes, triangles: Triangulation, values: Array, levels: Array, cmap: str
) -> TriContourSet:
    """Draw a field around a fiber as evenly coloured areas between levels."""
    field = axes.tricontourf(
        triangles,
        values,
        levels=levels,
        norm=BoundaryNorm(levels, 256, extend="both"),
        cmap=cmap,
        extend="both",
        zorder=1,
    )
    field.set_paths([plain(path, ROUGH) for path in field.get_paths()])
    # Edges of the areas' own colour, without which the paper would shine through between them.
    field.set_edgecolor("face")
    field.set_linewidth(0.4)
    return field


def stored_surroundings(results: xr.Dataset) -> Surroundings:
    """Return the two flows around the fiber as they are stored."""
    names = ("point", "triangle", "edge", "velocity", "pressure")
    return Surroundings(*(results[f"cell_{name}"].to_numpy() for name in names))


@dataclass(frozen=True, eq=False)
class Instant:
    """The flow around one fiber at one instant.

    Parameters
    ----------
    time : float
        When [s].
    angle : float
        Of the fiber from the x axis [rad].
    elevation : float
        Of the fiber out of the plane of the flow [rad]; what is drawn is in the plane.
    own : float
        The melt's own pressure [Pa].
    melt : (2,) array
        Velocity of the melt, and so of the fiber's centre [m/s].
    around : (cell_node, 2) array
        Velocity less that of the fiber's centre, along the flow's axes [m/s].
    pressure : (cell_node,) array
        Pressure less the melt's own [Pa].
    triangles : Triangulation
        The net of these nodes, along the flow's axes, in half-lengths.
    """

    time: float
    angle: float
    elevation: float
    own: float
    melt: Array
    around: Array
    pressure: Array
    triangles: Triangulation

    @property
    def speed(self) -> Array:
        """Return the magnitude of the velocity, the centre's included [m/s]."""
        speed: Array = np.hypot(*(self.around + self.melt).T)
        return speed


def read_instant(
    results: xr.Dataset, row: int, fiber: int, point: int, half_length: float
) -> Instant:
    """Return the flow around a fiber: a sum of the cell's flows, or as it is stored of one fiber.

    The sum is that of a Newtonian melt of the streamline's viscosity.

    Parameters
    ----------
    results : xarray.Dataset
        The results.
    row, fiber, point : int
        Places of the streamline, of the initial angle, and of the point of the streamline.
    half_length : float
        Of the fiber [m].
    """
    at = results.isel(streamline=row, initial_angle=fiber, point=point)
    angle = float(at["angle"])
    if "around_pressure" in results:
        flow = FlowAround(*(results[f"around_{k}"].to_numpy() for k in ("velocity", "pressure")))
        triangles = net(results, angle, "around")
    else:
        flow = stored_surroundings(results).around(
            at["gradient"].to_numpy(), angle, float(at["viscosity"])
        )
        triangles = net(results, angle)
    return Instant(
        time=float(at["time"]),
        angle=angle,
        elevation=float(at["elevation"]) if "elevation" in at else 0.0,
        own=float(at["pressure"]),
        melt=np.array([float(at["u"]), float(at["v"])]),
        around=half_length * flow.velocity,
        pressure=flow.pressure,
        triangles=triangles,
    )
