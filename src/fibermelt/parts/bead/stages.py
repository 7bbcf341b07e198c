"""The fiber's stages: its cell, and its motion and pressure along streamlines, as labelled data.

What loads the finite elements is imported where it is used.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Parameters, Say
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.corner import felt_path
from fibermelt.fiber.extremes import KINDS, ZONES, extreme_bounds, locations
from fibermelt.fiber.population import QUANTILE_LEVELS
from fibermelt.fiber.thinning import ThinningResponse
from fibermelt.history import FlowHistory
from fibermelt.parts.bead.checks import refuse_in_plane
from fibermelt.parts.bead.followed import followed_by_newton, followed_in_plane, followed_in_space
from fibermelt.parts.bead.quantities import QUANTITIES
from fibermelt.parts.bead.shape import Sizes
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.melt.melt import law_of, viscosity_of

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber.models import FiberModel

    Array = NDArray[np.float64]

__all__ = [
    "cell_estimates",
    "cell_numerics",
    "cell_stage",
    "domain_size",
    "foresee_motion",
    "motion_estimates",
    "motion_stage",
    "sizes_of",
    "stored_model",
    "stored_path",
    "stored_zones",
    "thinning_numerics",
]

MODELS_KEPT = 8
"""Models of fibers that are kept at hand: a few hundred kilobytes each."""

SHAPE_FACTOR_BOUND = {"graded": 1e-3, "paper": 2e-2}
"""Largest estimated error of ``B``, over ``B`` if that is above one. The lowest order has 1e-4 at
``M = 4``, the default 1e-9; the paper's mesh, whose error is what it is there to show, has 1.4e-2
at ``M = 2.01``. A rounder fiber in a narrower cell takes a higher order, or is lost to rounding."""

EXTREME_BOUND = 0.25
"""Largest estimated error of the extremes and of their quantiles, median over all, in parts of the
largest on their paths: 1e-3 on the default paths; of 52 points, with which an extreme is a fifth
off, 0.1. Quantiles have 1e-4 of the default number of fibers, 1e-3 of 25."""

TIP_PRESSURE_BOUND = {"graded": 0.05, "paper": 1.0}
"""Largest estimated error of the tip pressure, relative: the lowest order has 1e-2 at ``M = 4``,
the default 1e-5. The paper's mesh has 0.15 at ``r_e = 6`` and 0.88 at 100; as large as the pressure
itself it says nothing of it."""


def cell_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve the fiber's cell, or take what is known of a fiber without one."""
    shape = SHAPES[parameters["fiber.model"]]
    numerics, size = None, 0.0
    if shape.has_cell:
        numerics, size = cell_numerics(parameters), domain_size(parameters, inputs)
    return labelled(
        {"fiber_model": shape.name, **shape.solved(sizes_of(parameters), size, numerics, say)},
        QUANTITIES,
    )


def sizes_of(parameters: Mapping[str, Any]) -> Sizes:
    """Return how large the study's fiber is."""
    names = ("half_length", "aspect_ratio", "thickness_ratio")
    return Sizes(*(parameters[f"fiber.{name}"] for name in names))


def cell_estimates(parameters: Parameters, cell: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of a cell, each with its bound; those of a fiber without one are zero."""
    mesh = parameters["numerics.cell_mesh"]
    paper = mesh == "paper"
    cure = "take a " + (
        'smaller fiber.aspect_ratio or numerics.cell_mesh = "graded"'
        if paper
        else "higher numerics.cell_order or a fiber.domain_size further from 2"
    )
    factor, tip = float(cell["shape_factor_error"]), float(cell["tip_pressure_error"])
    size = max(1.0, abs(float(cell["shape_factor"])))
    return (
        Estimate("shape_factor_error", factor, SHAPE_FACTOR_BOUND[mesh] * size, cure),
        Estimate("tip_pressure_error", tip, TIP_PRESSURE_BOUND[mesh], cure),
    )


def domain_size(parameters: Parameters, inputs: Inputs) -> float:
    """Return ``M`` of the fiber's cell [-]: as the study says, or from its fiber content."""
    if "content" in inputs:
        return float(inputs["content"]["content_domain_size"])
    return float(parameters["fiber.domain_size"])


def cell_numerics(parameters: Parameters) -> CellNumerics:
    """Return how the study's cell is solved."""
    reference = parameters["fiber.pressure_reference"]
    if parameters["numerics.cell_mesh"] == "paper":
        return CellNumerics(mesh="paper", pressure_reference=reference)
    return CellNumerics(order=parameters["numerics.cell_order"], pressure_reference=reference)


def thinning_numerics(parameters: Parameters) -> CellNumerics:
    """Return how the study's cell is solved in a melt that thins."""
    from fibermelt.fiber.cell.thinning import THINNING_NUMERICS  # noqa: PLC0415  loads the finite elements

    return replace(
        THINNING_NUMERICS,
        order=parameters["numerics.thinning_order"],
        pressure_reference=parameters["fiber.pressure_reference"],
    )


def stored_model(cell: xr.Dataset) -> FiberModel:
    """Return the fiber's model that was stored; the same cell gives the very same model.

    What a model has worked out, such as its support function, then serves all cases of a sweep
    that share the cell.
    """
    name = str(cell["fiber_model"].item())
    stored = {key: cell[key].to_numpy() for key in SHAPES[name].stored}
    return _restored(
        name, tuple((key, array.shape, array.tobytes()) for key, array in stored.items())
    )


@lru_cache(maxsize=MODELS_KEPT)
def _restored(name: str, stored: tuple[tuple[str, tuple[int, ...], bytes], ...]) -> FiberModel:
    """Return the model of a fiber from its stored variables."""
    return SHAPES[name].restored(
        {key: np.frombuffer(data).reshape(shape) for key, shape, data in stored}
    )


def stored_path(lines: xr.Dataset) -> FlowHistory:
    """Return the flow histories that were stored, stacked."""
    space = "z" in lines
    time, gradient, pressure = (lines[n].to_numpy() for n in ("time", "gradient", "pressure"))
    return FlowHistory(
        time=time,
        position=np.stack([lines[name] for name in ("x", "y", "z")[: 2 + space]], axis=-1),
        velocity=np.stack([lines[name] for name in ("u", "v", "w")[: 2 + space]], axis=-1),
        gradient=gradient,
        pressure=pressure,
        viscosity=lines["viscosity"].to_numpy(),
    )


def stored_zones(lines: xr.Dataset) -> Array | None:
    """Return the times at zones 1 to 3 that were stored [s], (streamline, 3); None without any.

    NaN stands for a zone that the flow's study does not name, or a path does not reach.
    """
    if "zone_time" not in lines:
        return None
    return np.asarray(
        lines["zone_time"].reindex(zone=range(1, ZONES + 1)).transpose("streamline", "zone")
    )


def _model_in_melt(parameters: Parameters, inputs: Inputs) -> FiberModel:
    """Return the fiber's model, with its table of a melt that thins where the study has one."""
    model = stored_model(inputs["cell"])
    if "response" not in inputs:
        return model
    arrays = {str(name): one.to_numpy() for name, one in inputs["response"].variables.items()}
    return replace(model, thinning=ThinningResponse.from_arrays(law_of(parameters), arrays))


def foresee_motion(parameters: Parameters, name: str, data: xr.Dataset) -> None:
    """Refuse fibers that are known in a plane only as soon as a field is known to be in space."""
    if name == "field" and str(data["field_geometry"].item()) == "spatial":
        refuse_in_plane(parameters["fiber.model"], parameters["fiber.directions"])


def _by_gradient(lines: xr.Dataset, path: FlowHistory, lowest: Any, when: Any) -> Any:
    """Return what the gradient's error does to extremes (n_streamlines, ...) at most [Pa].

    An error ``e`` of the gradient changes the strain's size ``d`` by at most ``e/sqrt(2)``, and
    what it does to the fiber's direction counts for the rest of ``e``: of the lowest over every
    orientation the pressure is off by as much as ``e`` is of ``d``.
    """
    size = np.maximum(0.5 * path.shear_rate, np.finfo(float).tiny)
    error = np.abs(lowest) / size * lines["gradient_error"].to_numpy()
    index = [np.searchsorted(time, at) for time, at in zip(path.time, when, strict=True)]
    return np.stack([one[at] for one, at in zip(error, index, strict=True)])


def _felt_lowest(
    parameters: Parameters, lines: xr.Dataset, path: FlowHistory, model: FiberModel
) -> dict[str, Array]:
    """Return the bound of the lowest pressure with what fibers feel at most near corners [Pa].

    Nothing of a flow from elsewhere, whose corners nobody has named.
    """
    if "corner_distance" not in lines:
        return {}
    felt = felt_path(
        path,
        lines["corner_distance"].to_numpy(),
        parameters["fiber.half_length"],
        law_of(parameters).index_at(path.shear_rate),
        lines["gradient_error"].to_numpy(),
    )
    return {"felt_lowest": model.bounds(felt, viscosity_of(parameters)).lowest}


def motion_estimates(parameters: Parameters, motion: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of extremes and of their quantiles, each with its bound.

    The median over all of them, in parts of the largest pressure that any orientation meets on the
    path.
    """

    def rows(name: str) -> Any:
        values = np.abs(motion[name].transpose("streamline", ...).to_numpy())
        return values.reshape(len(values), -1)

    largest = rows("extreme_bounds").max(axis=1)
    largest = np.where(largest > 0, largest, 1.0)
    cures = {
        "extreme_error": "take more streamlines.points, or a flow on a finer mesh",
        "extreme_quantiles_error": "take more numerics.isotropic_angles",
    }
    return tuple(
        Estimate(
            f"{name} over the largest extreme",
            float(np.median(np.median(rows(name), axis=1) / largest)),
            EXTREME_BOUND,
            cure,
        )
        for name, cure in cures.items()
    )


def motion_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Follow the fibers along all streamlines, and find the pressure on their surfaces.

    What is over every orientation, bounds and quantiles, is by superposition on either path: the
    paper's algorithm would take a run of its own for each.
    """
    path, model = stored_path(inputs["streamlines"]), _model_in_melt(parameters, inputs)
    if not path.planar:
        refuse_in_plane(parameters["fiber.model"], parameters["fiber.directions"])
    viscosity, count = viscosity_of(parameters), parameters["numerics.isotropic_angles"]
    lines = inputs["streamlines"]
    zone_time = stored_zones(lines)
    if parameters["fiber.path"] == "newton":
        chosen = thinning_numerics if "response" in inputs else cell_numerics
        size, numerics = domain_size(parameters, inputs), chosen(parameters)
        followed = followed_by_newton(parameters, path, model, size, numerics, zone_time, say)
    elif parameters["fiber.directions"] == "in-plane":
        followed = followed_in_plane(parameters, path, model, zone_time, say)
    else:
        followed = followed_in_space(parameters, path, model, zone_time, say)
    if path.planar:
        followed.pop("extreme_z")
    if zone_time is not None:
        followed["zone_angle"] = followed["zone_angle"][..., lines["zone"].to_numpy() - 1]
    bounds = model.bounds(path, viscosity)
    say(f"{count} fibers of an isotropic start")
    if "gradient_error" in lines:
        at = followed["extreme_time"]
        followed["extreme_error"] += _by_gradient(lines, path, bounds.lowest, at)
    isotropic = model.isotropic_pressure(
        path, viscosity, zone_time, count, QUANTILE_LEVELS, parameters["numerics.angle_tolerance"]
    )
    return labelled(
        {
            **followed,
            "location": [*locations(path, zone_time)],
            "kind": list(KINDS),
            "quantile": isotropic.levels,
            "bound_lowest": bounds.lowest,
            "bound_highest": bounds.highest,
            **_felt_lowest(parameters, lines, path, model),
            "quantile_lowest": isotropic.lowest,
            "quantile_highest": isotropic.highest,
            "extreme_bounds": extreme_bounds(path, bounds, zone_time),
            "extreme_quantiles": isotropic.extremes,
            "extreme_quantiles_error": isotropic.extremes_error,
        },
        QUANTITIES,
    )
