"""A second process draws figures beside the first: drawing is most of a page's time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from fibermelt.engine.helper import Helper, HelperLostError, helped
from fibermelt.engine.stages import Say
from fibermelt.report.kit.plates import Plate, draw_plates

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["draw_with_help"]

FEWEST = 4
"""Figures for which a second process is started: it takes about as long as two to be there."""

_GIVEN: list[tuple[xr.Dataset, Path]] = []
"""What the second process draws of and where to, given once: results are large."""


def draw_with_help(
    plates: tuple[Plate, ...], results: xr.Dataset, directory: Path, *, hands: int
) -> None:
    """Draw figures, from the first on here and from the last on in a second process.

    Parameters
    ----------
    plates, results, directory
        As `fibermelt.report.kit.plates.draw_plates` takes them; each plate is of `FIGURES`.
    hands : int
        Processes that may draw, this one among them; more than two are not started.
    """
    left = deque(plates)
    if hands < 2 or len(plates) < FEWEST:
        draw_plates(left, results, directory)
        return
    failed: list[Plate] = []

    def give(helper: Helper) -> None:
        with suppress(HelperLostError):
            helper.call(f"{__name__}:begin", results, directory)
            while (plate := _taken(left.pop)) is not None:
                failed.append(plate)
                helper.call(f"{__name__}:draw_one", plate.name)
                failed.clear()

    with helped(give):
        while (plate := _taken(left.popleft)) is not None:
            draw_plates([plate], results, directory)
    # What the other could not draw tells here why.
    draw_plates(failed, results, directory)


def _taken(take: Callable[[], Plate]) -> Plate | None:
    """Return what is taken, None where the other process took the last one."""
    try:
        return take()
    except IndexError:
        return None


def begin(results: xr.Dataset, directory: Path, say: Say) -> None:
    """Take what is to be drawn of, and where to, in the second process."""
    _GIVEN[:] = [(results, directory)]


def draw_one(name: str, say: Say) -> None:
    """Draw a figure of the page in the second process."""
    from fibermelt.report.page.figures import FIGURES  # noqa: PLC0415  it imports this module

    ((results, directory),) = _GIVEN
    (plate,) = (plate for plate in FIGURES if plate.name == name)
    draw_plates([plate], results, directory)
