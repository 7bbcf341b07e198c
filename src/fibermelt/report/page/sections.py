"""The sections of the report, as the parts declare them, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.parts.flow.given import is_given
from fibermelt.report.kit.sections import Section
from fibermelt.report.page.endmatter import ENDMATTER
from fibermelt.report.page.found import found

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.report.page.embed import Embedded

__all__ = ["OPENING", "SECTIONS", "Filled", "filled"]

OPENING = Section("bead", "The bead at a glance", place=0)
"""What stands above all that is told: the figure at a glance, and the one that moves."""

SECTIONS = (
    OPENING,
    *sorted([*found(Section, "section"), *ENDMATTER], key=lambda section: section.place),
)
"""In the order of the page."""


@dataclass(frozen=True)
class Filled:
    """A section as it stands in a page.

    Parameters
    ----------
    section : Section
        Which one.
    title : str
        Its heading.
    words : Markup
        Its words, empty if it has figures only.
    figures : tuple of Embedded
        Its figures.
    """

    section: Section
    title: str
    words: Markup
    figures: tuple[Embedded, ...] = ()


def filled(
    results: xr.Dataset, summary: Mapping[str, Any], figures: Iterable[Embedded]
) -> list[Filled]:
    """Return the sections that a store is enough for, each with its words and figures.

    Parameters
    ----------
    results, summary : Dataset, mapping
        The store.
    figures : iterable of Embedded
        The figures, in their order.
    """
    every = tuple(figures)
    told = [
        Filled(
            section,
            (is_given(results) and section.of_paths) or section.title,
            section.words(results, summary),
            tuple(figure for figure in every if figure.section == section.name),
        )
        for section in SECTIONS
    ]
    return [one for one in told if one.words.strip() or one.figures]
