"""What a sweep comes to before it runs, how far it is, what it costs, and what nobody needs more.

A stored stage tells what it cost and from which neighbour it started. The numbers of cases lie
together in files that tell neither, so `fibermelt.sweeps.store.Progress` counts what they cost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import partial, remove, storage_errors
from fibermelt.engine.schema import no_folder
from fibermelt.engine.stages import keys
from fibermelt.engine.store import Record, Store
from fibermelt.errors import ConfigError, StoreError
from fibermelt.study.loading import load_study
from fibermelt.sweeps.plan import FROM_NEIGHBOUR, Plan, plan_sweep
from fibermelt.sweeps.store import CaseStore, Progress, read_asked, read_progress, stage_folder

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study
    from fibermelt.engine.parts import Chain
    from fibermelt.sweeps.design import Sweep
    from fibermelt.sweeps.plan import Job, PlannedCase
    from fibermelt.sweeps.store import Failure

__all__ = [
    "Computed",
    "Estimate",
    "StageCost",
    "estimate",
    "list_plan",
    "list_unneeded",
    "read_computed",
    "remove_unneeded",
    "sweep_status",
]


def list_plan(
    sweep: Sweep, study: Study, chain: Chain, directory: Path, workers: int = 1
) -> dict[str, Any]:
    """Return what a sweep comes to, and what of it a results folder has already.

    Parameters
    ----------
    sweep, study, chain : Sweep, Study, Chain
        The sweep, the study that holds it, and the stages that there are.
    directory : Path
        The results folder; it need not be there.
    workers : int
        How many are to work at once.

    Returns
    -------
    dict
        ``"cases"``, ``"done"``, ``"failed"``, ``"pending"``: numbers of cases; ``"shape"``;
        ``"sampled"``: by key what the cases are samples of, in words;
        ``"stages"``: for each stage how many different ``"results"`` the cases need, how many of
        them are ``"kept"`` in the folder, and ``"stored"`` there by now, and how many start
        ``"warm"`` from a neighbour's; ``"estimate"``: as `Estimate` has it, with the ``"workers"``
        that it is for; ``"notes"``: what to know of the study without its sweep; ``"each"``: every
        case with its ``"point"``, its ``"stages"`` and its ``"status"``.
    """
    plan = plan_sweep(sweep, study, chain)
    cases = CaseStore(directory)
    each = _each(plan, cases.refresh(), cases.failures())
    pending = [plan.cases[case["case"] - 1] for case in each if case["status"] == "pending"]
    counts = Counter(case["status"] for case in each)
    kept = Counter(job.stage for job in plan.jobs.values())
    warm = Counter(job.stage for job in plan.jobs.values() if job.neighbour)
    stored = Counter(
        job.stage
        for job in plan.jobs.values()
        if stage_folder(directory, job.stage, job.key).is_dir()
    )
    return {
        "cases": len(each),
        **{name: counts[name] for name in ("done", "failed", "pending")},
        "shape": list(sweep.shape),
        "sampled": {axis.name: axis.told for axis in sweep.axes if axis.told},
        "stages": {
            name: {
                "results": count,
                "kept": kept[name],
                "stored": stored[name],
                **({"warm": warm[name]} if warm[name] else {}),
            }
            for name, count in plan.shared().items()
        },
        "notes": study.config.notes(),
        "estimate": {**asdict(estimate(plan, directory, pending, workers)), "workers": workers},
        "each": each,
    }


def _each(
    plan: Plan, done: Collection[str], failures: Mapping[str, Failure]
) -> list[dict[str, Any]]:
    """Return what is told of every case of a plan."""
    told = []
    for case in plan.cases:
        failed = any(key in failures for key in case.keys.values())
        told.append(
            {
                "case": case.index + 1,
                "id": case.id,
                "point": dict(case.point),
                "stages": {name: key[:12] for name, key in case.keys.items()},
                "status": "done" if case.result in done else "failed" if failed else "pending",
            }
        )
    return told


def sweep_status(directory: Path) -> dict[str, Any]:
    """Return how far the sweep of a results folder is.

    Returns
    -------
    dict
        ``"cases"``; ``"done"``, ``"failed"``, ``"pending"`` of them; ``"reused_stages"`` and
        ``"wall_s"`` of the last run into the folder; ``"reasons"``: how many cases each reason
        cost; ``"failures"``: the stages without an answer, with their parameters; ``"damaged"``:
        files that are not what was written; ``"stages"``: of each stage that is kept, how many
        results are ``"needed"`` and ``"stored"``, how many of these started ``"from_neighbour"``,
        and what they cost: ``"seconds"`` of wall time and ``"processor"`` time [s].

    Raises
    ------
    StoreError
        If the folder holds no sweep, or one that is damaged.
    """
    cases = CaseStore(directory)
    asked = read_asked(cases)
    finished, failures = cases.refresh(), cases.failures()
    done, reasons, met = 0, Counter[str](), {}
    for case in asked.cases:
        if case.result in finished:
            done += 1
        elif failure := asked.failure(case, failures):
            reasons[failure.reason] += 1
            met[failure.key] = failure
    failed, computed = sum(reasons.values()), read_computed(directory)
    progress = computed.progress
    return {
        "cases": len(asked.cases),
        "done": done,
        "failed": failed,
        "reused_stages": progress.reused_stages,
        "wall_s": progress.wall_s,
        "pending": len(asked.cases) - done - failed,
        "reasons": dict(reasons.most_common()),
        "failures": [
            {
                "stage": failure.stage,
                "key": failure.key,
                "kind": failure.kind,
                "reason": failure.reason,
                "parameters": dict(failure.parameters),
            }
            for failure in met.values()
        ],
        "damaged": [str(path) for path in cases.damaged],
        "stages": {name: asdict(cost) for name, cost in computed.stages.items()},
    }


def list_unneeded(directory: Path, chain: Chain) -> list[Path]:
    """Return what no case of the sweep and no run on show in a results folder needs.

    Parameters
    ----------
    directory : Path
        The results folder.
    chain : Chain
        The stages that there are.

    Raises
    ------
    StoreError
        If the folder holds neither a sweep nor a run, or does not say what they need.
    """
    cases = CaseStore(directory)
    is_swept, config = cases.is_begun(), directory / "config.toml"
    if not is_swept and not config.exists():
        what = no_folder(directory) or "holds neither a sweep nor a run"
        msg = f"{directory}: {what}: nothing tells what is not needed; name a results folder"
        raise StoreError(msg)
    stages: set[Path] = set()
    results: set[str] = set()
    failing: set[str] = set()
    if is_swept:
        asked = read_asked(cases)
        stages |= {stage_folder(directory, name, key) for name, key, kept in asked.stages if kept}
        results = {case.result for case in asked.cases}
        failing = {key for _, key, _ in asked.stages}
    if config.exists():
        stages |= _on_show(directory, chain)
    cases.refresh()
    unneeded = [
        path
        for path in sorted((directory / "stages").glob("*-*"))
        if path.is_dir() and not path.name.startswith(".") and path not in stages
    ]
    unneeded += [
        cases.folder / name
        for name, found in cases.batch_results().items()
        if not results.intersection(found)
    ]
    unneeded += cases.damaged
    known = {stage_folder(directory, f.stage, f.key).name: f for f in cases.failures().values()}
    for path in sorted(cases.folder.glob("failed-*.json")):
        failure = known.get(path.stem.removeprefix("failed-"))
        if failure is None or failure.key not in failing:
            unneeded.append(path)
    return unneeded


def remove_unneeded(paths: list[Path]) -> None:
    """Remove what `list_unneeded` found.

    Raises
    ------
    StoreError
        If it cannot be removed.
    """
    for path in paths:
        with storage_errors(path):
            # Renamed first: half of a stage is never found under its name.
            temporary = partial(path.parent)
            try:
                path.rename(temporary)
            except FileNotFoundError:
                continue
            remove(temporary)


def _on_show(directory: Path, chain: Chain) -> set[Path]:
    """Return the stages of the run whose results lie on show."""
    try:
        config = load_study(str(directory / "config.toml")).config
    except ConfigError as error:
        msg = (
            f"{directory / 'config.toml'}: cannot be read, so that nothing tells what the run on "
            f"show needs: {str(error).splitlines()[0]}"
        )
        raise StoreError(msg) from error
    values = config.values()
    found = keys(chain.needed(config.study.parts, values), values)
    return {stage_folder(directory, name, key) for name, key in found.items()}


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
    stored, that from cold counts.

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
    seconds, sizes, stored = _means(directory)
    left = _left(plan, pending, stored)
    count = len({case.result for case in pending})
    kinds = {job.kind: seconds.get(job.kind, seconds.get(job.stage)) for job in left.values()}
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


def _left(plan: Plan, pending: Sequence[PlannedCase], stored: set[str]) -> dict[str, Job]:
    """Return the stages that cases need, and those from which these start, as far as not stored."""
    left = {case.keys[name] for case in pending for name in case.kept} - stored
    left |= {plan.jobs[key].neighbour for key in left} - stored
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


def _means(directory: Path) -> tuple[dict[str, float], dict[str, float], set[str]]:
    """Return the mean time [s] of each kind and the mean size of each stage; and what is stored."""
    times: dict[str, list[float]] = {}
    sizes: dict[str, list[float]] = {}
    stored: set[str] = set()
    for record, size in Store(directory, ()).records():
        stored.add(record.key)
        kind = f"{record.stage}{FROM_NEIGHBOUR}" if record.neighbour else record.stage
        times.setdefault(kind, []).append(record.cost)
        sizes.setdefault(record.stage, []).append(float(size))
    return _averaged(times), _averaged(sizes), stored


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
