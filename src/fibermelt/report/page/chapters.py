"""Sections at the end of the report: numbers, cost, versions, sources."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.report.kit.tables import Column, measured, number, sized, table
from fibermelt.report.page.account import parameters
from fibermelt.report.page.sources import Source, sources_of, written

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "FLOW",
    "cost",
    "files",
    "listed_sources",
    "listed_versions",
    "numbers",
    "sources",
    "versions",
]

MM, MPA = 1e3, 1e-6
"""Millimetres in a metre, megapascals in a pascal."""

FLOW = (
    ("Bead height", "bead_height", MM, "mm"),
    ("Inlet pressure", "inlet_pressure", MPA, "MPa"),
    ("Contact point, from the nozzle's axis", "contact_point", MM, "mm"),
    ("Heel, the melt's foremost point upstream", "heel", MM, "mm"),
    ("Flux error at the outlet, of the inlet's flux", "mass_imbalance", 1.0, ""),
    ("Flow through the free surface, in bed speeds", "kinematic_residual", 1.0, ""),
    ("Newton steps, all meshes together", "newton_steps", 1, ""),
    ("Unknowns of the flow", "unknowns", 1, ""),
    ("Triangles of the mesh", "elements", 1, ""),
)
"""What is told of the flow: words, name in the summary, factor and unit on the page."""


def numbers(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the numbers of fibers in the bead, with their units and error estimates."""
    quantity = (Column("Quantity", is_text=True), Column("Value"), Column("Unit", is_text=True))
    flow = [
        (words, _with_error(results, name, summary["flow"][name], factor), unit)
        for words, name, factor, unit in FLOW
        if name in summary["flow"]
    ]
    return Markup().join(
        [
            table("The flow, ± estimated error", quantity, flow) if flow else Markup(),
            table("The fiber, ± estimated error", quantity, _fiber(summary["cell"])),
            _lines(summary),
        ]
    )


def _with_error(results: xr.Dataset, name: str, value: float, factor: float) -> str:
    if isinstance(value, int):
        return number(value)
    error = results.get(f"{name}_error")
    return measured(factor * value, math.nan if error is None else factor * float(error))


def _fiber(cell: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    error = cell.get("error_estimate") or {}
    stall = cell["stall_angle"]
    tip = cell["tip_pressure"]
    size = cell["domain_size"]
    return [
        ("Aspect ratio", number(cell["aspect_ratio"]), ""),
        ("Domain-size factor M", "unbounded" if size is None else number(size), ""),
        ("Shape factor B", _estimated(cell["shape_factor"], error.get("shape_factor")), ""),
        (
            "Angle to simple shear at which it stalls",
            "it tumbles" if stall is None else number(math.degrees(stall)),
            "" if stall is None else "°",
        ),
        (
            "Largest surface pressure in simple shear",
            _estimated(
                tip, None if error.get("tip_pressure") is None else tip * error["tip_pressure"]
            ),
            "viscosity × shear rate",
        ),
        *_in_its_melt(cell),
        (
            "Unknowns of the cell",
            number(cell["unknowns"]) if cell["unknowns"] else "closed form",
            "",
        ),
    ]


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


def _estimated(value: float, error: float | None) -> str:
    return number(value) if error is None else measured(value, error)


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
