"""What a sweep comes to: its cases, the stages that they need, and which of these they share.

A stage is kept in the store, unless it costs less to compute than to store (`Stage.light_if`), or
is a last one of a case: of those only the numbers are kept (`fibermelt.sweeps.collection`).
Cases whose last stages are the same have the same results, whatever else varies.

A stage that can start from the result of another case (`Stage.compute_from`) gives, within its
error, another answer than from cold. So that a sweep ends alike whatever was finished first, or
died, who starts from whom is settled beforehand, from the parameters alone.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import canonical, digest
from fibermelt.engine.stages import keys, stage_parameters
from fibermelt.sweeps.collection import COLLECTION

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Value
    from fibermelt.engine.parts import Chain
    from fibermelt.engine.stages import Stage
    from fibermelt.sweeps.design import Sweep

    Array = NDArray[np.float64]

__all__ = ["FROM_NEIGHBOUR", "REACH", "Job", "Plan", "PlannedCase", "neighbours", "plan_sweep"]

FROM_NEIGHBOUR = " from a neighbour"
"""What is added to the name of a stage that starts from the result of another case."""

REACH = 0.3
"""Distance beyond which a start does not pay: one number 35 per cent higher, or 26 lower."""

DIGITS = 9
"""Decimals of a distance: those of a grid are alike on every machine, whatever its logarithm."""


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
        Key of the same stage of another case, from which it starts and which starts from cold;
        empty: it starts from cold itself.
    """

    stage: str
    key: str
    case: PlannedCase
    needs: tuple[str, ...]
    neighbour: str = ""

    @property
    def result_key(self) -> str:
        """Return the key of what is computed."""
        return self.key

    @property
    def kind(self) -> str:
        """Return what is done, in words: what has one kind costs about the same."""
        return f"{self.stage}{FROM_NEIGHBOUR}" if self.neighbour else self.stage


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
        """Return a case with the neighbour of every stage of some cases, by the stage's key."""
        found = (self.jobs.get(key) for case in cases for key in case.keys.values())
        return {job.key: self.jobs[job.neighbour].case for job in found if job and job.neighbour}

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
            stage.multiple(stage_parameters(stage, {**base, **job.case.changes})).reference
            for job in mine
        ]
        for job, place in zip(mine, neighbours(read), strict=True):
            if place is not None:
                warmed[job.key] = replace(job, neighbour=mine[place].key)
    return warmed


def neighbours(parameters: Sequence[Mapping[str, Any]]) -> list[int | None]:
    """Return for each of some stages the place of that which it starts from, None for from cold.

    Whoever is started from starts from cold: all others can be computed at once. Of what is left
    the outermost is taken, and all within reach of that one which lies furthest inwards from it.

    Parameters
    ----------
    parameters : sequence of mapping
        What decides the result of each, resolved, in SI.

    Notes
    -----
    The distance is Euclid's over the logarithms of all numbers that are positive throughout, and
    over other numbers in parts of their largest absolute value. What is no number must be equal.
    """
    import numpy as np  # noqa: PLC0415  lazy: the command line's help needs none of it

    groups: dict[Any, list[int]] = {}
    for place, values in enumerate(parameters):
        words = tuple((k, "" if _is_number(v) else repr(v)) for k, v in sorted(values.items()))
        groups.setdefault(words, []).append(place)
    found: list[int | None] = [None] * len(parameters)
    for group in groups.values():
        points, left = _coordinates([parameters[place] for place in group]), np.arange(len(group))
        while left.size:
            middle = points[left].mean(axis=0)
            inwards = _distances(points[left], middle)
            near = _distances(points[left], points[left[np.argmax(inwards)]]) <= REACH
            root = left[near][np.argmin(inwards[near])]
            reached = _distances(points[left], points[root]) <= REACH
            for place in left[reached & (left != root)]:
                found[group[place]] = group[root]
            left = left[~reached]
    return found


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _coordinates(several: Sequence[Mapping[str, Any]]) -> Array:
    """Return points (n, k) whose distances are those of parameters, of what varies."""
    import numpy as np  # noqa: PLC0415  lazy: see above

    rows = [[v for _, v in sorted(values.items()) if _is_number(v)] for values in several]
    points = np.array(rows, dtype=float).reshape(len(rows), -1)
    points = points[:, np.any(points != points[:1], axis=0)]
    positive = np.all(points > 0, axis=0)
    points[:, positive] = np.log(points[:, positive])
    points[:, ~positive] /= np.abs(points[:, ~positive]).max(axis=0, initial=1e-300)
    return points


def _distances(points: Array, one: Array) -> Array:
    import numpy as np  # noqa: PLC0415  lazy: see above

    distances: Array = np.round(np.sqrt(((points - one) ** 2).sum(axis=1)), DIGITS)
    return distances


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
