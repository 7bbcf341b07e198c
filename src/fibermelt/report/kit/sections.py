"""What a section of a page is: words from a template beside the function that fills it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.report.kit.templates import rendered

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Section", "section"]

Content = Callable[["xr.Dataset", Mapping[str, Any]], Mapping[str, Any]]


@dataclass(frozen=True)
class Section:
    """A section of a page.

    Parameters
    ----------
    name : str
        Its address within the page, by which figures say where they stand.
    title : str
        Its heading.
    place : float
        Where it stands among all.
    needs : str
        A variable of the results, or a key of the summary, without which it has no words; empty
        if they need none.
    of_paths : str
        Its heading where fibers follow the paths of a flow from elsewhere; empty if it is the same.
    content : callable, optional
        From results and summary to what its template is filled with; without it, it holds figures
        only.
    template : str
        Its template, whose headings are h3.
    """

    name: str
    title: str
    place: float
    needs: str = ""
    of_paths: str = ""
    content: Content | None = None
    template: str = ""

    def words(self, results: xr.Dataset, summary: Mapping[str, Any]) -> Markup:
        """Return its words, empty if there are none to tell."""
        is_there = not self.needs or self.needs in results or self.needs in summary
        if self.content is None or not is_there:
            return Markup()
        return rendered(self.template, self.content(results, summary))


def section(
    name: str, title: str, *, place: float, needs: str = "", of_paths: str = ""
) -> Callable[[Content], Section]:
    """Make a section of the function that fills its template, ``name.html.j2`` beside it.

    The page finds it where a part keeps its sections, in the module ``section``.

    Parameters
    ----------
    name, title, place, needs, of_paths
        As in `Section`.
    """

    def made(content: Content) -> Section:
        folder = content.__module__.split(".")[1:-1]
        template = "/".join([*folder, f"{name}.html.j2"])
        return Section(name, title, place, needs, of_paths, content, template)

    return made
