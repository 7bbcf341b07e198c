"""What sweep.json says of a sweep, and the sweep that it stands for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fibermelt.engine.loading import Study
from fibermelt.errors import StoreError
from fibermelt.study.loading import resolve
from fibermelt.sweeps.design import read_sweep

if TYPE_CHECKING:
    from fibermelt.sweeps.design import Sweep
    from fibermelt.sweeps.plan import Plan
    from fibermelt.sweeps.store import CaseStore, Failure

__all__ = ["Asked", "AskedCase", "asked", "read_asked", "restored"]


@dataclass(frozen=True, slots=True)
class AskedCase:
    """One case, as sweep.json has it.

    Parameters
    ----------
    point : dict
        The parameters that vary, in SI.
    result : str
        Key of its numbers.
    stages : tuple of int
        Its stages, by their places in the list of all.
    """

    point: Mapping[str, Any]
    result: str
    stages: tuple[int, ...]


@dataclass(frozen=True)
class Asked:
    """A sweep, as sweep.json has it.

    Parameters
    ----------
    study : Study
        The study that holds it.
    axes : tuple of tuple of str
        The keys that vary, those together that vary together.
    shape : tuple of int
        Values on each axis of a grid, else the number of cases.
    is_grid : bool
        Whether every combination is there.
    is_cold : bool
        Whether no stage starts from the result of a neighbouring case.
    stages : tuple of (str, str, bool)
        Name and key of every stage of any case, and whether it is kept.
    cases : tuple of AskedCase
        All cases.
    """

    study: Study
    axes: tuple[tuple[str, ...], ...]
    shape: tuple[int, ...]
    is_grid: bool
    is_cold: bool
    stages: tuple[tuple[str, str, bool], ...]
    cases: tuple[AskedCase, ...]

    def failure(self, case: AskedCase, failures: Mapping[str, Failure]) -> Failure | None:
        """Return why a case has no numbers, or None if nothing is known against it."""
        keys = (self.stages[place][1] for place in case.stages)
        return next((failures[key] for key in keys if key in failures), None)


def asked(sweep: Sweep, study: Study, plan: Plan) -> dict[str, Any]:
    """Return what sweep.json says.

    Parameters
    ----------
    sweep, study, plan : Sweep, Study, Plan
        The sweep, the study that holds it, and what it comes to.
    """
    places: dict[str, int] = {}
    stages: list[list[Any]] = []
    cases = []
    for case in plan.cases:
        for name, key in case.keys.items():
            if key not in places:
                places[key] = len(stages)
                stages.append([name, key, key in plan.jobs])
        cases.append(
            {
                "id": case.id,
                "point": dict(case.point),
                "result": case.result,
                "stages": [places[key] for key in case.keys.values()],
            }
        )
    return {
        "name": study.name,
        "origin": study.origin,
        "tables": study.tables,
        # In the order of the axes, which JSON with sorted keys would lose.
        "sweep": list((study.sweep or {}).items()),
        "axes": [list(axis.keys) for axis in sweep.axes],
        "shape": list(sweep.shape),
        "is_grid": sweep.design == "grid",
        "is_cold": sweep.is_cold,
        "stages": stages,
        "cases": cases,
    }


def read_asked(cases: CaseStore) -> Asked:
    """Return the sweep that a results folder holds.

    Raises
    ------
    StoreError
        If it holds none, or one that is damaged.
    ConfigError
        If its study is none for this version of fibermelt.
    """
    content = cases.read_sweep()
    study = Study(
        name=content["name"],
        origin=content["origin"],
        config=resolve(content["tables"]),
        tables=content["tables"],
        sweep=dict(content["sweep"]),
    )
    return Asked(
        study=study,
        axes=tuple(tuple(keys) for keys in content["axes"]),
        shape=tuple(content["shape"]),
        is_grid=content["is_grid"],
        # None did where the file does not say.
        is_cold=content.get("is_cold", True),
        stages=tuple((name, key, kept) for name, key, kept in content["stages"]),
        cases=tuple(
            AskedCase(case["point"], case["result"], tuple(case["stages"]))
            for case in content["cases"]
        ),
    )


def restored(cases: CaseStore) -> tuple[Sweep, Study]:
    """Return the sweep that a results folder holds, to go on with.

    Raises
    ------
    StoreError
        If it holds none, one that is damaged, or one whose cases come out otherwise now.
    """
    found = read_asked(cases)
    sweep = read_sweep(found.study, cold=found.is_cold)
    then = [dict(case.point) for case in found.cases]
    now = [
        {key: list(value) if isinstance(value, tuple) else value for key, value in point.items()}
        for point in (case.point for case in sweep.stream())
    ]
    if then != now:
        msg = (
            f"{cases.directory}: this version of fibermelt, or of scipy, makes other cases of the "
            f"sweep: run fibermelt sweep STUDY --out {cases.directory} to begin it anew"
        )
        raise StoreError(msg)
    return sweep, found.study
