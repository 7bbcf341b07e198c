"""What a sweep cost so far, and what the rest of it will: from the records of what is stored.

A stored stage tells what it cost and from which neighbour it started. The numbers of cases lie
together in files that tell neither, so `fibermelt.sweeps.progress` counts what they cost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fibermelt.engine.store import Record, Store
from fibermelt.sweeps.plan import FROM_NEIGHBOUR
from fibermelt.sweeps.progress import Progress, read_progress
from fibermelt.sweeps.record import read_asked
from fibermelt.sweeps.store import CaseStore

if TYPE_CHECKING:
    from fibermelt.sweeps.plan import Job, Plan, PlannedCase

__all__ = [
    "Computed",
    "Estimate",
    "StageCost",
    "estimate",
    "read_computed",
]


@dataclass(frozen=True)
class StageCost:
    """What the results of a stage cost that a sweep keeps.

    Parameters
    ----------
    needed, stored : int
        How many results the cases need, and how many of them are stored.
    from_neighbour : int
        How many of these started from a neighbour; all others did from cold.
    seconds, processor : float
        Wall time and processor time that they took, added up [s].
    """

    needed: int
    stored: int
    from_neighbour: int
    seconds: float
    processor: float


@dataclass(frozen=True)
class Computed:
    """How what a sweep found was computed.

    Parameters
    ----------
    stages : dict
        The cost of every stage that is kept, by its name, in the order of the cases' stages.
    progress : Progress
        The cost of the cases, and the last run.
    software : dict
        Versions of what computed: several of one, if the runs into the folder had several.
    """

    stages: Mapping[str, StageCost]
    progress: Progress
    software: Mapping[str, tuple[str, ...]]


def read_computed(directory: Path) -> Computed:
    """Return how the sweep of a results folder was computed.

    Raises
    ------
    StoreError
        If the folder holds no sweep, or one that is damaged.
    """
    cases = CaseStore(directory)
    kept = {key: name for name, key, is_kept in read_asked(cases).stages if is_kept}
    found: dict[str, list[Record]] = {name: [] for name in kept.values()}
    for record, _ in Store(directory, ()).records():
        if record.key in kept:
            found[record.stage].append(record)
    needed, progress = Counter(kept.values()), read_progress(cases)
    versions: dict[str, set[str]] = {}
    every = [record.software for records in found.values() for record in records]
    for software in (*every, progress.software):
        for name, version in software.items():
            versions.setdefault(name, set()).add(version)
    return Computed(
        stages={name: _added(needed[name], records) for name, records in found.items()},
        progress=progress,
        software={name: tuple(sorted(several)) for name, several in versions.items()},
    )


def _added(needed: int, there: Sequence[Record]) -> StageCost:
    return StageCost(
        needed=needed,
        stored=len(there),
        from_neighbour=sum(bool(record.neighbour) for record in there),
        seconds=sum(record.cost for record in there),
        processor=sum(record.processor for record in there),
    )


@dataclass(frozen=True)
class Estimate:
    """What the rest of a sweep will cost, as what is stored did.

    Parameters
    ----------
    work : float
        Wall time of all that is left, one after the other [s].
    wall : float
        The same on some workers [s], no less than what waits for one another takes. They start
        in some seconds, which are not counted, nor is that others may keep the cores busy.
    size : int
        What it will take on the disk [bytes].
    unknown : tuple of str
        What is left of which nothing is stored yet: it is in none of these numbers.
    """

    work: float
    wall: float
    size: int
    unknown: tuple[str, ...]


def estimate(plan: Plan, directory: Path, pending: Sequence[PlannedCase], workers: int) -> Estimate:
    """Return what the rest of a sweep will cost, from the mean cost of like stages in a folder.

    A stage that starts from a neighbour costs less than one from cold: where none like it is
    stored, that from cold counts; one that is scaled from its neighbour then costs nothing.

    Parameters
    ----------
    plan : Plan
        The sweep.
    directory : Path
        The results folder; it need not be there.
    pending : sequence of PlannedCase
        Cases that are to do.
    workers : int
        How many work at once.
    """
    seconds, sizes, stored = _means(plan, directory)
    left = _left(plan, pending, stored)
    count = len({case.result for case in pending})
    kinds = {job.kind: _mean(job, seconds) for job in left.values()}
    unknown = [kind for kind, mean in kinds.items() if mean is None]
    cost = {key: kinds[job.kind] or 0.0 for key, job in left.items()}
    each, size = _cases(directory, seconds, plan)
    if pending and each is None:
        unknown.append("cases")
    work = sum(cost.values()) + count * (each or 0.0)
    total = sum(sizes.get(job.stage, 0.0) for job in left.values()) + count * size
    return Estimate(
        work=work,
        wall=max(work / workers, _longest(left, cost) + (each or 0.0)) if work else 0.0,
        size=round(total),
        unknown=tuple(unknown),
    )


def _mean(job: Job, seconds: Mapping[str, float]) -> float | None:
    """Return the time of a stage [s] from those of its kind, None if it is not known."""
    cold = seconds.get(job.stage)
    # Scaling is a matter of milliseconds wherever a solve is one of seconds.
    other = 0.0 if job.is_scaled and cold is not None else cold
    return seconds.get(job.kind, other)


def _left(plan: Plan, pending: Sequence[PlannedCase], stored: set[str]) -> dict[str, Job]:
    """Return the stages that cases need, and those from which these start, as far as not stored."""
    left: set[str] = set()
    keys = {case.keys[name] for case in pending for name in case.kept}
    while keys := {key for key in keys if key in plan.jobs} - stored - left:
        left |= keys
        keys = {plan.jobs[key].neighbour for key in keys}
    return {key: job for key, job in plan.jobs.items() if key in left}


def _longest(left: Mapping[str, Job], cost: Mapping[str, float]) -> float:
    """Return the time of the stages that wait for one another, where they take longest [s]."""
    ends: dict[str, float] = {}

    def end(key: str) -> float:
        if key not in left:
            return 0.0
        if key not in ends:
            job = left[key]
            ends[key] = cost[key] + max(map(end, (*job.needs, job.neighbour)))
        return ends[key]

    return max(map(end, left), default=0.0)


def _means(plan: Plan, directory: Path) -> tuple[dict[str, float], dict[str, float], set[str]]:
    """Return the mean time [s] of each kind and the mean size of each stage; and what is stored."""
    times: dict[str, list[float]] = {}
    sizes: dict[str, list[float]] = {}
    stored: set[str] = set()
    for record, size in Store(directory, ()).records():
        stored.add(record.key)
        times.setdefault(_kind(record, plan), []).append(record.cost)
        sizes.setdefault(record.stage, []).append(float(size))
    return _averaged(times), _averaged(sizes), stored


def _kind(record: Record, plan: Plan) -> str:
    """Return what was done, as `Job.kind` has it."""
    job = plan.jobs.get(record.key)
    if not record.neighbour:
        return record.stage
    return job.kind if job is not None else f"{record.stage}{FROM_NEIGHBOUR}"


def _averaged(several: Mapping[str, list[float]]) -> dict[str, float]:
    return {name: sum(values) / len(values) for name, values in several.items()}


def _cases(directory: Path, seconds: Mapping[str, float], plan: Plan) -> tuple[float | None, float]:
    """Return the mean time of a case [s], None if it is not known, and its size [bytes]."""
    cases = CaseStore(directory)
    progress = read_progress(cases)
    cases.refresh()
    batches = cases.batch_results()
    count = sum(map(len, batches.values()))
    size = sum((cases.folder / name).stat().st_size for name in batches) / max(count, 1)
    if progress.cases:
        return progress.cases_s / progress.cases, size
    # A run of one case keeps the last stages too, and what they cost.
    light = {name for case in plan.cases[:1] for name in case.keys if name not in case.kept}
    if all(name in seconds for name in light):
        return sum(seconds[name] for name in light), size
    return None, size
