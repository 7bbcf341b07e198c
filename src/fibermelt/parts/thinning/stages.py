"""What thinning does, as a stage: the bead of the study with power laws of falling index.

All have the study's viscosity at one rate, so that what differs is the index alone. Three causes
are told apart: the flow thins and fibers see its local viscosity; the flow is the Newtonian one
and the fiber's own melt thins; both do.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Neighbour, Parameters, Say, refuse_beyond
from fibermelt.fiber.extremes import SWELL, locations
from fibermelt.fiber.motion import follow
from fibermelt.fiber.orbit import orbit
from fibermelt.fiber.pressure import LocalViscosity, pressure_bounds, surface_pressure
from fibermelt.melt import PowerLaw
from fibermelt.parts.bead.beside import fiber_models
from fibermelt.parts.bead.response import response_estimates, thinning_response
from fibermelt.parts.bead.stages import domain_size, stored_path, stored_zones
from fibermelt.parts.flow.stages import (
    flow_estimates,
    flow_from,
    streamline_estimates,
    streamlines_stage,
)
from fibermelt.parts.melt.melt import LAW, newtonian_viscosity
from fibermelt.parts.thinning.quantities import QUANTITIES

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber.models import FiberModel
    from fibermelt.fiber.pressure import Viscosity

    Array = NDArray[np.float64]

__all__ = ["CAUSES", "effect_stage"]

CAUSES = ("both", "flow", "fiber")
"""What thins."""

MODELS = ("confined-ellipse", "spheroid")

SLENDEREST = 20.0
"""Aspect ratio up to which spheroids are known in a melt that thins."""


def effect_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Compare the study's bead with beads of melts that thin."""
    known = MODELS[:1] if parameters["fiber.aspect_ratio"] > SLENDEREST else MODELS
    models = fiber_models(parameters, inputs["cell"], domain_size(parameters, inputs))
    newtonian = [model for model in models if model.name in known]
    indices = (1.0, *parameters["thinning.indices"])
    viscosity = newtonian_viscosity(parameters)
    first, rows, regular = inputs["streamlines"], [], []
    for index, (flow, lines) in zip(indices, _flows(parameters, inputs, say), strict=True):
        law = _law(parameters, index)
        found = []
        for model in newtonian:
            thinned = model if index == 1.0 else _thinned(parameters, inputs, model, law)
            found.append(_on_fibers(parameters, model, thinned, law, first, lines))
        say(f"index {index:g}: {len(CAUSES)} causes, {len(newtonian)} models of a fiber")
        regular.append(lines["near_singularity"].to_numpy() == 0)
        told = {name: float(flow[name]) for name in ("inlet_pressure", "contact_point")}
        told |= {f"{name}_error": float(flow[f"{name}_error"]) for name in told}
        rows.append(
            {
                "consistency": viscosity * parameters["thinning.rate"] ** (1.0 - index),
                **told,
                **{name: [one[name] for one in found] for name in found[0]},
            }
        )
    return labelled(
        {
            "effect_index": indices,
            "effect_model": [model.name for model in newtonian],
            "effect_cause": list(CAUSES),
            "effect_regular": np.all(regular, axis=0).astype(np.int8),
            **{f"effect_{name}": np.array([row[name] for row in rows]) for name in rows[0]},
        },
        QUANTITIES,
    )


def _law(parameters: Parameters, index: float) -> PowerLaw:
    """Return the power law that has the study's viscosity at the rate."""
    rate = parameters["thinning.rate"]
    return PowerLaw(newtonian_viscosity(parameters) * rate ** (1.0 - index), index)


def _flows(
    parameters: Parameters, inputs: Inputs, say: Say
) -> Iterator[tuple[xr.Dataset, xr.Dataset]]:
    """Yield flow and streamlines of each law, each from the one before."""
    flow = inputs["flow"]
    yield flow, inputs["streamlines"]
    for index in parameters["thinning.indices"]:
        law = {
            f"{LAW}.{name}": value for name, value in _law(parameters, index).constants().items()
        }
        of_it = {key: None for key in parameters if key.startswith(f"{LAW}.")}
        melt = Parameters({**parameters, **of_it, **law, f"{LAW}.name": "power-law"})
        flow, _ = flow_from(melt, {}, say, Neighbour("", flow))
        refuse_beyond(f"flow of index {index:g}", flow_estimates(melt, flow))
        lines = streamlines_stage(melt, {"flow": flow}, say)
        refuse_beyond(f"streamlines of index {index:g}", streamline_estimates(melt, lines))
        yield flow, lines


def _thinned(
    parameters: Parameters, inputs: Inputs, model: FiberModel, law: PowerLaw
) -> FiberModel:
    """Return a fiber in a melt that thins."""
    table = thinning_response(parameters, inputs, model.name, law)
    here = Parameters({**parameters, "fiber.model": model.name})
    refuse_beyond(
        f"{model.name} of index {law.index:g}", response_estimates(here, table.to_arrays())
    )
    return replace(model, thinning=table)


def _on_fibers(
    parameters: Parameters,
    newtonian: FiberModel,
    thinned: FiberModel,
    law: PowerLaw,
    first: xr.Dataset,
    lines: xr.Dataset,
) -> dict[str, Any]:
    """Return what one model of a fiber sees in one melt, by cause, and its turn in simple shear."""
    rate = parameters["thinning.rate"]
    stress = float(law.stress_at(rate))
    if thinned.thinning is None:
        melt: Viscosity = stress / rate
        causes = [(lines, newtonian, melt)] * len(CAUSES)
        error = 0.0
    else:
        melt, local = law, LocalViscosity(law)
        causes = [(lines, thinned, melt), (lines, newtonian, local), (first, thinned, melt)]
        error = thinned.thinning.pressure_error
    seen = [_in_swell(parameters, *cause) for cause in causes]
    turn = orbit(thinned.in_plane, rate, stress / rate if thinned.thinning is None else law)
    none = float("nan")
    return {
        "lowest": np.stack([lowest for lowest, _ in seen]),
        "bound": np.stack([bound for _, bound in seen]),
        "period": none if turn.period is None else turn.period * rate,
        "stall_angle": none if turn.stall_angle is None else turn.stall_angle,
        "peak": turn.max_pressure / stress,
        "peak_error": error * turn.max_pressure / stress,
    }


def _in_swell(
    parameters: Parameters, lines: xr.Dataset, model: FiberModel, melt: Viscosity
) -> tuple[Array, Array]:
    """Return the lowest pressures from the exit to the end of the swell [Pa, gauge], (streamline,).

    The mean over the initial angles of what each fiber meets, and that of any direction.
    """
    path = stored_path(lines)
    angles = np.asarray(parameters["fiber.initial_angles"])
    motion = follow(path, model.turning, angles, parameters["numerics.angle_tolerance"])
    on_fibers = surface_pressure(path, model.in_plane, melt, motion).lowest
    bound = pressure_bounds(path, model.in_plane, melt).lowest
    here = locations(path, stored_zones(lines))[SWELL]
    own = lines["pressure"].to_numpy()
    each = np.min(own[:, None, :] + on_fibers, axis=-1, where=here[:, None, :], initial=np.inf)
    return each.mean(axis=-1), np.min(own + bound, axis=-1, where=here, initial=np.inf)
