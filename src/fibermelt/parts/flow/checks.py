"""What a study may not say of its flow, before it is computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.errors import ConfigError
from fibermelt.parts.flow.config import Flow, Streamlines
from fibermelt.parts.flow.field_table import ImportedField
from fibermelt.parts.flow.paths_table import STATIONS, Paths

if TYPE_CHECKING:
    from fibermelt.engine.tables import Tables

__all__ = ["OF_DEPOSITION", "refuse_sources"]

OF_DEPOSITION = "of the deposition flow"
"""Trait of parts about the paper's bead, its nozzle and its mesh."""


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
