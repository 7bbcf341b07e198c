"""What helps a finished run against voids, how much each lever does, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.finished import read_finished
from fibermelt.engine.parameters import declarations
from fibermelt.engine.results import study_of
from fibermelt.errors import StoreError
from fibermelt.levers.cases import Case, compare
from fibermelt.levers.recommend import proposals, ratio
from fibermelt.levers.steps import Step, steps_of
from fibermelt.levers.uncertainty import doubts, uncertainty_of
from fibermelt.study.config import Config
from fibermelt.study.loading import resolve

if TYPE_CHECKING:
    from pathlib import Path

    from fibermelt.engine.progress import Observer

__all__ = ["advise"]

DIGITS = 4
"""Significant digits of a setting: a printer has no more."""


def advise(
    directory: Path, *, workers: int | None = None, observer: Observer | None = None
) -> dict[str, Any]:
    """Return what each lever does to the voids of a finished run, and what to set.

    The flows beside it are solved, not scaled, from the run's own, on all cores; they stay in
    ``DIR/levers``, so that asking again takes no time.

    Parameters
    ----------
    directory : Path
        Its results folder.
    workers : int, optional
        As in `fibermelt.sweeps.runner.run_sweep`.
    observer : Observer, optional
        Who is told how it goes.

    Returns
    -------
    dict
        ``"levers"``, a list, the one first that leaves least of what fibers add: ``"lever"``, a
        name; ``"key"``, ``"from"`` and ``"to"``, lists where several keys go together, in SI;
        ``"moved"``, the same in words; ``"fibers_ratio"`` and ``"melt_ratio"``, what is left of
        either severity, None where there is none or no answer, with ``"reason"``;
        ``"void_fraction"``; ``"costs"``.
        ``"recommendation"``: ``"settings"``, keys and values in SI, empty where nothing helps;
        ``"written"``, as a study writes them; the ratios and the void fraction that these came to
        when they were run, and ``"verified"``, that they were.
        ``"uncertainty"``: ``"source"`` and ``"factor"``, the largest first.

    Raises
    ------
    StoreError
        If the folder holds no finished run with voids.
    """
    finished = read_finished(directory)
    voids = finished.summary.get("voids")
    if voids is None:
        msg = f'{directory}: the run has no voids: name "voids" in study.parts and run it again'
        raise StoreError(msg)
    study = study_of(finished.results)
    moisture = float(voids["moisture"])
    values = {**resolve(study).values(), "voids.moisture": moisture}
    steps, doubted = steps_of(values), doubts(values, moisture)
    changes = _different(
        [
            *(dict(step.settings) for step in steps),
            *(change for several in doubted.values() for change in several),
        ]
    )

    def found(*more: Mapping[str, float]) -> tuple[Case, list[Case]]:
        base, *cases = compare(
            directory, study, [*changes, *more], workers=workers, observer=observer
        )
        return base, cases

    base, cases = found()
    by_change = {tuple(change.items()): case for change, case in zip(changes, cases, strict=True)}

    def case_of(change: Mapping[str, float]) -> Case:
        return by_change[tuple(change.items())]

    weighed = [(step, case_of(step.settings)) for step in steps]
    recommended, outcome = {}, base
    for settings in proposals(weighed, base, voids["rest"], moisture):
        _, (*_, case) = found(settings)
        if case.fibers < base.fibers or case.melt < base.melt:
            recommended, outcome = settings, case
            break
    levers = [_lever(step, case, base, values) for step, case in weighed]
    return {
        "levers": sorted(levers, key=_left),
        "recommendation": {
            "settings": recommended,
            "written": {key: _written(key, value) for key, value in recommended.items()},
            **_ratios(outcome, base),
            "verified": bool(recommended),
        },
        "uncertainty": uncertainty_of(
            voids,
            base,
            {name: [case_of(one) for one in several] for name, several in doubted.items()},
        ),
    }


def _different(changes: list[dict[str, float]]) -> list[dict[str, float]]:
    """Return each change once."""
    return [dict(one) for one in dict.fromkeys(tuple(change.items()) for change in changes)]


def _left(lever: Mapping[str, Any]) -> float:
    left = lever["fibers_ratio"]
    return float("inf") if left is None else float(left)


def _lever(step: Step, case: Case, base: Case, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return one lever as it is told."""
    starts = [float(values[key]) for key in step.settings]
    ends = list(step.settings.values())
    several = len(ends) > 1
    shown = " and ".join(
        f"{_written(key, start)} to {_written(key, end)}"
        for key, start, end in zip(step.settings, starts, ends, strict=True)
    )
    return {
        "lever": step.lever,
        "key": ", ".join(step.settings),
        "from": starts if several else starts[0],
        "to": ends if several else ends[0],
        "moved": f"{step.lever} {shown}",
        **_ratios(case, base),
        "costs": step.costs,
        "reason": case.reason,
    }


def _ratios(case: Case, base: Case) -> dict[str, float | None]:
    """Return what is left of either severity, and the void fraction."""
    known = case.void_fraction == case.void_fraction
    return {
        "fibers_ratio": ratio(case.fibers, base.fibers),
        "melt_ratio": ratio(case.melt, base.melt),
        "void_fraction": case.void_fraction if known else None,
    }


def _written(key: str, value: float) -> str:
    """Return a setting as a study writes it."""
    return _KNOWN[key].text(value, DIGITS)


_KNOWN = {item.key: item for item in declarations(Config)}
