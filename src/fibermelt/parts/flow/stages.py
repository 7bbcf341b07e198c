"""The flow's stages: the deposition flow, and the streamlines through it, as labelled data.

What loads the finite elements is imported where it is used.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Estimate, Inputs, Neighbour, Parameters, Say, Scaled
from fibermelt.flow.field import FlowField
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.vtu import write_vtu
from fibermelt.parts.flow.config import FLOW_NUMERICS
from fibermelt.parts.flow.imported import along_paths, paths_of
from fibermelt.parts.flow.quantities import QUANTITIES
from fibermelt.parts.flow.strand import FINER as FINER_STRAND
from fibermelt.parts.flow.strand import stored_bead, strand_paths
from fibermelt.parts.melt.melt import LAW, NEWTONIAN, law_of, thins
from fibermelt.parts.melt.quantities import QUANTITIES as MELT

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.flow.deposition import FlowSolution
    from fibermelt.flow.start import StartShape

__all__ = [
    "flow_estimates",
    "flow_from",
    "flow_scaled",
    "flow_stage",
    "start_from",
    "streamline_estimates",
    "streamlines_stage",
    "write_fields",
]

SCALARS = (
    "bead_height",
    "inlet_pressure",
    "contact_point",
    "heel",
    "mass_imbalance",
    "kinematic_residual",
    "newton_steps",
    "unknowns",
    "elements",
)
ERRORS = ("contact_point", "heel", "inlet_pressure")
FIELDS = (
    "velocity",
    "pressure",
    "gradient",
    "stream_function",
    "viscosity",
    "gradient_error",
)

HEEL_BOUND = 0.05
"""Largest estimated error of the heel [widths]: where it lies the surface is steep, so it goes with
the whole line, and the lip's edge, more than the contact point does (default mesh 5e-4, the
coarsest of the tests 0.017)."""

PRESSURE_BOUND = 0.05
"""Largest estimated error of the inlet pressure over that pressure (2e-4; 7e-3)."""

FLUX_BOUND = 0.01
"""Largest error of the flux at the outlet, and largest mean ``u.n`` over the free surfaces in bed
speeds: a hundredth of what passes (3e-10 and 2e-5; 1e-6 and 1e-3)."""

GRADIENT_BOUND = 0.25
"""Largest estimated error of the gradient, over the shear rate, both at the median of the nodes: at
the corners and the lips neither has a bound (2e-3; 0.03)."""

DRIFT_BOUND = 0.01
"""Largest drift of the stream function along a streamline, over the flux: a fifth of what flows
between two of the paper's 22 (1e-5; 3e-3)."""

SCALE = (101.6e-3, 817.0)
"""Speed of the bed [m/s] and viscosity at ``V/W`` [Pa s] of a flow that is solved: the paper's."""

SAME_DIGITS = 12
"""Significant digits in which flows agree that are one: three less than quotients have."""

LAW_RATES = (1e-6, 1e8, 281)
"""Rates [1/s] between which a law is drawn, and how many."""

FINER = "take shorter edges in numerics, such as lip_edge and contact_edge, or a higher flow_order"


def _problem(parameters: Parameters) -> Deposition:
    """Return the deposition problem of a study."""
    flow = parameters.section("flow")
    flow.pop("source")
    speeds = {name: flow.pop(name) for name in ("inlet_speed", "bed_speed")}
    return Deposition(nozzle=Nozzle(**flow), melt=cast("Any", law_of(parameters)), **speeds)


def start_from(flow: xr.Dataset) -> StartShape:
    """Return what a neighbouring case's flow may start from, of a flow that was stored.

    Raises
    ------
    ConfigError
        If the surfaces in it are none.
    """
    from fibermelt.flow.start import StartShape  # noqa: PLC0415  loads the finite elements

    return StartShape(flow["upstream_surface"].to_numpy(), flow["downstream_surface"].to_numpy())


def flow_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Solve the deposition flow from cold."""
    return _stored(_solved(parameters, say, None))


def _solved(parameters: Parameters, say: Say, start: StartShape | None) -> FlowSolution:
    """Return the deposition flow of a study, solved from cold or from surfaces.

    The start is no part of the stage's key: it changes the answer by less than its stated error.
    """
    from fibermelt.flow.deposition import solve_deposition  # noqa: PLC0415  loads the finite elements

    numerics = FlowNumerics(
        **{key.removeprefix("numerics."): parameters[key] for key in FLOW_NUMERICS}
    )
    return solve_deposition(_problem(parameters), numerics, progress=say, start=start)


def flow_estimates(parameters: Parameters, flow: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of a flow, each with its bound."""
    from fibermelt.flow.deposition import LARGEST_ERROR  # noqa: PLC0415

    width = parameters["flow.capillary_width"]
    known = {name: float(flow[name]) for name in (*SCALARS, *(f"{name}_error" for name in ERRORS))}
    gradient_error = float(np.median(flow["node_gradient_error"]))
    shear_rate = float(np.median(_field(flow).shear_rate))
    bounds = {
        "contact_point_error": LARGEST_ERROR * width,
        "heel_error": HEEL_BOUND * width,
        "inlet_pressure_error": PRESSURE_BOUND * abs(known["inlet_pressure"]),
        "mass_imbalance": FLUX_BOUND,
        "kinematic_residual": FLUX_BOUND,
    }
    return (
        *(Estimate(name, known[name], bound, FINER) for name, bound in bounds.items()),
        Estimate("node_gradient_error", gradient_error, GRADIENT_BOUND * shear_rate, FINER),
    )


def flow_from(
    parameters: Parameters, inputs: Inputs, say: Say, neighbour: Neighbour
) -> tuple[xr.Dataset, bool]:
    """Solve the deposition flow from the surfaces of a neighbour, and tell if these led to it."""
    found = _solved(parameters, say, start_from(neighbour.data))
    return _stored(found), found.is_warm


def flow_scaled(parameters: Parameters) -> Scaled:
    """Return the flow of which another is a multiple, in the units of `SCALE`.

    Without inertia, gravity and surface tension the shape is decided by the nozzle, the ratio of
    the speeds, and the melt's law in units of width ``W``, bed speed ``V`` and viscosity at
    ``V/W``: flows of another Newtonian melt, of all viscosities by a factor, or of speeds and time
    constants together are one flow.
    """
    law, bed_speed = law_of(parameters), parameters["flow.bed_speed"]
    viscosity = float(law.viscosity_at(bed_speed / parameters["flow.capillary_width"]))
    speed, thickness = bed_speed / SCALE[0], viscosity / SCALE[1]
    name, constants = NEWTONIAN, {"viscosity": SCALE[1]}
    if not law.is_newtonian:
        name = parameters[f"{LAW}.name"]
        constants = law.scaled(1.0 / thickness, speed).constants()
    reference = {
        **parameters,
        **dict.fromkeys(key for key in parameters if key.startswith(f"{LAW}.")),
        f"{LAW}.name": name,
        **{f"{LAW}.{constant}": _rounded(value) for constant, value in constants.items()},
        "flow.inlet_speed": _rounded(parameters["flow.inlet_speed"] * SCALE[0] / bed_speed),
        "flow.bed_speed": SCALE[0],
    }
    stress = thickness * speed
    factors = {"m/s": speed, "1/s": speed, "m^2/s": speed, "Pa s": thickness, "Pa": stress}
    return Scaled(Parameters(reference), factors)


def _rounded(value: float) -> float:
    return float(f"{value:.{SAME_DIGITS}g}")


def _stored(solution: FlowSolution) -> xr.Dataset:
    """Return a flow as it is stored."""
    field = solution.field
    arrays: dict[str, Any] = {
        "node_x": field.points[:, 0],
        "node_y": field.points[:, 1],
        "cell_nodes": field.cells,
        "field_order": field.order,
        "upstream_surface": solution.upstream_surface,
        "downstream_surface": solution.downstream_surface,
    }
    arrays |= {f"node_{name}": getattr(field, name) for name in FIELDS}
    arrays |= {name: getattr(solution, name) for name in SCALARS}
    arrays |= {f"{name}_error": getattr(solution.error, name) for name in ERRORS}
    return labelled(arrays, QUANTITIES)


def _field(flow: xr.Dataset) -> FlowField:
    """Return the flow field that was stored."""
    return FlowField(
        order=int(flow["field_order"]),
        points=np.stack([flow["node_x"], flow["node_y"]], axis=-1),
        cells=flow["cell_nodes"].to_numpy(),
        **{name: flow[f"node_{name}"].to_numpy() for name in FIELDS},
    )


def _solution(parameters: Parameters, flow: xr.Dataset) -> FlowSolution:
    """Return the flow solution that was stored."""
    from fibermelt.flow.deposition import FlowError, FlowSolution  # noqa: PLC0415  as above

    return FlowSolution(
        problem=_problem(parameters),
        field=_field(flow),
        upstream_surface=flow["upstream_surface"].to_numpy(),
        downstream_surface=flow["downstream_surface"].to_numpy(),
        error=FlowError(**{name: flow[f"{name}_error"].item() for name in ERRORS}),
        **{name: flow[name].item() for name in SCALARS},
    )


def streamlines_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Trace the streamlines of equal flux, or return the paths of a flow from elsewhere."""
    if parameters["flow.source"] == "deposition-3d":
        found = strand_paths(parameters, inputs["strand"], say)
        return labelled(found | _law_curve(parameters), QUANTITIES | MELT)
    if parameters["flow.source"] != "deposition":
        return paths_of(parameters, inputs, say).assign(labelled(_law_curve(parameters), MELT))

    from fibermelt.flow.streamlines import trace_streamlines  # noqa: PLC0415

    count, points = parameters["streamlines.count"], parameters["streamlines.points"]
    say(f"tracing {count} lines of {points} points")
    lines = trace_streamlines(_solution(parameters, inputs["flow"]), count=count, points=points)

    def stacked(name: str) -> Any:
        return np.stack([np.asarray(getattr(line, name)) for line in lines])

    return labelled(
        {
            **along_paths([line.history for line in lines]),
            "streamline": stacked("index"),
            "flux_fraction": stacked("flux_fraction"),
            "path_end": ["outlet"] * len(lines),
            "stream_function": stacked("stream_function"),
            "gradient_error": stacked("gradient_error"),
            "stream_function_drift": stacked("drift"),
            "corner_distance": stacked("corner_distance"),
            "near_singularity": stacked("near_singularity").astype(np.int8),
            "zone": np.arange(1, 4),
            "zone_time": stacked("zone_time"),
            **_law_curve(parameters),
        },
        QUANTITIES | MELT,
    )


def _law_curve(parameters: Parameters) -> dict[str, Any]:
    """Return the viscosity of a melt that thins over its rates, to be drawn."""
    if not thins(parameters):
        return {}
    rate = np.geomspace(*LAW_RATES)
    return {"law_rate": rate, "law_viscosity": law_of(parameters).viscosity_at(rate)}


def streamline_estimates(parameters: Parameters, lines: xr.Dataset) -> tuple[Estimate, ...]:
    """Return the errors of streamlines, each with its bound.

    The gradient's is that of the lines which pass no sharp corner.
    """
    if "gradient_error" not in lines:
        return ()
    regular = lines["near_singularity"].to_numpy() == 0
    error, rate = (
        np.median(lines[name].to_numpy()[regular], axis=-1)
        for name in ("gradient_error", "shear_rate")
    )
    share = float(np.max(error / rate, initial=0.0))
    if parameters["flow.source"] == "deposition-3d":
        return (Estimate("gradient_error over shear_rate", share, GRADIENT_BOUND, FINER_STRAND),)
    if parameters["flow.source"] != "deposition":
        cure = "take a file on a finer mesh, or one that has the gradient (field.gradient)"
        return (Estimate("gradient_error over shear_rate", share, GRADIENT_BOUND, cure),)
    drift = float(lines["stream_function_drift"].max())
    return (
        Estimate("gradient_error over shear_rate", share, GRADIENT_BOUND, FINER),
        Estimate("stream_function_drift", drift, DRIFT_BOUND, FINER),
    )


def write_fields(results: xr.Dataset, folder: Path) -> None:
    """Write the flow for ParaView; one that was given is there already."""
    if "cell_nodes" in results:
        write_vtu(_field(results), folder / "flow.vtu")
    elif "strand_cells" in results:
        write_vtu(stored_bead(results), folder / "flow.vtu")
