"""The sections of the report, in their order, and the figures that stand in each.

A part of a study that has more to tell adds its `Section` here: a pure function of results and
summary to HTML, with `fibermelt.report.kit.tables.table` for rows. What is not `Markup` is escaped.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.paper.orbits.section import dimensions, shear
from fibermelt.parts.flow.imported import is_given
from fibermelt.parts.orientation.section import content, orientation
from fibermelt.parts.thinning.figures import thinning
from fibermelt.parts.voids.section import voids
from fibermelt.report.kit.judged import claims, verification
from fibermelt.report.page.chapters import cost, files, numbers, sources, versions

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.report.page.embed import Embedded

__all__ = ["SECTIONS", "Section", "Told", "told"]

Html = Callable[["xr.Dataset", Mapping[str, Any]], Markup]


def _no_words(results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
    """Return the content of a section of figures only."""
    del results, summary
    return Markup()


@dataclass(frozen=True)
class Section:
    """A section of the report.

    Parameters
    ----------
    name : str
        Its address within the page.
    title : str
        Its heading.
    given : str
        Its heading of the paths of a flow from elsewhere; empty where it is the same.
    needs : str
        A variable of the results, or a key of the summary, without which it has no words; empty
        if they need none.
    html : callable
        From results and summary to its words; headings in them are h3.
    figures : tuple of str
        Names of the figures that follow the words, in their order.
    """

    name: str
    title: str
    needs: str = ""
    html: Html = _no_words
    figures: tuple[str, ...] = ()
    given: str = ""


SECTIONS = (
    Section(
        "flow",
        "The flow",
        figures=("paths", "melt", "domain", "streamlines", "along", "maps", "gradients"),
    ),
    Section(
        "shear",
        "One fiber in simple shear",
        "orbits",
        shear,
        (
            "cell",
            "orbit-motion",
            "orbit-pressure",
            "orbit-aspect-ratio",
            "orbit-around",
            "orbit-shear-rate",
            "orbit-viscosity",
        ),
    ),
    Section(
        "content",
        "From content to the cell",
        "interaction",
        content,
        ("interaction", "interaction-domain-size"),
    ),
    Section(
        "fibers",
        "Fibers along the streamlines",
        figures=(
            "history",
            "profiles",
            "extremes",
            "positions",
            "alignment",
            "path-histories",
            "path-extremes",
        ),
        given="Fibers along the paths",
    ),
    Section(
        "two-and-three",
        "Two dimensions against three",
        "dimensions",
        dimensions,
        ("dimensions",),
    ),
    Section("thinning", "What thinning does", "thinning", thinning, ("thinning",)),
    Section(
        "tensors",
        "Orientation in the bead",
        "orientation_tensor",
        orientation,
        ("orientation", "orientation-history"),
        "Orientation along the paths",
    ),
    Section("risk", "Where it can void", "voids", voids, ("voids",)),
    Section("claims", "The paper's claims", "claims", claims),
    Section("numbers", "Numbers", "flow", numbers),
    Section("verification", "Verification", "check_name", verification),
    Section("files", "Files", "", files),
    Section("cost", "Cost", "cost", cost),
    Section("versions", "Versions", "", versions),
    Section("sources", "Sources", "", sources),
)

FURTHER = Section("figures", "Further figures")
"""Where figures go that no section asks for; it stands before the claims."""


@dataclass(frozen=True)
class Told:
    """A section as it stands in a page.

    Parameters
    ----------
    section : Section
        Which one.
    words : Markup
        Its words, empty if it has figures only.
    figures : tuple of Embedded
        Its figures.
    """

    section: Section
    words: Markup
    figures: tuple[Embedded, ...] = ()


def told(
    results: xr.Dataset, summary: Mapping[str, Any], figures: Mapping[str, Embedded]
) -> list[Told]:
    """Return the sections that a store is enough for, each with its words and figures.

    Parameters
    ----------
    results, summary : Dataset, mapping
        The store.
    figures : mapping
        The figures to place, by name; each stands once.
    """
    asked = {name for section in SECTIONS for name in section.figures}
    further = tuple(figure for name, figure in figures.items() if name not in asked)
    found = []
    for section in SECTIONS:
        if section.name == "claims" and further:
            found.append(Told(FURTHER, Markup(), further))
        there = not section.needs or section.needs in results or section.needs in summary
        words = section.html(results, summary) if there else Markup()
        own = tuple(figures[name] for name in section.figures if name in figures)
        if words or own:
            title = section.given if section.given and is_given(results) else section.title
            found.append(Told(replace(section, title=title), words, own))
    return found
