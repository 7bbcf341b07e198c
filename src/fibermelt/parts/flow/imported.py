"""The stages of a flow that is given: another solver's field, and the paths through it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Inputs, Parameters, Say
from fibermelt.errors import ConfigError
from fibermelt.fields import paths as through
from fibermelt.fields.field import Field
from fibermelt.fields.mapping import FieldMap
from fibermelt.fields.paths import trace_field
from fibermelt.fields.reading import read_field
from fibermelt.parts.flow.given import refuse_changed
from fibermelt.parts.flow.paths_table import STATIONS
from fibermelt.parts.flow.quantities import QUANTITIES
from fibermelt.parts.melt.melt import law_of
from fibermelt.path_table import as_many_points, read_paths
from fibermelt.units import parse_plane

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.fields.paths import FieldPath, Seeds
    from fibermelt.history import FlowHistory

__all__ = [
    "along_paths",
    "field_arrays",
    "field_stage",
    "paths_of",
    "stations",
    "stored_field",
    "traced",
]

FIELD_VALUES = (
    "points",
    "cells",
    "velocity",
    "gradient",
    "gradient_error",
    "divergence",
    "near_wall",
    "near_edge",
    "cut",
)
FLAGS = ("field_near_wall", "field_near_edge", "field_cut")
OPTIONAL = ("pressure", "viscosity", "temperature")


def field_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Read another solver's field, and recover its velocity gradient."""
    wanted = parameters.section("field")
    file, content = wanted.pop("file"), wanted.pop("content")
    refuse_changed("field", file, content)
    field = read_field(file, FieldMap(**wanted))
    say(f"{len(field.points)} points, {len(field.cells)} cells, {field.geometry}")
    for note in field.notes:
        say(note)
    return labelled(field_arrays(field), QUANTITIES)


def field_arrays(field: Field) -> dict[str, Any]:
    """Return a field as it is stored."""
    arrays: dict[str, Any] = {
        f"field_{name}": np.asarray(getattr(field, name)) for name in FIELD_VALUES
    }
    for name in FLAGS:
        arrays[name] = arrays[name].astype(np.int8)
    known = [name for name in OPTIONAL if getattr(field, name) is not None]
    return {
        **arrays,
        **{f"field_{name}": getattr(field, name) for name in known},
        "field_geometry": field.geometry,
        "field_notes": "\n".join(field.notes),
    }


def stored_field(data: xr.Dataset) -> Field:
    """Return the field that was stored."""
    values: dict[str, Any] = {name: data[f"field_{name}"].to_numpy() for name in FIELD_VALUES}
    values |= {name: values[name] != 0 for name in ("near_wall", "near_edge", "cut")}
    optional: dict[str, Any] = {
        name: data[f"field_{name}"].to_numpy() if f"field_{name}" in data else None
        for name in OPTIONAL
    }
    return Field(
        geometry=cast("Any", str(data["field_geometry"].item())),
        notes=tuple(str(data["field_notes"].item()).split("\n")),
        **values,
        **optional,
    )


def paths_of(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Return the paths of a flow that is not solved here: traced through its field, or as read."""
    if parameters["flow.source"] == "histories":
        histories, arrays = _read_histories(parameters, say)
    else:
        histories, arrays = _trace(parameters, inputs, say)
    return labelled(arrays | stations(parameters, histories, arrays), QUANTITIES)


def _trace(
    parameters: Parameters, inputs: Inputs, say: Say
) -> tuple[Sequence[FlowHistory], dict[str, Any]]:
    """Trace paths through a field."""
    field, points = stored_field(inputs["field"]), parameters["streamlines.points"]
    seeds = _seeds(parameters, field)
    say(f"tracing {len(seeds.points)} paths of {points} points")
    law, longest = cast("Any", law_of(parameters)), parameters["paths.longest"]
    paths = trace_field(field, seeds, points, law, longest)
    ends = [path.end for path in paths]
    say(", ".join(f"{ends.count(end)} end by {end}" for end in sorted(set(ends))))
    return [path.history for path in paths], traced(paths)


def _seeds(parameters: Parameters, field: Field) -> Seeds:
    """Return where a study has its paths begin."""
    wanted = parameters.section("paths")
    start, stop = np.array(wanted["from"]), np.array(wanted["to"])
    if wanted["seeds"] == "points":
        return through.point_seeds(field, np.reshape(wanted["points"], (-1, 3)))
    if wanted["seeds"] == "line":
        return through.line_seeds(field, start, stop, wanted["count"])
    if not start.size:
        section = through.inflow_section(field)
    elif field.geometry == "spatial":
        section = through.patch_section(field, start, stop)
    else:
        section = through.line_section(field, start, stop)
    return through.flux_seeds(field, section, wanted["count"])


def traced(paths: Sequence[FieldPath]) -> dict[str, Any]:
    """Return traced paths as they are stored."""
    return {
        **along_paths([path.history for path in paths]),
        "gradient_error": np.stack([path.gradient_error for path in paths]),
        "near_singularity": np.array([path.near_singularity for path in paths], dtype=np.int8),
        "path_end": [path.end for path in paths],
        "path_divergence": [path.divergence for path in paths],
        "path_notes": ["; ".join(path.told) for path in paths],
    }


def stations(
    parameters: Mapping[str, Any], histories: Sequence[FlowHistory], arrays: Mapping[str, Any]
) -> dict[str, Any]:
    """Return when paths reach the stations that a study names, NaN where one does not.

    Raises
    ------
    ConfigError
        If no path reaches a station, or one reaches them in another order than it should.
    """
    texts = {f"paths.{name}": parameters[f"paths.{name}"] for name in STATIONS}
    planes = {name: parse_plane(text) for name, text in texts.items() if text}
    if not planes:
        return {}
    times: dict[str, Any] = {}
    for name, (axis, place) in planes.items():
        if axis == 2 and "z" not in arrays:
            msg = f'{name} = "{texts[name]}": the paths are planar: give a plane across x or y'
            raise ConfigError(msg)
        times[name] = np.array([history.time_across(axis, place) for history in histories])
        if np.isnan(times[name]).all():
            along = np.stack([history.position[:, axis] for history in histories])
            msg = (
                f'{name} = "{texts[name]}": no path crosses it: they lead from {along.min():.4g} '
                f"to {along.max():.4g} m along {'xyz'[axis]}"
            )
            raise ConfigError(msg)
    for first, second in combinations(times, 2):
        early = np.flatnonzero(times[second] < times[first])
        if early.size:
            msg = (
                f'{second} = "{texts[second]}": path {arrays["streamline"][early[0]]} is there '
                f'before it reaches {first} = "{texts[first]}": exchange them'
            )
            raise ConfigError(msg)
    when = np.stack(list(times.values()), axis=-1)
    missed = [
        [f"does not reach {name}" for name, is_lost in zip(times, lost, strict=True) if is_lost]
        for lost in np.isnan(when)
    ]
    notes = [
        "; ".join(filter(None, [note, *more]))
        for note, more in zip(arrays["path_notes"], missed, strict=True)
    ]
    zones = [k for k, name in enumerate(texts, 1) if name in times]
    return {"zone": zones, "zone_time": when, "path_notes": notes}


def _read_histories(
    parameters: Parameters, say: Say
) -> tuple[Sequence[FlowHistory], dict[str, Any]]:
    """Read a table of paths."""
    file = parameters["paths.file"]
    refuse_changed("paths", file, parameters["paths.content"])
    table = read_paths(file)
    histories = as_many_points(table.histories)
    say(f"{len(histories)} paths of {len(histories[0])} points")
    for note in table.notes:
        say(note)
    law = law_of(parameters)
    own = [
        history.viscosity if history.viscosity is not None else law.viscosity_at(history.shear_rate)
        for history in histories
    ]
    return histories, {
        **along_paths(histories),
        "streamline": list(table.numbers),
        "viscosity": np.stack(own),
        "near_singularity": np.zeros(len(histories), dtype=np.int8),
        "path_end": ["file"] * len(histories),
        "path_divergence": list(table.divergence),
        "field_notes": "\n".join(table.notes),
    }


def along_paths(histories: Sequence[FlowHistory]) -> dict[str, Any]:
    """Return what is met along paths by the names of its variables, and how well it fits."""
    planar = all(history.planar for history in histories)
    found = [history.consistency() for history in histories]

    def along(name: str) -> Any:
        return np.stack([getattr(history, name) for history in histories])

    position, velocity = along("position"), along("velocity")
    space = {} if planar else {"z": position[..., 2], "w": velocity[..., 2]}
    known = histories[0].quantities
    number = np.arange(1, len(histories) + 1)
    return {
        "streamline": number,
        "flux_fraction": (number - 0.5) / len(number),
        "time": along("time"),
        "x": position[..., 0],
        "y": position[..., 1],
        "u": velocity[..., 0],
        "v": velocity[..., 1],
        **space,
        "pressure": along("pressure"),
        "gradient": along("plane_gradient" if planar else "gradient"),
        "shear_rate": along("shear_rate"),
        **({"viscosity": along("viscosity")} if "viscosity" in known else {}),
        **({"temperature": along("temperature")} if "temperature" in known else {}),
        "path_consistency": [max(one.transport, one.steadiness) for one in found],
        "path_coarseness": [one.coarseness for one in found],
        "path_notes": ["; ".join(one.told) for one in found],
    }
