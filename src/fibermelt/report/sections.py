"""The sections of the report that follow its figures, in their order.

A part of a study that has more to tell adds its `Section` here: a pure function of results and
summary to HTML, with `fibermelt.report.tables.table` for rows. What is not `Markup` is escaped.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.report.chapters import claims, cost, numbers, sources, versions

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SECTIONS", "Section", "told"]


@dataclass(frozen=True)
class Section:
    """A section of the report.

    Parameters
    ----------
    name : str
        Its address within the page.
    title : str
        Its heading.
    needs : str
        A variable of the results, or a key of the summary, without which it is left out; empty
        if it needs none.
    html : callable
        From results and summary to its content; headings in it are h3. Where it is empty, the
        section is left out.
    """

    name: str
    title: str
    needs: str
    html: Callable[[xr.Dataset, Mapping[str, Any]], Markup]


SECTIONS = (
    Section("claims", "The paper's claims", "claims", claims),
    Section("numbers", "Numbers", "flow", numbers),
    Section("cost", "Cost", "cost", cost),
    Section("versions", "Versions", "", versions),
    Section("sources", "Sources", "", sources),
)


def told(results: xr.Dataset, summary: Mapping[str, Any]) -> list[tuple[Section, Markup]]:
    """Return the sections that a store is enough for, each with its content."""
    found = []
    for section in SECTIONS:
        if section.needs and section.needs not in results and section.needs not in summary:
            continue
        if content := section.html(results, summary):
            found.append((section, content))
    return found
