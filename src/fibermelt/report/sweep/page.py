"""The report of a sweep: one HTML file that needs nothing else, as a pure function of the store.

As with `fibermelt.report.page.page`, nothing but what is stored goes into it: the collected sweep,
and the records of how it was computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, NamedTuple

from markupsafe import Markup

from fibermelt.engine.files import replace_file
from fibermelt.engine.outputs import has_run
from fibermelt.engine.schema import REPORT
from fibermelt.report.kit.glossary import glossary
from fibermelt.report.kit.plates import draw_plates
from fibermelt.report.kit.templates import rendered, text_of
from fibermelt.report.page.embed import Embedded, embed_plates
from fibermelt.report.sweep.claims import claims_matrix
from fibermelt.report.sweep.computed import computed_told, sources_told
from fibermelt.report.sweep.figures import sweep_plates
from fibermelt.report.sweep.tables import cases_told, responses_told, varied_told
from fibermelt.sweeps.answer import answer_sweep
from fibermelt.sweeps.collect import collect_sweep
from fibermelt.sweeps.status import read_computed
from fibermelt.sweeps.table import sweep_table

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.sweeps.status import Computed

__all__ = ["BESIDE_A_RUN", "SweepReport", "render_sweep", "write_sweep_report"]

BESIDE_A_RUN = "sweep.html"
"""Name of the report of a sweep in a folder whose report.html is that of a run."""


class SweepReport(NamedTuple):
    """A report that was written: where to, and what it says in short."""

    path: Path
    answer: tuple[str, ...]


def render_sweep(collected: xr.Dataset, computed: Computed | None = None) -> bytes:
    """Return the report of a sweep.

    Parameters
    ----------
    collected : xarray.Dataset
        As `fibermelt.sweeps.collect.collect_sweep` returns it, finished or not.
    computed : Computed, optional
        How it was computed, as `fibermelt.sweeps.status.read_computed` returns it.

    Returns
    -------
    bytes
        HTML, UTF-8, that refers to no other file.

    Raises
    ------
    StoreError
        If it does not say what varied, or from which study.
    """
    return _rendered(collected, computed, answer_sweep(collected))


def _rendered(collected: xr.Dataset, computed: Computed | None, answer: Sequence[str]) -> bytes:
    """Return the report of a sweep whose answer is known."""
    table = sweep_table(collected)
    how = Markup() if computed is None else computed_told(collected, table, computed)
    told = (
        ("claims-matrix", "The paper's claims over the sweep", claims_matrix(collected, table)),
        ("responses", "Responses", responses_told(table)),
        ("computed", "How it was computed", how),
        ("sources", "Sources", sources_told(collected, table)),
    )
    page = rendered(
        "report/sweep/sweep.html.j2",
        {
            "title": table.title,
            "answer": answer,
            "glossary": glossary(),
            "varied": varied_told(collected, table),
            "cases": cases_told(table),
            "figures": _figures(collected),
            "sections": [one for one in told if one[2]],
            "style": Markup(
                text_of("report/page/style.css") + text_of("report/sweep/sweep.css"),
            ),
        },
    )
    return str(page).encode()


def write_sweep_report(directory: Path) -> SweepReport:
    """Write the report of a sweep into its results folder.

    It is called report.html, or sweep.html where a run into the same folder has that name.

    Parameters
    ----------
    directory : Path
        The results folder.

    Raises
    ------
    StoreError
        If the folder holds no sweep, a file of it is damaged, or it cannot be written.
    """
    collected = collect_sweep(directory)
    answer = answer_sweep(collected)
    page = _rendered(collected, read_computed(directory), answer)
    path = directory / (BESIDE_A_RUN if has_run(directory) else REPORT)
    replace_file(path, page)
    return SweepReport(path, answer)


def _figures(collected: xr.Dataset) -> list[Embedded]:
    plates = sweep_plates(collected)
    with TemporaryDirectory() as folder:
        paths = draw_plates(plates, collected, Path(folder))
        drawn = {path.name: path.read_bytes() for path in paths}
    return embed_plates(plates, collected, drawn)
