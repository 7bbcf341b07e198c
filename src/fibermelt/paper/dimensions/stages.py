"""What the plane ellipse costs, as a stage: ellipses against the spheroid that a fiber resembles.

The paper's fiber is an ellipse in the plane of the flow, which is a cylinder across it. A spheroid
of the same aspect ratio, whose axis lies in that plane, turns in the same way but sees more at its
tips. Here both stand beside the confined ellipse: in simple shear over aspect ratios, and along the
paper's feature streamlines, for every orientation and for the initial angles in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.fiber.extremes import KINDS, extreme_bounds, extremes, locations
from fibermelt.fiber.motion import follow
from fibermelt.fiber.pressure import pressure_bounds, surface_pressure
from fibermelt.paper.dimensions.quantities import QUANTITIES
from fibermelt.paper.orbits.quantities import QUANTITIES as ORBITS
from fibermelt.parts.bead.beside import (
    MODELS,
    confined_ellipse,
    fiber_models,
    unbounded_models,
)
from fibermelt.parts.bead.quantities import QUANTITIES as BEAD
from fibermelt.parts.bead.stages import domain_size, stored_path, stored_zones
from fibermelt.parts.melt.melt import newtonian_viscosity

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber.models import FiberModel
    from fibermelt.history import FlowHistory

__all__ = ["dimensions_stage", "feature_rows"]

UNBOUNDED = MODELS[1:]

FEATURES, PAPER_COUNT = (4, 10, 18), 22
"""The paper's feature streamlines, of its 22."""

CURVE_RATIOS = (1.0, 20.0, 77)
"""First and last aspect ratio of the curves, and how many: a quarter apart."""


def dimensions_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Compare confined ellipse, ellipse and spheroid, in simple shear and along streamlines."""
    ratios, size = tuple(parameters["sensitivity.aspect_ratios"]), domain_size(parameters, inputs)
    models = fiber_models(parameters, inputs["cell"], size)
    say(f"{len(ratios)} aspect ratios in simple shear")
    along = _along(parameters, inputs["streamlines"], models)
    say(f"{len(along['feature_streamline'])} streamlines, {len(models)} models")
    return labelled(
        {
            "ratio": ratios,
            "dimension_model": list(MODELS),
            "dimension_domain_size": size,
            **_peaks(parameters, ratios, size),
            **along,
        },
        BEAD | ORBITS | QUANTITIES,
    )


def feature_rows(flux_fraction: NDArray[np.float64], features: Sequence[int]) -> list[int]:
    """Return the rows of the streamlines that are looked at one by one.

    Those of the numbers asked for that exist; if none does, those that share the flux most nearly
    as the paper's 4, 10 and 18 of 22.

    Parameters
    ----------
    flux_fraction : (n,) array
        Share of the flux on each streamline's left.
    features : sequence of int
        Their numbers, from 1.
    """
    rows = [number - 1 for number in features if number <= len(flux_fraction)]
    if not rows:
        shares = [(k - 0.5) / PAPER_COUNT for k in FEATURES]
        rows = [int(np.argmin(np.abs(flux_fraction - share))) for share in shares]
    return list(dict.fromkeys(rows))


def _peaks(parameters: Parameters, ratios: tuple[float, ...], size: float) -> dict[str, Any]:
    """Return the highest pressure in simple shear over ``mu gamma_dot``, against aspect ratio."""

    def peak(model: FiberModel) -> float:
        return model.response.tip_pressure

    curve = np.linspace(CURVE_RATIOS[0], CURVE_RATIOS[1], CURVE_RATIOS[2])
    unbounded = [[peak(model) for model in unbounded_models(parameters, ratio)] for ratio in curve]
    table = [
        [
            peak(model)
            for model in (
                confined_ellipse(parameters, ratio, size),
                *unbounded_models(parameters, ratio),
            )
        ]
        for ratio in ratios
    ]
    return {
        "unbounded_model": list(UNBOUNDED),
        "peak_ratio": curve,
        "peak_pressure": np.transpose(unbounded),
        "peak_at_ratio": np.transpose(table),
    }


def _along(parameters: Parameters, lines: xr.Dataset, models: list[FiberModel]) -> dict[str, Any]:
    """Return the lowest pressures along the feature streamlines, by model."""
    rows = feature_rows(lines["flux_fraction"].to_numpy(), parameters["streamlines.features"])
    chosen = lines.isel(streamline=rows)
    path, zone_time = stored_path(chosen), stored_zones(chosen)
    found = [_lowest_along(parameters, path, model, zone_time) for model in models]
    return {
        "location": [*locations(path, zone_time)],
        "planar_angle": np.asarray(parameters["fiber.initial_angles"]),
        "feature_streamline": lines["streamline"].to_numpy()[rows],
        "feature_time": path.time,
        "feature_zone_time": zone_time,
        **{name: np.stack([part[name] for part in found], axis=1) for name in found[0]},
    }


def _lowest_along(
    parameters: Parameters,
    path: FlowHistory,
    model: FiberModel,
    zone_time: NDArray[np.float64] | None,
) -> dict[str, NDArray[np.float64]]:
    """Return the lowest pressures of one model, streamline by streamline."""
    viscosity, lowest = newtonian_viscosity(parameters), KINDS.index("min")
    angles = np.asarray(parameters["fiber.initial_angles"])
    tolerance = parameters["numerics.angle_tolerance"]
    motion = follow(path, model.response.shape_factor, angles, tolerance)
    pressure = surface_pressure(path, model.response, viscosity, motion)
    bounds = pressure_bounds(path, model.response, viscosity)
    return {
        "feature_bound": bounds.lowest,
        "feature_lowest": pressure.lowest.min(axis=-2),
        "feature_extreme": extremes(path, pressure, motion, zone_time).value[..., lowest],
        "feature_extreme_bound": extreme_bounds(path, bounds, zone_time)[..., lowest, 0],
    }
