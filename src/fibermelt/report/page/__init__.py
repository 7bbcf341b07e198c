"""The page of a run, for who runs it: what draws and writes is loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["draw", "render"]


def draw(results: xr.Dataset, folder: Path) -> Sequence[Path]:
    """Draw the figures of a run, as `fibermelt.report.page.figures.draw_figures`."""
    from fibermelt.report.page.figures import draw_figures  # noqa: PLC0415  lazy: see the module

    return draw_figures(results, folder)


def render(results: xr.Dataset, summary: Mapping[str, Any], drawn: Mapping[str, bytes]) -> bytes:
    """Make the page of a run, as `fibermelt.report.page.page.render`."""
    from fibermelt.report.page.page import render as page  # noqa: PLC0415  lazy: see the module

    return page(results, summary, drawn)
