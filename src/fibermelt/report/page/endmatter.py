"""Sections at the end of the report: files, cost, versions, sources."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.flow.config import SOLVED
from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table
from fibermelt.report.page.sources import sources_of
from fibermelt.report.page.what_was_run import parameters

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ENDMATTER", "versions_table"]

BESIDE = (
    ("results.nc", "", "every number of this page and all that is drawn, with units"),
    ("summary.json", "", "the numbers that a script asks for"),
    ("config.toml", "", "the study, with every default: it runs again to the same"),
    ("flow.vtu", "bead", "the flow, for ParaView"),
    ("export/", "", "after fibermelt export: tables (CSV), and streamlines for ParaView"),
)
"""What lies beside the page: its name, the part of a study that it is of, and what it is."""


@section("files", "Files", place=120)
def files(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return what lies beside the page in its folder."""
    del summary
    values = parameters(results)
    parts = values["study.parts"] if values["flow.source"] in SOLVED else ()
    return {
        "columns": (Column("File", is_text=True), Column("What it is", is_text=True)),
        "files": [(name, what) for name, part, what in BESIDE if not part or part in parts],
    }


@section("cost", "Cost", place=130, needs="cost")
def cost(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the wall time that each stage took when it was computed."""
    del results
    rows = [(name, f"{seconds:.1f}") for name, seconds in summary["cost"].items()]
    columns = (Column("Stage", is_text=True), Column("Time", "s"))
    return {"cost": Table("Wall time", columns, rows)}


@section("versions", "Versions", place=140)
def versions(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the versions of what computed the results."""
    del summary
    found = json.loads(results.attrs.get("software", "{}"))
    return {"versions": versions_table("Software that wrote the results", found)}


def versions_table(caption: str, found: Mapping[str, str]) -> Table:
    """Return versions by their software."""
    columns = (Column("Software", is_text=True), Column("Version", is_text=True))
    return Table(caption, columns, [*found.items()])


@section("sources", "Sources", place=150)
def sources(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sources that the study makes use of."""
    del summary
    return {"sources": sources_of(parameters(results))}


ENDMATTER = (files, cost, versions, sources)
"""What no part of a study has to tell."""
