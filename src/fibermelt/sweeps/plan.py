"""What a sweep comes to: its cases, the stages that they need, and which of these they share.

A stage is kept in the store, unless it costs less to compute than to store (`Stage.light_if`), or
is a last one of a case: of those only the numbers are kept (`fibermelt.sweeps.collection`).
Cases whose last stages are the same have the same results, whatever else varies.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from fibermelt.engine.files import canonical, digest
from fibermelt.engine.named import named
from fibermelt.engine.stages import keys, stage_parameters
from fibermelt.sweeps.collection import COLLECTION
from fibermelt.sweeps.starts import neighbours

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Value
    from fibermelt.engine.parts import Chain
    from fibermelt.engine.stages import Stage
    from fibermelt.sweeps.design import Sweep

__all__ = ["FROM_NEIGHBOUR", "Job", "Plan", "PlannedCase", "plan_sweep"]

FROM_NEIGHBOUR = " from a neighbour"
"""What is added to the name of a stage that starts from the result of another case."""


@dataclass(frozen=True, slots=True)
class PlannedCase:
    """One case, as small as it can be: there may be very many.

    Parameters
    ----------
    index : int
        Its place in the sweep, from 0.
    id : str
        A name that depends on its resolved study only.
    point : dict
        The parameters that vary, resolved, in SI.
    changes : dict
        All that differs from the study without its sweep.
    keys : dict
        Keys of its stages by their names, inputs first.
    kept : tuple of str
        Names of those of its stages that are kept in the store.
    result : str
        Key of its numbers.
    """

    index: int
    id: str
    point: Mapping[str, Value]
    changes: Mapping[str, Value]
    keys: Mapping[str, str]
    kept: tuple[str, ...]
    result: str

    @property
    def result_key(self) -> str:
        """Return the key of what is computed."""
        return self.result


@dataclass(frozen=True, slots=True)
class Job:
    """A stage that is to be kept, for all cases that need it.

    Parameters
    ----------
    stage, key : str
        Its name and key.
    case : PlannedCase
        One of the cases that need it.
    needs : tuple of str
        Keys of the kept stages that must be there first.
    neighbour : str
        Key of the same stage of another case, from which it starts; empty: from cold.
    is_scaled : bool
        Whether it is the neighbour's result but for a scale (`Stage.but_for_scale`).
    """

    stage: str
    key: str
    case: PlannedCase
    needs: tuple[str, ...]
    neighbour: str = ""
    is_scaled: bool = False

    @property
    def result_key(self) -> str:
        """Return the key of what is computed."""
        return self.key

    @property
    def kind(self) -> str:
        """Return what is done, in words: what has one kind costs about the same."""
        start = " scaled" if self.is_scaled else FROM_NEIGHBOUR if self.neighbour else ""
        return f"{self.stage}{start}"


@dataclass(frozen=True)
class Plan:
    """A sweep, worked out.

    Parameters
    ----------
    base : dict
        The study without its sweep, resolved, in SI.
    cases : list of PlannedCase
        All cases, in the order of the sweep.
    jobs : dict
        The stages to keep by their keys, inputs first.
    """

    base: Mapping[str, Value]
    cases: list[PlannedCase]
    jobs: Mapping[str, Job] = field(default_factory=dict)

    def results(self) -> dict[str, PlannedCase]:
        """Return one case for each set of results: the first that has it."""
        found: dict[str, PlannedCase] = {}
        for case in self.cases:
            found.setdefault(case.result, case)
        return found

    def starts(self, cases: Iterable[PlannedCase]) -> dict[str, PlannedCase]:
        """Return a case with the neighbour of every stage of some cases, and theirs, by its key."""
        found: dict[str, PlannedCase] = {}
        left = list(cases)
        while left:
            for key in left.pop().keys.values():
                job = self.jobs.get(key)
                if job is not None and job.neighbour and key not in found:
                    found[key] = self.jobs[job.neighbour].case
                    left.append(found[key])
        return found

    def level(self, key: str) -> int:
        """Return how many stages come one after the other before a stage, by way of neighbours."""
        job = self.jobs[key]
        return 1 + self.level(job.neighbour) if job.neighbour else 0

    def shared(self) -> dict[str, int]:
        """Return how many different results of each stage the cases need, by its name."""
        seen: dict[str, set[str]] = {}
        for case in self.cases:
            for name, key in case.keys.items():
                seen.setdefault(name, set()).add(key)
        return {name: len(found) for name, found in seen.items()}


def plan_sweep(sweep: Sweep, study: Study, chain: Chain) -> Plan:
    """Return what a sweep comes to.

    Parameters
    ----------
    sweep : Sweep
        The sweep.
    study : Study
        The study that holds it.
    chain : Chain
        The stages that there are.

    Raises
    ------
    ConfigError
        If a case is no valid study.
    """
    base = study.config.values()
    parts = study.config.study.parts
    cases: list[PlannedCase] = []
    needed: dict[str, tuple[Stage, ...]] = {}
    users: dict[str, set[str]] = {}
    for case in sweep.stream():
        values = case.config.values()
        stages = chain.needed(parts, values)
        found = {name: sys.intern(key) for name, key in keys(stages, values).items()}
        last = _last(stages, values)
        result = digest(canonical({"collection": COLLECTION, **{n: found[n] for n in last}}))
        needed.setdefault(result, stages)
        for name in last:
            users.setdefault(found[name], set()).add(result)
        changes = {key: value for key, value in values.items() if value != base[key]}
        kept = tuple(stage.name for stage in stages if not stage.light_if(values))
        entry = PlannedCase(case.index, case.id, case.point, changes, found, kept, result)
        cases.append(entry)
    # A last stage is kept only where cases share it that are not the same in all others.
    own = {key for key, results in users.items() if len(results) == 1}
    cases = [
        replace(case, kept=tuple(name for name in case.kept if case.keys[name] not in own))
        for case in cases
    ]
    jobs = _jobs(base, cases, needed)
    return Plan(base, cases, jobs if sweep.is_cold else _warmed(base, jobs, chain))


def _warmed(base: Mapping[str, Value], jobs: Mapping[str, Job], chain: Chain) -> dict[str, Job]:
    """Return the stages to keep with the neighbours from which they start."""
    warmed = dict(jobs)
    for stage in chain.stages:
        mine = [job for job in jobs.values() if job.stage == stage.name]
        if stage.compute_from is None or len(mine) < 2:
            continue
        read = [
            dict(named(stage.but_for_scale)(stage_parameters(stage, {**base, **job.case.changes})))
            for job in mine
        ]
        for job, own, place in zip(mine, read, neighbours(read), strict=True):
            if place is not None:
                scaled = own == read[place]
                warmed[job.key] = replace(job, neighbour=mine[place].key, is_scaled=scaled)
    return warmed


def _last(stages: tuple[Stage, ...], values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return the names of the stages that feed no other one."""
    feeding = {name for stage in stages for name in stage.fed(values)}
    return tuple(stage.name for stage in stages if stage.name not in feeding)


def _jobs(
    base: Mapping[str, Value],
    cases: list[PlannedCase],
    needed: Mapping[str, tuple[Stage, ...]],
) -> dict[str, Job]:
    """Return the stages to keep, those of all cases' first stages before their second ones."""
    jobs: dict[str, Job] = {}
    for case in cases:
        fresh = [name for name in case.kept if case.keys[name] not in jobs]
        if not fresh:
            continue
        values = {**base, **case.changes}
        stages = {stage.name: stage for stage in needed[case.result]}
        for name in fresh:
            needs = _kept_inputs(stages[name], case, stages, values)
            jobs[case.keys[name]] = Job(name, case.keys[name], case, needs)
    return jobs


def _kept_inputs(
    stage: Stage,
    case: PlannedCase,
    stages: Mapping[str, Stage],
    values: Mapping[str, Value],
) -> tuple[str, ...]:
    """Return keys of the kept stages that feed a stage, also by way of those that are not kept."""
    found: list[str] = []
    for name in stage.fed(values):
        if name in case.kept:
            found.append(case.keys[name])
        else:
            found.extend(_kept_inputs(stages[name], case, stages, values))
    return tuple(dict.fromkeys(found))
