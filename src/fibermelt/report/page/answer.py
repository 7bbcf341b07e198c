"""The answer in a few plain sentences: what was run, is there a risk, where, and what to do."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from fibermelt.paper.claims.section import counted, tally
from fibermelt.parts.bead.shapes import SHAPES
from fibermelt.parts.flow.figures.lines import line_word
from fibermelt.parts.flow.given import is_given
from fibermelt.parts.voids.summary import worst_line
from fibermelt.report.kit.tables import fixed, number, short, sized
from fibermelt.report.kit.templates import rendered
from fibermelt.report.page.what_was_run import parameters
from fibermelt.units import KPA, MM, MPA

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["answer"]


SOURCES = {"field": "another solver’s field", "histories": "a table"}
"""Where paths come from that were not traced through a flow of ours."""

PARTS = {
    "interaction": "from fiber content to the size of the cell",
    "orbits": "one fiber in simple shear",
    "dimensions": "a plane ellipse against a spheroid",
    "thinning": "what melts that thin do to bead and fibers",
    "claims": "the paper’s claims",
    "verification": "the verification ladder",
}
"""What a study without a bead is of, in words."""


def answer(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return what was run, and what an engineer asks, each in a sentence of stored numbers.

    Parameters
    ----------
    results, summary : Dataset, mapping
        The store. Without a bead there is no risk to tell, without voids no moisture to hold the
        pressures against.
    """
    listed = summary.get("claims") or []
    return rendered(
        "report/page/answer.html.j2",
        {
            "run": _run(results, summary),
            "asked": _asked(results, summary),
            "notes": [*summary.get("notes", ()), *summary.get("field", {"notes": ()})["notes"]],
            "counted": counted(one["statement"] for one in listed),
            "tally": tally(listed),
        },
    )


def _run(results: xr.Dataset, summary: Mapping[str, Any]) -> str:
    values = parameters(results)
    parts = values["study.parts"]
    if "flow" not in summary:
        return f"No bead: {', '.join(PARTS.get(part, part) for part in parts)}."
    length, count = 2e6 * values["fiber.half_length"], len(summary["streamlines"])
    if "bead_height" not in summary["flow"]:
        return (
            f"{count} path{'' if count == 1 else 's'} of {SOURCES[values['flow.source']]}; melt of "
            f"{_viscosity(values)}; fibers {short(length)} µm long, of aspect ratio "
            f"{short(values['fiber.aspect_ratio'])} ({SHAPES[values['fiber.model']].plural})."
        )
    return (
        f"A bead {number(MM * summary['flow']['bead_height'], 3)} mm high, laid at "
        f"{short(MM * values['flow.bed_speed'])} mm/s by a nozzle "
        f"{short(MM * values['flow.gap'])} mm above the bed; melt of "
        f"{_viscosity(values)}; fibers {short(length)} µm long, of aspect "
        f"ratio {short(values['fiber.aspect_ratio'])} ({SHAPES[values['fiber.model']].plural}), on "
        f"{count} streamline{'' if count == 1 else 's'}."
    )


def _size(results: xr.Dataset) -> float:
    """Return what places are told by [mm]: the capillary's width, or the extent of the paths."""
    if not is_given(results):
        return MM * float(parameters(results)["flow.capillary_width"])
    return MM * max(float(np.ptp(results[name].to_numpy())) for name in "xy")


def _viscosity(values: Mapping[str, Any]) -> str:
    """Return the viscosity of a Newtonian melt, or the law of another."""
    if values["melt.law"] != "newtonian":
        return f"{values['melt.law']} viscosity"
    return f"{short(values['melt.viscosity'])} Pa s"


def _asked(results: xr.Dataset, summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the questions that the store answers, each with its answer."""
    if "voids" in summary:
        found = summary["voids"]
        asked = [(one["question"], one["answer"]) for one in found["answer"]]
        worst = worst_line(found) if is_given(results) else None
        if worst is not None:
            # Paths of another solver's flow have no layers that say where.
            place = _place(results, worst["x"], worst["y"], worst.get("z"))
            told = f"The lowest pressure is met {place}, on path {worst['index']}."
            asked.insert(len(asked) - 1, ("Where is it worst?", told))
        return asked
    if "bound_lowest" in results:
        return _without_moisture(results)
    return _of_a_fiber(summary)


def _of_a_fiber(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what a study without a bead found of a single fiber."""
    found = []
    if "orbits" in summary:
        base = summary["orbits"]["cases"][0]
        cell, free = base["confined-ellipse"], base["ellipse"]
        turns = "stalls" if cell["period"] is None else f"turns in {number(cell['period'], 4)} s"
        found.append(
            (
                "How does it turn?",
                f"A fiber of aspect ratio {short(base['aspect_ratio'])} at "
                f"{short(base['shear_rate'])} 1/s {turns} in its cell, in "
                f"{number(free['period'], 4)} s without one; the pressure on it falls to "
                f"{number(KPA * cell['min_pressure'])} kPa less the far field’s, to "
                f"{number(KPA * free['min_pressure'])} kPa without.",
            )
        )
    if "interaction" in summary:
        one = summary["interaction"]
        found.append(
            (
                "Which cell?",
                f"M = {fixed(one['domain_size'], 3)}: a fiber in it stalls at "
                f"{fixed(math.degrees(one['preferred_angle']), 2)}°, where most fibers lie at the "
                f"content’s C_I of {short(one['interaction'], 4)}.",
            )
        )
    return found


def _place(results: xr.Dataset, x: float, y: float, z: float | None = None) -> str:
    """Return a place [m] in words."""
    size = _size(results)
    if is_given(results):
        told = (
            f"{name} = {sized(MM * value, size)} mm"
            for name, value in zip("xyz", (x, y, z), strict=True)
            if value is not None
        )
        return f"at {', '.join(told)}"
    side = "downstream" if x >= 0 else "upstream"
    return (
        f"{sized(MM * abs(x), size)} mm {side} of the nozzle’s axis and "
        f"{sized(MM * y, size)} mm above the bed"
    )


def _without_moisture(results: xr.Dataset) -> list[tuple[str, str]]:
    """Return what is known of a bead of which no moisture was told."""
    regular = np.flatnonzero(results["near_singularity"].to_numpy() == 0)
    if not regular.size:
        return []
    lines = results.isel(streamline=regular)
    local = lines["pressure"].to_numpy() + lines["bound_lowest"].to_numpy()
    row, point = np.unravel_index(int(np.argmin(local)), local.shape)
    lowest = float(local[row, point])
    at = lines.isel(streamline=int(row), point=int(point))
    below = "below" if lowest < 0 else "above"
    place = _place(results, *(float(at[name]) for name in "xyz" if name in at))
    return [
        (
            "Can it void?",
            "Not judged, as no moisture was told: on a fiber in its worst direction the pressure "
            f"falls to {number(MPA * abs(lowest), 3)} MPa {below} the atmosphere’s.",
        ),
        (
            "Where?",
            f"It is met {place}, on {line_word(results)} {int(at['streamline'])}.",
        ),
        ("What to do?", 'Add "voids" to study.parts: it tells at what moisture a bubble can grow.'),
    ]
