"""Sections at the end of the report: numbers, cost, versions, sources."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.engine.quantities import Quantity, with_error
from fibermelt.parts.bead.quantities import QUANTITIES as FIBER
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW
from fibermelt.report.kit.tables import Column, meanings, measured, number, printed, sized, table
from fibermelt.report.page.account import parameters
from fibermelt.report.page.sources import Source, sources_of, written
from fibermelt.units import MPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "cost",
    "files",
    "listed_sources",
    "listed_versions",
    "numbers",
    "sources",
    "versions",
]

CELL = ("aspect_ratio", "domain_size", "shape_factor", "stall_angle", "tip_pressure")
"""What is told of the fiber."""

COLUMNS = (Column("Quantity", is_text=True), Column("Value"), Column("Unit", is_text=True))


def numbers(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the numbers of fibers in the bead, with their units and error estimates."""
    flow = [one for name, one in FLOW.items() if name in summary["flow"]]
    fiber = [FIBER[name] for name in CELL]
    unknowns = [FIBER["cell_unknowns"]] if summary["cell"]["unknowns"] else []
    in_its_melt = _in_its_melt(summary["cell"])
    rows = [*_rows(results, fiber), *in_its_melt, *_rows(results, unknowns)]
    return Markup().join(
        [
            table("The flow, ± estimated error", COLUMNS, _rows(results, flow)) if flow else "",
            table("The fiber, ± estimated error", COLUMNS, rows),
            meanings((one.title, one.meaning) for one in (*flow, *fiber, *unknowns)),
            _lines(summary),
        ]
    )


def _rows(results: xr.Dataset, quantities: Iterable[Quantity]) -> list[tuple[str, str, str]]:
    """Return quantities of the results as rows: title, value ± error, unit."""
    rows = []
    for one in quantities:
        value, error = with_error(results, one.name, FLOW | FIBER)
        unit = "" if math.isnan(value) else one.shown_unit
        rows.append((one.title, printed(one.written(value, error)), unit))
    return rows


def _in_its_melt(cell: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return what a fiber answers in a melt that thins; what is beside it is of a Newtonian one."""
    if "thinning" not in cell:
        return []
    known = cell["thinning"]
    ends = [
        "at any rate" if known["rates"][0] == known["rates"][1] else f"{side} {number(rate, 2)} 1/s"
        for side, rate in zip(("up to", "from"), known["rates"], strict=True)
    ]
    rows = []
    error = known["error_estimate"]
    for end, factor, largest in zip(
        ends, known["shape_factors"], known["largest_pressures"], strict=True
    ):
        rows += [
            (f"As the melt thins, {end}: shape factor", measured(factor, error["spin"]), ""),
            (
                f"As the melt thins, {end}: largest surface pressure in simple shear",
                measured(largest, largest * error["pressure"]),
                "viscosity there × shear rate",
            ),
        ]
    return rows[:2] if len(set(ends)) == 1 else rows


def _lines(summary: Mapping[str, Any]) -> Markup:
    """Return the lowest surface pressures by streamline, above mid-capillary and below it."""
    found = {
        (item["streamline"], item["location"]): item
        for item in summary["extremes"]
        if item["kind"] == "min"
    }
    locations = sorted({location for _, location in found})
    word = "streamline" if "bead_height" in summary["flow"] else "path"
    columns = [Column(word.capitalize(), is_text=True), Column("Transit", "s")]
    for location in locations:
        columns += [Column(f"Loc. {location}, {what}", "MPa") for what in ("mean", "worst")]
    rows = []
    # Not by what is met near a singular corner, which has no limit.
    size = max(
        (
            abs(end)
            for line in summary["streamlines"]
            for location in locations
            for end in found[line["index"], location]["bounds"]
            if not line["near_singularity"]
        ),
        default=max(abs(item["mean"]) for item in found.values()),
    )
    for line in summary["streamlines"]:
        name = str(line["index"]) + ("*" if line["near_singularity"] else "")
        cells = [name, number(line["transit_time"], 3)]
        for location in locations:
            item = found[line["index"], location]
            cells += [
                sized(MPA * pressure, MPA * size, 4)
                for pressure in (item["mean"], min(item["bounds"]))
            ]
        rows.append(cells)
    note = Markup(
        "<p>Lowest pressure on the fiber's surface less the melt's own: {}. The mean runs over "
        "the initial angles; the "
        "worst is a bound: no fiber, however it entered, sees less. * passes close to a singular "
        "corner, where refining the mesh gives no limit.</p>\n"
    ).format(
        "Loc. 1 lies above the middle of the capillary, Loc. 2 below it"
        if any(locations)
        else "Loc. 0 is the whole way"
    )
    return table(f"Lowest pressure by {word}", columns, rows) + note


def cost(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the wall time that each stage took when it was computed."""
    del results
    rows = [(name, f"{seconds:.1f}") for name, seconds in summary["cost"].items()]
    note = Markup(
        "<p>Wall time of each stage when it was computed; a reused stage is not in the total.</p>\n"
    )
    return note + table("Wall time", (Column("Stage", is_text=True), Column("Time", "s")), rows)


BESIDE = (
    ("results.nc", "", "every number of this page and all that is drawn, with units"),
    ("summary.json", "", "the numbers that a script asks for"),
    ("config.toml", "", "the study, with every default: it runs again to the same"),
    ("flow.vtu", "bead", "the flow, for ParaView"),
    ("export/", "", "after fibermelt export: tables (CSV), and streamlines for ParaView"),
)
"""What lies beside the page: its name, the part of a study that it is of, and what it is."""


def files(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return links to what lies beside the page in its folder."""
    del summary
    values = parameters(results)
    is_solved = values["flow.source"] == "deposition"
    parts = values["study.parts"] if is_solved else ()
    rows = [
        (Markup('<a href="{0}">{0}</a>').format(name), what)
        for name, part, what in BESIDE
        if not part or part in parts
    ]
    columns = (Column("File", is_text=True), Column("What it is", is_text=True))
    return table("Beside this page, in its folder", columns, rows)


def versions(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the versions of what computed the results."""
    del summary
    found = json.loads(results.attrs.get("software", "{}"))
    return listed_versions("Software that wrote the results", found)


def listed_versions(caption: str, found: Mapping[str, str]) -> Markup:
    """Return versions by their software; nothing if none are known."""
    columns: Sequence[Column] = (Column("Software", is_text=True), Column("Version", is_text=True))
    return table(caption, columns, [*found.items()]) if found else Markup()


def sources(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the sources that the study makes use of, and their BibTeX."""
    del summary
    return listed_sources(sources_of(parameters(results)))


def listed_sources(found: Sequence[tuple[Source, str]]) -> Markup:
    """Return sources, each with what comes from it, and their BibTeX."""
    listed: Iterable[Markup] = (
        Markup('<li id="source-{}">{} <span class="use">For {}.</span></li>\n').format(
            source.key, written(source), what
        )
        for source, what in found
    )
    bibtex = "\n\n".join(source.bibtex for source, _ in found)
    return Markup(
        '<ul class="sources">\n{}</ul>\n<details><summary>BibTeX</summary>\n'
        '<pre tabindex="0" aria-label="BibTeX of the sources">{}</pre></details>\n'
    ).format(Markup().join(listed), bibtex)
