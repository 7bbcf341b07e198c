"""How far a folder is besides what lies in it, and what its cases cost: cases/progress.json.

Clients that share a folder share the file: each adds what it computed since it last did, so that
the sums are those of all of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

from fibermelt.engine.files import claimed, read_sealed, write_sealed
from fibermelt.errors import StoreError
from fibermelt.sweeps.store import CaseStore

__all__ = ["Progress", "add_progress", "read_progress", "write_progress"]


@dataclass(frozen=True)
class Progress:
    """How far a folder is.

    Parameters
    ----------
    wall_s : float
        Wall time so far of the run that told last [s].
    reused_stages : int
        Stages that it found.
    cases : int
        Cases whose numbers were computed, in all runs.
    cases_s, cases_processor_s : float
        Wall time and processor time that they took, without the stages that are stored [s].
    software : dict
        Versions of what computed them last.
    """

    wall_s: float = 0.0
    reused_stages: int = 0
    cases: int = 0
    cases_s: float = 0.0
    cases_processor_s: float = 0.0
    software: Mapping[str, str] = field(default_factory=dict)


def add_progress(cases: CaseStore, since: Progress) -> None:
    """Add what a run computed since it last told, while no other run does.

    Parameters
    ----------
    cases : CaseStore
        What a folder has of a sweep.
    since : Progress
        What is new: cases and times to add, and the versions if there are any cases; wall time
        and stages that were found are those of the whole run.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    with claimed(cases.lock("progress"), wait=True):
        before = read_progress(cases)
        after = Progress(
            wall_s=since.wall_s,
            reused_stages=since.reused_stages,
            cases=before.cases + since.cases,
            cases_s=before.cases_s + since.cases_s,
            cases_processor_s=before.cases_processor_s + since.cases_processor_s,
            software=since.software or before.software,
        )
        write_progress(cases, after)


def write_progress(cases: CaseStore, progress: Progress) -> None:
    """Write how far a folder is, in place of what was known."""
    write_sealed(cases.progress, asdict(progress))


def read_progress(cases: CaseStore) -> Progress:
    """Return what `write_progress` wrote, or nothing if it is not there or damaged."""
    try:
        return Progress(**read_sealed(cases.progress))
    except (ValueError, TypeError, StoreError):
        return Progress()
