"""The planar answer for the equivalent slot, as a stage: its flow, its streamlines, its fibers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say, refuse_beyond
from fibermelt.errors import ConfigError
from fibermelt.parts.bead.stages import stored_model, stored_path, stored_zones
from fibermelt.parts.flow.config import Flow
from fibermelt.parts.flow.stages import (
    flow_estimates,
    flow_stage,
    streamline_estimates,
    streamlines_stage,
)
from fibermelt.parts.melt.melt import viscosity_of
from fibermelt.parts.plane.quantities import QUANTITIES
from fibermelt.parts.process.slot import SLOT
from fibermelt.voids import ATMOSPHERE, growth_exponent

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.engine.tables import Tables

    Array = NDArray[np.float64]

__all__ = ["plane_stage", "refuse_without_bead", "slot_of"]

OF_FLOW = ("bead_height", "inlet_pressure", "heel")
"""What is told of the planar flow, with its error where it has one."""


def refuse_without_bead(study: Tables) -> None:
    """Refuse the part in a study whose flow is no bead in space (`ConfigError`)."""
    source = study.table(Flow).source
    if "plane" in study.study.parts and source != "deposition-3d":
        msg = (
            f'study.parts: "plane" sets a slot beside a bead in space, and flow.source = '
            f'"{source}": say flow.source = "deposition-3d", or leave the part away'
        )
        raise ConfigError(msg)


def slot_of(parameters: Parameters) -> Parameters:
    """Return a study's parameters with the slot that stands for its round nozzle.

    As `fibermelt.parts.process.slot` has it: three quarters as wide as the capillary, so that a
    Newtonian melt has the same rate at the wall at the same mean speed. The lengths stay.
    """
    diameter, inlet = (parameters[f"flow.{name}_width"] for name in ("capillary", "inlet"))
    slot, taper = SLOT * diameter, inlet / diameter
    return Parameters(
        {
            **parameters,
            "flow.source": "deposition",
            "flow.capillary_width": slot,
            "flow.inlet_width": taper * slot,
            "flow.inlet_speed": taper * parameters["flow.inlet_speed"],
        }
    )


def plane_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve the slot's flow, and find what the study's fiber meets in it and in the bead."""
    slot = slot_of(parameters)
    say(f"a slot {1e3 * slot['flow.capillary_width']:.4g} mm wide")
    flow = flow_stage(slot, {}, say)
    refuse_beyond("flow in the slot", flow_estimates(slot, flow))
    lines = streamlines_stage(slot, {"flow": flow}, say)
    refuse_beyond("streamlines in the slot", streamline_estimates(slot, lines))
    model, path = stored_model(inputs["cell"]), stored_path(lines)
    below = model.bounds(path, viscosity_of(parameters)).lowest
    vapor = float(inputs["voids"]["void_vapor_pressure"]) if "voids" in inputs else None
    around = inputs["streamlines"]
    bound = inputs["motion"]["bound_lowest"].transpose("streamline", "point").to_numpy()
    told: dict[str, Any] = {name: float(flow[name]) for name in OF_FLOW}
    told |= {f"{name}_error": float(flow[f"{name}_error"]) for name in ("heel", "inlet_pressure")}
    return labelled(
        {
            **{f"plane_{name}": value for name, value in told.items()},
            "plane_slot": slot["flow.capillary_width"],
            **{f"plane_{name}": value for name, value in _on_fibers(lines, below, vapor).items()},
            **{f"space_{name}": value for name, value in _on_fibers(around, bound, vapor).items()},
        },
        QUANTITIES,
    )


def _on_fibers(lines: xr.Dataset, below: Array, vapor: float | None) -> dict[str, float]:
    """Return what fibers in their worst direction meet: the lowest pressure, and the exponent.

    Over paths that pass no sharp corner: the lowest of all, above the air's [Pa], and the mean
    growth exponent, all paths having the same flux; NaN where nothing is known.
    """
    regular = lines["near_singularity"].to_numpy() == 0
    if not regular.any():
        return {"lowest_pressure": np.nan, "exponent": np.nan}
    gauge = (lines["pressure"].to_numpy() + below)[regular]
    found = {"lowest_pressure": float(gauge.min()), "exponent": np.nan}
    if vapor is not None:
        zones = stored_zones(lines)
        until = np.inf if zones is None else zones[regular, -1]
        time, viscosity = (lines[name].to_numpy()[regular] for name in ("time", "viscosity"))
        exponent = growth_exponent(time, gauge + ATMOSPHERE, vapor, viscosity, until)
        found["exponent"] = float(exponent.value.mean())
    return found
