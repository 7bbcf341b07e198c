"""What answers for a fiber: how it turns, and what its surface sees, for any planar flow.

Three models, one interface. In the plane of the flow each is a `FiberResponse`, so that `follow`,
`surface_pressure`, `pressure_bounds`, `extremes` and `orbit` take any of them:

- ``confined-ellipse``: an ellipse in its circular cell (`solve_cell`), the paper's fiber;
- ``ellipse``: the same in an unbounded melt (`unbounded_ellipse`);
- ``spheroid``: a prolate spheroid in an unbounded melt (`planar_section`), whose tips see more.

They differ in what "every orientation" is: angles in the plane for an ellipse, which is a cylinder
across the flow, and directions in space for a spheroid. The bounds are the same in both readings
(`fibermelt.fiber.section`), the quantiles of an isotropic start are not.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.directions import equal_area_directions
from fibermelt.fiber.extremes import before_middle, extreme_values
from fibermelt.fiber.jeffery import unbounded_ellipse
from fibermelt.fiber.motion import ANGLE_TOLERANCE, deformation_along
from fibermelt.fiber.paths import strain_polar
from fibermelt.fiber.population import (
    ISOTROPIC_COUNT,
    QUANTILE_LEVELS,
    IsotropicPressure,
    isotropic_pressure,
    population_quantiles,
)
from fibermelt.fiber.pressure import Viscosity, newtonian_viscosity
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.section import planar_section
from fibermelt.fiber.shape import Ellipse
from fibermelt.fiber.spatial import turned_directions
from fibermelt.fiber.spheroid import (
    Spheroid,
    SpheroidResponse,
    unbounded_spheroid,
)
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.history import FlowHistory
from fibermelt.shown import Shown

__all__ = ["MODELS", "FiberModel", "ModelName", "confined_model", "unbounded_model"]

Array = NDArray[np.float64]

ModelName = Literal["confined-ellipse", "ellipse", "spheroid"]

MODELS: tuple[ModelName, ...] = get_args(ModelName)
"""The models by name."""


@dataclass(frozen=True, eq=False, repr=False)
class FiberModel(Shown):
    """A fiber that can be followed through any planar flow.

    Parameters
    ----------
    name : {"confined-ellipse", "ellipse", "spheroid"}
        Which model it is.
    response : FiberResponse
        Its answer while it lies in the plane of the flow.
    spheroid : SpheroidResponse or None
        Its answer in any direction; None for an ellipse, which has no other.
    thinning : ThinningResponse or None
        Its answer in the plane of a melt that thins, whose ``response`` is the Newtonian one.
    """

    name: ModelName
    response: FiberResponse
    spheroid: SpheroidResponse | None = None
    thinning: ThinningResponse | None = None

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

    def isotropic_pressure(
        self,
        path: FlowHistory,
        viscosity: Viscosity,
        middle_time: ArrayLike | None,
        count: int = ISOTROPIC_COUNT,
        levels: tuple[float, ...] = QUANTILE_LEVELS,
        tolerance: float = ANGLE_TOLERANCE,
    ) -> IsotropicPressure:
        """Return quantiles of pressures and extremes for an isotropic start.

        In the plane for an ellipse, and for all in a melt that thins; over the sphere for a
        spheroid in a Newtonian one, by ``count`` directions (`equal_area_directions`), between
        whose values quantiles are linear. The other
        parameters and errors as in `fibermelt.fiber.population.isotropic_pressure`.
        """
        if self.spheroid is None or self.thinning is not None:
            return isotropic_pressure(
                path, self.in_plane, viscosity, middle_time, levels, tolerance
            )
        return _isotropic_spheroids(
            path, self.spheroid, viscosity, middle_time, count, levels, tolerance
        )


def confined_model(response: FiberResponse) -> FiberModel:
    """Return the model of a confined ellipse from its cell's response."""
    return FiberModel("confined-ellipse", response)


def unbounded_model(name: ModelName, fiber: Ellipse) -> FiberModel:
    """Return the model of a fiber in an unbounded melt, exact to rounding.

    Parameters
    ----------
    name : {"ellipse", "spheroid"}
        Which one.
    fiber : Ellipse
        The fiber, or the section of the spheroid through its axis; its size does not matter.

    Raises
    ------
    ConfigError
        If the name is another, or the fiber none.
    """
    refuse_other("fiber", fiber, Ellipse)
    if name == "ellipse":
        return FiberModel(name, unbounded_ellipse(fiber))
    if name == "spheroid":
        spheroid = unbounded_spheroid(Spheroid(fiber.half_length, fiber.aspect_ratio))
        return FiberModel(name, planar_section(spheroid), spheroid)
    msg = f'fiber.model = "{name}": must be "ellipse" or "spheroid" in an unbounded melt'
    raise ConfigError(msg)


def _isotropic_spheroids(
    path: FlowHistory,
    spheroid: SpheroidResponse,
    viscosity: Viscosity,
    middle_time: ArrayLike | None,
    count: int,
    levels: tuple[float, ...],
    tolerance: float,
) -> IsotropicPressure:
    """Return quantiles over spheroids that start isotropic in space, path by path."""
    initial = equal_area_directions(count)
    deformation, _ = deformation_along(path, spheroid.shape_factor, tolerance)
    paths = itertools.count()

    def pressures(one: FlowHistory, middle: float | None) -> tuple[Array, Array, Array]:
        k = next(paths)
        directions = turned_directions(deformation.line(k), initial)
        size, _ = strain_polar(one.gradient)
        scale = newtonian_viscosity(viscosity, size)
        lowest, highest = spheroid.extreme_values(one.gradient, directions)
        lowest, highest = scale * lowest, scale * highest
        return lowest, highest, extreme_values(lowest, highest, before_middle(one, middle))

    return population_quantiles(path, middle_time, levels, pressures)
