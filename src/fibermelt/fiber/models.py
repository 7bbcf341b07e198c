"""What answers for a fiber: how it turns, and what its surface sees.

Four models, one interface. In the plane of the flow each is a `FiberResponse`, so that `follow`,
`surface_pressure`, `pressure_bounds`, `extremes` and `orbit` take any of them:

- ``confined-ellipse``: an ellipse in its circular cell (`solve_cell`), the paper's fiber;
- ``ellipse``: the same in an unbounded melt (`unbounded_ellipse`);
- ``spheroid``: a prolate spheroid in an unbounded melt (`planar_section`), whose tips see more;
- ``ellipsoid``: one of three axes there; in the plane its third axis is across.

They differ in what "every orientation" is: angles in the plane for an ellipse, which is a cylinder
across the flow, directions in space for a spheroid, frames for an ellipsoid. A spheroid's bounds
in a planar flow are the same in both readings (`fibermelt.fiber.section`), the quantiles of an
isotropic start are not. Only the last two can follow a path that leaves the plane, and only in a
melt that is Newtonian or taken for one.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.directions import equal_area_directions, even_frames
from fibermelt.fiber.directors import follow_directors
from fibermelt.fiber.ellipsoid import Ellipsoid, EllipsoidResponse, unbounded_ellipsoid
from fibermelt.fiber.frames import FRAME_TOLERANCE, follow_ellipsoids
from fibermelt.fiber.jeffery import unbounded_ellipse
from fibermelt.fiber.motion import ANGLE_TOLERANCE, deformation_along
from fibermelt.fiber.population import (
    ISOTROPIC_COUNT,
    QUANTILE_LEVELS,
    IsotropicPressure,
    isotropic_pressure,
    population_quantiles,
)
from fibermelt.fiber.pressure import (
    PressureBounds,
    Viscosity,
    newtonian_viscosity,
    pressure_bounds,
)
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.section import planar_section
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.spatial import (
    SpatialMotion,
    follow_spatial,
    half_sphere,
    spatial_bounds,
    turned_directions,
)
from fibermelt.fiber.spheroid import (
    Spheroid,
    SpheroidResponse,
    unbounded_spheroid,
)
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.history import FlowHistory
from fibermelt.shown import Shown

__all__ = ["FiberModel", "confined_model", "unbounded_model"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class FiberModel(Shown):
    """A fiber that can be followed through any planar flow, and some through any flow.

    Parameters
    ----------
    name : str
        Which model it is: "confined-ellipse", "ellipse", "spheroid", "ellipsoid", or one's own.
    response : FiberResponse
        Its answer while it lies in the plane of the flow.
    spheroid : SpheroidResponse or None
        A spheroid's answer in any direction; None for an ellipse, which has no other.
    thinning : ThinningResponse or None
        Its answer in the plane of a melt that thins, whose ``response`` is the Newtonian one.
    ellipsoid : EllipsoidResponse or None
        The answer of a body of three axes in any orientation.
    """

    name: str
    response: FiberResponse
    spheroid: SpheroidResponse | None = None
    thinning: ThinningResponse | None = None
    ellipsoid: EllipsoidResponse | None = None

    @property
    def in_space(self) -> SpheroidResponse | EllipsoidResponse:
        """Return its answer in any orientation, in a Newtonian melt.

        Raises
        ------
        ConfigError
            If it has none.
        """
        body = self.ellipsoid or self.spheroid
        if body is None or not self.has_directions:
            why = "in a melt that thins" if body is not None else "a cylinder across the flow"
            msg = (
                f'fiber.model = "{self.name}": {why} it has no direction out of the plane: take '
                '"spheroid" or "ellipsoid", in a melt that thins with fiber.melt = '
                '"local-viscosity"'
            )
            raise ConfigError(msg)
        return body

    def told(self) -> dict[str, str]:
        """Return which model it is, of which fiber, and in which melt."""
        melt = "Newtonian" if self.thinning is None else "one that thins"
        return {"model": self.name, **self.response.told(), "melt": melt}

    @property
    def turning(self) -> float | ThinningResponse:
        """Return what turns it in the plane of the flow: a shape factor, or its table."""
        return self.response.shape_factor if self.thinning is None else self.thinning

    @property
    def in_plane(self) -> FiberResponse | ThinningResponse:
        """Return its answer in the plane of the flow, in its melt."""
        return self.response if self.thinning is None else self.thinning

    @property
    def has_directions(self) -> bool:
        """Tell whether it can be followed in any orientation."""
        body = self.ellipsoid or self.spheroid
        return body is not None and self.thinning is None

    def directions(self, count: int, *, planar: bool) -> Array:
        """Return orientations spread evenly, in order of the angle seen along z.

        Directions (count, 3) of a spheroid, `half_sphere`; frames (count, 3, 3) of an ellipsoid,
        `even_frames`.

        Parameters
        ----------
        count : int
            Number of fibers.
        planar : bool
            Whether they are for planar flows.
        """
        if self.ellipsoid is None:
            return half_sphere(count, planar=planar)
        frames = even_frames(count)
        order = np.argsort(np.arctan2(frames[:, 1, 0], frames[:, 0, 0]), kind="stable")
        return np.asarray(frames[order])

    def follow_in_space(
        self, path: FlowHistory, start: ArrayLike, tolerance: float = ANGLE_TOLERANCE
    ) -> SpatialMotion:
        """Follow fibers from orientations such as `directions`.

        Parameters
        ----------
        path : FlowHistory
            One path or several, in the plane or in space.
        start : array_like
            Unit vectors (count, 3) of a spheroid, frames (count, 3, 3) of an ellipsoid.
        tolerance : float
            As in `follow_spatial`, or in `follow_ellipsoids`, where none is below its default.

        Raises
        ------
        ConfigError, ConvergenceError
            As in `in_space`, `follow_spatial` and `follow_ellipsoids`.
        """
        body = self.in_space
        if isinstance(body, SpheroidResponse):
            return follow_spatial(path, body.shape_factor, start, tolerance)
        return follow_ellipsoids(path, body, start, max(tolerance, FRAME_TOLERANCE))

    def bounds(self, path: FlowHistory, viscosity: Viscosity) -> PressureBounds:
        """Return the bounds of the pressure extremes over every orientation, (..., n) [Pa].

        In the plane by `fibermelt.fiber.pressure_bounds`; on a path in space, and for an ellipsoid,
        whose worst frames may have any axis across, by `spatial_bounds`. Parameters and errors as
        there.
        """
        if path.planar and self.ellipsoid is None:
            return pressure_bounds(path, self.in_plane, viscosity)
        return spatial_bounds(path, self.in_space, viscosity)

    def isotropic_pressure(
        self,
        path: FlowHistory,
        viscosity: Viscosity,
        zone_time: ArrayLike | None,
        count: int = ISOTROPIC_COUNT,
        levels: tuple[float, ...] = QUANTILE_LEVELS,
        tolerance: float = ANGLE_TOLERANCE,
    ) -> IsotropicPressure:
        """Return quantiles of pressures and extremes for an isotropic start.

        By ``count`` fibers: in the plane for an ellipse, and for all in a melt that thins; else
        over the sphere, directions (`equal_area_directions`) or frames (`even_frames`). The other
        parameters and errors as in `fibermelt.fiber.population.isotropic_pressure`.
        """
        if not self.has_directions:
            return isotropic_pressure(
                path, self.in_plane, viscosity, zone_time, count, levels, tolerance
            )
        values = _isotropic_values(path, self.in_space, count, tolerance)

        def pressures(one: FlowHistory) -> tuple[Array, Array]:
            scale = newtonian_viscosity(viscosity, 0.5 * one.shear_rate)
            lowest, highest = values(one)
            return scale * lowest, scale * highest

        return population_quantiles(path, zone_time, levels, pressures)


def confined_model(response: FiberResponse) -> FiberModel:
    """Return the model of a confined ellipse from its cell's response."""
    return FiberModel("confined-ellipse", response)


def unbounded_model(name: str, fiber: Ellipse | Ellipsoid) -> FiberModel:
    """Return the model of a fiber in an unbounded melt, exact to rounding.

    Parameters
    ----------
    name : {"ellipse", "spheroid", "ellipsoid"}
        Which one.
    fiber : Ellipse or Ellipsoid
        The fiber, or the section of the spheroid through its axis; the ellipsoid, its axes from the
        longest to the shortest. Its size does not matter.

    Raises
    ------
    ConfigError
        If the name is another, or the fiber none of its kind.
    """
    if name == "ellipsoid":
        refuse_other("fiber", fiber, Ellipsoid)
        assert isinstance(fiber, Ellipsoid)
        if list(fiber.semi_axes) != sorted(fiber.semi_axes, reverse=True):
            msg = f"fiber.semi_axes = {fiber.semi_axes}: must fall from the first to the third"
            raise ConfigError(msg)
        body = unbounded_ellipsoid(fiber)
        return FiberModel(name, planar_section(body), ellipsoid=body)
    refuse_other("fiber", fiber, Ellipse)
    assert isinstance(fiber, Ellipse)
    if name == "ellipse":
        return FiberModel(name, unbounded_ellipse(fiber))
    if name == "spheroid":
        spheroid = unbounded_spheroid(Spheroid(fiber.half_length, fiber.aspect_ratio))
        return FiberModel(name, planar_section(spheroid), spheroid)
    msg = (
        f'fiber.model = "{name}": must be "ellipse", "spheroid" or "ellipsoid" in an unbounded melt'
    )
    raise ConfigError(msg)


def _isotropic_values(
    path: FlowHistory, body: SpheroidResponse | EllipsoidResponse, count: int, tolerance: float
) -> Callable[[FlowHistory], tuple[Array, Array]]:
    """Return what finds the lowest and highest pressures over ``mu`` of an isotropic start.

    It takes the paths one by one, in their order; arrays are (count, n).
    """
    if isinstance(body, EllipsoidResponse):
        frames = even_frames(count)

        def of_frames(one: FlowHistory) -> tuple[Array, Array]:
            motion = follow_ellipsoids(one, body, frames, max(tolerance, FRAME_TOLERANCE))
            return body.turned_values(one.gradient, motion.direction, motion.second)

        return of_frames
    initial = equal_area_directions(count)
    if not path.planar:

        def in_space(one: FlowHistory) -> tuple[Array, Array]:
            turned = follow_directors(one, body.shape_factor, initial, tolerance)
            return body.extreme_values(one.gradient, turned.direction)

        return in_space
    deformation, _ = deformation_along(path, body.shape_factor, tolerance)
    lines = itertools.count()

    def in_plane(one: FlowHistory) -> tuple[Array, Array]:
        directions = turned_directions(deformation.line(next(lines)), initial)
        return body.extreme_values(one.gradient, directions)

    return in_plane
