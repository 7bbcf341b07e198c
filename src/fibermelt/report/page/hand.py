"""A second process that draws figures beside the first: drawing is most of a page's time.

``python -m fibermelt.report.page.hand`` takes pickled results and a folder from its input, then the
names of figures, and answers each with a line when its files are written. A plain child process: it
does not run the caller's script again, as those of multiprocessing do.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING

from fibermelt.report.kit.plates import Plate, draw_plates

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["draw_with_help"]

FEWEST = 4
"""Figures for which a second process is started: it takes about as long as two to be there."""

DONE = b"drawn\n"


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
    with _helped(left, results, directory) as failed:
        while left:
            draw_plates([left.popleft()], results, directory)
    # What the other could not draw tells here why.
    draw_plates(failed, results, directory)


@contextmanager
def _helped(left: deque[Plate], results: xr.Dataset, directory: Path) -> Iterator[list[Plate]]:
    """Have a second process take figures from the end; yield those that it does not draw."""
    failed: list[Plate] = []
    process = subprocess.Popen(
        [sys.executable, "-m", "fibermelt.report.page.hand"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )

    def give() -> None:
        asked: object = (results, directory)
        plate: Plate | None = None
        while _answered(process, asked):
            try:
                plate = left.pop()
            except IndexError:
                return
            asked = plate.name
        if plate is not None:
            failed.append(plate)

    giver = Thread(target=give, daemon=True)
    giver.start()
    try:
        yield failed
        giver.join()
    finally:
        process.kill()
        giver.join()
        with suppress(OSError):
            process.communicate()


def _answered(process: subprocess.Popen[bytes], asked: object) -> bool:
    """Ask a process for something, and tell whether it did it."""
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        pickle.dump(asked, process.stdin)
        process.stdin.flush()
    except OSError:
        return False
    return process.stdout.readline() == DONE


def _main() -> None:
    """Draw the figures that are named on the input."""
    from fibermelt.report.page.figures import FIGURES  # noqa: PLC0415  it imports this module

    plates = {plate.name: plate for plate in FIGURES}
    results, directory = pickle.load(sys.stdin.buffer)
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(2, 1)
        while True:
            output.write(DONE)
            output.flush()
            try:
                name = pickle.load(sys.stdin.buffer)
            except EOFError:
                return
            draw_plates([plates[name]], results, directory)


if __name__ == "__main__":
    _main()
