"""The report of a sweep: one HTML file that needs nothing else, as a pure function of the store.

As with `fibermelt.report.html`, nothing but what is stored goes into it: the collected sweep, and
the records of how it was computed.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from fibermelt.report.embed import Embedded, embed_plates
from fibermelt.report.style import save
from fibermelt.report.sweep.claims import claims_matrix
from fibermelt.report.sweep.computed import computed_told, sources_told
from fibermelt.report.sweep.figures import sweep_plates
from fibermelt.report.sweep.words import cases_told, responses_told, varied_told
from fibermelt.study.files import replace_file
from fibermelt.study.schema import REPORT
from fibermelt.study.sweep.answer import answer_sweep
from fibermelt.study.sweep.collect import collect_sweep
from fibermelt.study.sweep.cost import read_computed
from fibermelt.study.sweep.table import sweep_table

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.study.sweep.cost import Computed

__all__ = ["BESIDE_A_RUN", "render_sweep", "write_sweep_report"]

BESIDE_A_RUN = "sweep.html"
"""Name of the report of a sweep in a folder whose report.html is that of a run."""


def render_sweep(collected: xr.Dataset, computed: Computed | None = None) -> bytes:
    """Return the report of a sweep.

    Parameters
    ----------
    collected : xarray.Dataset
        As `fibermelt.study.sweep.collect.collect_sweep` returns it, finished or not.
    computed : Computed, optional
        How it was computed, as `fibermelt.study.sweep.cost.read_computed` returns it.

    Returns
    -------
    bytes
        HTML, UTF-8, that refers to no other file.

    Raises
    ------
    StoreError
        If it does not say what varied, or from which study.
    """
    table = sweep_table(collected)
    how = Markup() if computed is None else computed_told(collected, table, computed)
    told = (
        ("claims-matrix", "The paper's claims over the sweep", claims_matrix(collected, table)),
        ("responses", "Responses", responses_told(table)),
        ("computed", "How it was computed", how),
        ("sources", "Sources", sources_told(collected, table)),
    )
    page = _template().render(
        title=table.title,
        answer=answer_sweep(collected),
        varied=varied_told(collected, table),
        cases=cases_told(table),
        figures=_figures(collected),
        sections=[one for one in told if one[2]],
        style=Markup(_file("style.css") + _file("sweep.css")),
    )
    return str(page).encode()


def write_sweep_report(directory: Path, collected: xr.Dataset | None = None) -> Path:
    """Write the report of a sweep into its results folder, and return its path.

    It is called report.html, or sweep.html where a run into the same folder has that name.

    Parameters
    ----------
    directory : Path
        The results folder.
    collected : xarray.Dataset, optional
        What is collected of it, if that is at hand.

    Raises
    ------
    StoreError
        If the folder holds no sweep, a file of it is damaged, or it cannot be written.
    """
    page = render_sweep(
        collect_sweep(directory) if collected is None else collected, read_computed(directory)
    )
    is_run = (directory / "stages" / "outputs.json").exists()
    path = directory / (BESIDE_A_RUN if is_run else REPORT)
    replace_file(path, page)
    return path


def _figures(collected: xr.Dataset) -> list[Embedded]:
    plates = sweep_plates(collected)
    with TemporaryDirectory() as folder:
        drawn = {
            path.name: path.read_bytes()
            for plate in plates
            for path in save(
                plate.draw(collected),
                Path(folder) / plate.name,
                plate.title,
                plate.words(collected),
            )
        }
    return embed_plates(plates, collected, drawn)


def _file(name: str) -> str:
    return files("fibermelt.report").joinpath("page", name).read_text(encoding="utf-8")


@cache
def _template() -> Any:
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(_file("sweep.html.j2"))
