"""The levers of a finished run on show: in its summary.json and on its page."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from fibermelt.engine.finished import read_finished
from fibermelt.engine.outputs import replace_output
from fibermelt.levers.advise import advise
from fibermelt.parts.voids.answer import answered
from fibermelt.questions.voids import VoidQuestion, answer_voids
from fibermelt.report.page.page import write_report

if TYPE_CHECKING:
    from pathlib import Path

    from fibermelt.engine.progress import Observer

__all__ = ["with_levers"]


def with_levers(
    directory: Path, *, workers: int | None = None, observer: Observer | None = None
) -> dict[str, Any]:
    """Return what summary.json of a finished run says of voids, with what helps against them.

    Where it says nothing of that yet, it is computed (`fibermelt.levers.advise`), and put on show:
    summary.json and the page are replaced, all else stays. Of a run of a bead without voids it is
    what its pressures tell, and nothing is written.

    Parameters
    ----------
    directory : Path
        The run's folder.
    workers : int, optional
        As in `fibermelt.sweeps.runner.run_sweep`.
    observer : Observer, optional
        Who is told how it goes.

    Raises
    ------
    StoreError
        If the folder holds no finished run of a bead, or cannot be written.
    """
    finished = read_finished(directory)
    if "voids" not in finished.summary:
        return answer_voids(directory, VoidQuestion())
    voids: dict[str, Any] = dict(finished.summary["voids"])
    if "levers" in voids:
        return voids
    voids |= advise(directory, finished, workers=workers, observer=observer)
    voids["answer"] = answered(voids)
    text = json.dumps({**finished.summary, "voids": voids}, indent=1, allow_nan=False)
    replace_output(directory, "summary.json", text.encode(), finished.run)
    write_report(directory)
    return voids
