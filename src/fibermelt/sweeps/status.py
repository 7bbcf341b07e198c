"""What a sweep comes to before it runs, how far it is, and what nobody needs any more."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import partial, remove, storage_errors
from fibermelt.engine.schema import no_folder
from fibermelt.engine.stages import keys
from fibermelt.errors import ConfigError, StoreError
from fibermelt.study.loading import load_study
from fibermelt.sweeps.cost import estimate, read_computed
from fibermelt.sweeps.descriptions import distribution_told
from fibermelt.sweeps.plan import Plan, plan_sweep
from fibermelt.sweeps.record import read_asked
from fibermelt.sweeps.store import CaseStore, stage_folder

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study
    from fibermelt.engine.parts import Chain
    from fibermelt.sweeps.design import Sweep
    from fibermelt.sweeps.store import Failure

__all__ = ["list_plan", "list_unneeded", "remove_unneeded", "sweep_status"]


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
        them are ``"kept"`` in the folder, and ``"stored"`` there by now, how many start ``"warm"``
        from a neighbour's or are ``"scaled"`` from it, and ``"levels"``: how many must come one
        after the other; ``"estimate"``: as `fibermelt.sweeps.cost.Estimate` has it, with the
        ``"workers"`` that it is for; ``"each"``: every case with its ``"point"``, its
        ``"stages"`` and its ``"status"``.
    """
    plan = plan_sweep(sweep, study, chain)
    cases = CaseStore(directory)
    each = _each(plan, cases.refresh(), cases.failures())
    pending = [plan.cases[case["case"] - 1] for case in each if case["status"] == "pending"]
    counts = Counter(case["status"] for case in each)
    kept = Counter(job.stage for job in plan.jobs.values())
    stored = Counter(
        job.stage
        for job in plan.jobs.values()
        if stage_folder(directory, job.stage, job.key).is_dir()
    )
    return {
        "cases": len(each),
        **{name: counts[name] for name in ("done", "failed", "pending")},
        "shape": list(sweep.shape),
        "sampled": {
            key: told
            for key, entry in (study.sweep or {}).items()
            if (told := distribution_told(key, entry))
        },
        "stages": {
            name: {
                "results": count,
                "kept": kept[name],
                "stored": stored[name],
                **_warm(plan, name),
            }
            for name, count in plan.shared().items()
        },
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


def _warm(plan: Plan, stage: str) -> dict[str, int]:
    """Return how many results of a stage start from another one, if any do."""
    jobs = [job for job in plan.jobs.values() if job.stage == stage]
    if not any(job.neighbour for job in jobs):
        return {}
    scaled = sum(job.is_scaled for job in jobs)
    return {
        "warm": sum(bool(job.neighbour) for job in jobs) - scaled,
        "scaled": scaled,
        "levels": 1 + max(plan.level(job.key) for job in jobs),
    }


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
