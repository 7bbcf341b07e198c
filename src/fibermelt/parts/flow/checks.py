"""What a study may not say of its flow, before it is computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.errors import ConfigError
from fibermelt.flow.problem import LOWEST_GAP
from fibermelt.parts.flow.config import Flow, Streamlines
from fibermelt.parts.flow.field_table import ImportedField
from fibermelt.parts.flow.paths_table import STATIONS, Paths
from fibermelt.units import MM

if TYPE_CHECKING:
    from fibermelt.engine.tables import Tables

__all__ = ["OF_DEPOSITION", "flow_notes", "refuse_sources"]

OF_DEPOSITION = "of the deposition flow"
"""Trait of parts about the paper's bead, its nozzle and its mesh."""

HIGHEST_GAP = 1.6
"""Gap over the height of the bead above which the surface may pass under the bed: so it does of a
bead a third as high as the capillary is wide; of one as high as it above 2.7."""


def refuse_sources(study: Tables) -> None:
    """Refuse a flow without its file, a file without its flow, and what has no answer there.

    Raises
    ------
    ConfigError
        The key, and the way out.
    """
    source, paths = study.table(Flow).source, study.table(Paths)
    given = {"field": study.table(ImportedField).file, "histories": paths.file}
    keys = {"field": "field.file", "histories": "paths.file"}
    for name, file in given.items():
        if name == source and not file:
            msg = f'{keys[name]}: missing: flow.source = "{source}" reads the flow from it'
            raise ConfigError(msg)
        if name != source and file:
            msg = (
                f'{keys[name]} = "{file}": is not read with flow.source = "{source}": say '
                f'flow.source = "{name}", or leave it away'
            )
            raise ConfigError(msg)
    default = Paths()
    read = {
        "field": tuple(Paths.model_fields),
        "histories": ("file", "content", *STATIONS),
        "deposition": ("file", "content"),
        "deposition-3d": ("file", "content"),
    }
    idle = [
        name
        for name in Paths.model_fields
        if name not in read[source] and getattr(paths, name) != getattr(default, name)
    ]
    if idle:
        msg = (
            f'paths.{idle[0]}: is not read with flow.source = "{source}": leave it away, or '
            'say flow.source = "field"'
        )
        raise ConfigError(msg)
    points = study.table(Streamlines).points
    if source == "histories" and points != Streamlines().points:
        msg = (
            f'streamlines.points = {points}: is not read with flow.source = "histories": a '
            "path keeps the points that its table gives it; leave it away"
        )
        raise ConfigError(msg)
    known = [part.name for part in study.asked if OF_DEPOSITION in part.traits]
    if source != "deposition" and known:
        msg = (
            f'study.parts: "{known[0]}" is about the deposition flow, and flow.source = '
            f'"{source}": leave it away'
        )
        raise ConfigError(msg)


def flow_notes(study: Tables) -> list[str]:
    """Tell of a gap at which the deposition flow will hardly have a steady surface."""
    flow = study.table(Flow)
    ratio = flow.gap / flow.bead_height
    if flow.source != "deposition" or LOWEST_GAP <= ratio <= HIGHEST_GAP:
        return []
    beyond, way = (
        (f"below {LOWEST_GAP:g} the melt climbs the nozzle", "raise flow.gap or flow.bed_speed")
        if ratio < LOWEST_GAP
        else (
            f"above {HIGHEST_GAP:g} for a bead a third as high as the capillary is wide, and above "
            "2.7 for one as high as it, the surface passes under the bed",
            "lower flow.gap or flow.bed_speed",
        )
    )
    return [
        f"the gap is {ratio:.3g} times the bead's height of {MM * flow.bead_height:.4g} mm: "
        f"{beyond}, and no steady surface may be found; {way}"
    ]
