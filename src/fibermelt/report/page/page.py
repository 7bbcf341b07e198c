"""The report: one HTML file that needs nothing else, as a pure function of the store.

Nothing but the stored results and summary goes into it: no date, no path, no machine. The same
store gives the same bytes with the same versions of fibermelt and matplotlib.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.engine.finished import read_finished
from fibermelt.engine.outputs import replace_output
from fibermelt.engine.schema import REPORT
from fibermelt.errors import StoreError
from fibermelt.parts.bead.figures.interactive import moving_figure
from fibermelt.parts.flow.figures.judged import vapor_above_air
from fibermelt.report.kit.glossary import glossary
from fibermelt.report.kit.templates import rendered, text_of
from fibermelt.report.page.answer import answer
from fibermelt.report.page.embed import embed_figures
from fibermelt.report.page.sections import OPENING, filled
from fibermelt.report.page.what_was_run import title_of, what_was_run

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["render", "write_report"]


def render(
    results: xr.Dataset, summary: Mapping[str, Any], drawn: Mapping[str, bytes] | None = None
) -> bytes:
    """Return the report of a finished run.

    Parameters
    ----------
    results : xarray.Dataset
        Content of results.nc, with the study in its attributes.
    summary : mapping
        Content of summary.json.
    drawn : mapping, optional
        The figures' files by name (``"overview.svg"``) where they were drawn before from these
        results; it saves the time to draw them, and changes nothing else.

    Returns
    -------
    bytes
        HTML, UTF-8, that needs no other file; it links to those that lie beside it.

    Raises
    ------
    StoreError
        If the results hold no study that this fibermelt reads.
    """
    # First, as it refuses results without a study.
    run = what_was_run(results)
    sections = filled(results, summary, embed_figures(results, drawn))
    page = rendered(
        "report/page/page.html.j2",
        {
            "title": title_of(results),
            "answer": answer(results, summary),
            "glossary": glossary(),
            "judges": vapor_above_air(results) is not None,
            "what_was_run": run,
            "moving": moving_figure(results),
            "opening": next((one for one in sections if one.section is OPENING), None),
            "sections": [one for one in sections if one.section is not OPENING],
            "style": Markup(text_of("report/page/style.css")),
            "script": Markup(text_of("report/page/moving.js")),
        },
    )
    return str(page).encode()


def write_report(directory: Path) -> Path:
    """Write the report of a results folder into it, and return its path.

    Figures that the run drew, and that are as it wrote them, are taken from the folder rather
    than drawn again.

    Raises
    ------
    StoreError
        If the folder holds no finished run, what it holds was changed, another run was put on
        show meanwhile, or it cannot be written; an older report is still there then.
    """
    finished = read_finished(directory)
    page = render(finished.results, finished.summary, finished.drawn)
    path = directory / REPORT
    try:
        replace_output(directory, REPORT, page, finished.run)
    except StoreError as error:
        if not isinstance(error.__cause__, OSError):
            raise
        reason = (error.__cause__.strerror or str(error.__cause__)).lower()
        msg = f"{path}: cannot be written: {reason}; make the folder writable, or report on a copy"
        raise StoreError(msg) from error
    return path
