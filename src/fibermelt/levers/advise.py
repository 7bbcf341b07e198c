"""What helps a finished run against voids, how much each lever does, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan
from typing import TYPE_CHECKING, Any

from fibermelt.engine.parameters import declarations
from fibermelt.engine.results import study_of
from fibermelt.errors import StoreError
from fibermelt.levers.cases import Case, compare
from fibermelt.levers.recommend import WORTH, proposals, ratio
from fibermelt.levers.steps import Step, steps_of
from fibermelt.levers.uncertainty import doubts, uncertainty_of
from fibermelt.parts.voids.answer import MOISTURE, dry_enough
from fibermelt.study.config import Config
from fibermelt.study.loading import resolve

if TYPE_CHECKING:
    from pathlib import Path

    from fibermelt.engine.finished import Finished
    from fibermelt.engine.progress import Observer

__all__ = ["advise"]

NEEDED = {"severity", "rest", "void_fraction", "severity_error"}
"""What a summary has to say of voids."""

DIGITS = 4
"""Significant digits of a setting: a printer has no more."""


def advise(
    directory: Path,
    finished: Finished,
    *,
    workers: int | None = None,
    observer: Observer | None = None,
) -> dict[str, Any]:
    """Return what each lever does to the voids of a finished run, and what to set.

    The flows beside it are solved, not scaled, from the run's own, on all cores; they stay in
    ``DIR/levers``, so that asking again takes no time.

    Parameters
    ----------
    directory : Path
        Its results folder.
    finished : Finished
        What it holds: a run with voids.
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
        ``"dry_ratio"``, what is left of the fibers' once a melt that boils is dried;
        ``"void_fraction"``; ``"costs"``.
        ``"recommendation"``: ``"settings"``, keys and values in SI, empty where nothing helps;
        ``"written"``, as a study writes them; the ratios and the void fraction that these came to
        when they were run, and ``"verified"``, that they were.
        ``"uncertainty"``: ``"source"``, ``"factor"`` on what fibers add, ``"basis"``, the largest
        first.

    Raises
    ------
    StoreError
        If the run is of an older fibermelt, which did not tell what this needs.
    """
    voids = finished.summary["voids"]
    if not set(voids) >= NEEDED:
        msg = (
            f"{directory}: the run was made by an older fibermelt, which did not tell how far "
            "voids grow: run its study again into the same folder"
        )
        raise StoreError(msg)
    study = study_of(finished.results)
    moisture = float(voids["moisture"])
    values = {**resolve(study).values(), MOISTURE: moisture}
    steps, doubted = steps_of(values), doubts(values, moisture)
    target = dry_enough(voids)
    dried = {} if target is None else {MOISTURE: target}
    solved: dict[tuple[tuple[str, float], ...], Case] = {}

    def solve(*changes: Mapping[str, float]) -> None:
        """Solve changed studies, those before among them: the folder's sweep is of all."""
        asked = list(dict.fromkeys([*solved, *(tuple(one.items()) for one in changes)]))
        if solved and len(asked) == len(solved):
            return
        several = [dict(one) for one in asked if one]
        cases = compare(directory, study, several, workers=workers, observer=observer)
        solved.update(zip([(), *filter(None, asked)], cases, strict=True))

    def case_of(*changes: Mapping[str, float]) -> Case:
        return solved[tuple({k: v for one in changes for k, v in one.items()}.items())]

    moved = [step.settings for step in steps]
    others = [change for several in doubted.values() for change in several]
    solve(*moved, dried, *(dried | dict(one) for one in moved), *others)
    base, once_dry = case_of(), case_of(dried)
    weighed = [(step, case_of(dried, step.settings)) for step in steps]
    recommended: dict[str, float] = {}
    for settings in proposals(weighed, once_dry, dried, values):
        solve(settings)
        found = case_of(settings)
        fibers, of_dry = found.beside(once_dry, "fibers")
        gas, gas_of_dry = found.beside(once_dry, "gas")
        is_worth = fibers < WORTH * of_dry
        if settings == dried or (is_worth and not gas > gas_of_dry):
            recommended = settings
            break
    outcome = case_of(recommended)
    levers = [
        {
            **_lever(step, case_of(step.settings), base, values),
            "dry_ratio": _once_dry(step, case, once_dry) if dried else None,
        }
        for step, case in weighed
    ]
    return {
        "levers": sorted(levers, key=_left),
        "recommendation": {
            "settings": recommended,
            "written": {key: _written(key, value) for key, value in recommended.items()},
            **_ratios(outcome, base),
            "void_fraction_before": _known(base.void_fraction),
            "verified": bool(recommended),
        },
        "uncertainty": uncertainty_of(
            voids,
            values,
            base,
            {name: [case_of(one) for one in several] for name, several in doubted.items()},
        ),
    }


def _left(lever: Mapping[str, Any]) -> float:
    left = lever["fibers_ratio"]
    return float("inf") if left is None else float(left)


def _lever(step: Step, case: Case, base: Case, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return one lever as it is told."""
    starts = [float(values[key]) for key in step.settings]
    ends = list(step.settings.values())
    several = len(ends) > 1
    # Keys that go together all go by one factor.
    by = (
        f"{100.0 * (ends[0] / starts[0] - 1.0):+.3g} %".replace("-", "−")
        if several
        else " to ".join(_written(key, one[0]) for key in step.settings for one in (starts, ends))
    )
    return {
        "lever": step.lever,
        "key": ", ".join(step.settings),
        "from": starts if several else starts[0],
        "to": ends if several else ends[0],
        "moved": f"{step.lever} {by}",
        **_ratios(case, base),
        "costs": step.costs,
        "reason": case.reason,
    }


def _ratios(case: Case, base: Case) -> dict[str, float | None]:
    """Return what is left of either severity, and the void fraction."""
    return {
        "fibers_ratio": ratio(case, base),
        "melt_ratio": ratio(case, base, "melt"),
        "void_fraction": _known(case.void_fraction),
    }


def _once_dry(step: Step, case: Case, dry: Case) -> float | None:
    """Return what is left of a dried melt's severity; moisture has no such share."""
    return None if MOISTURE in step.settings else ratio(case, dry)


def _known(value: float) -> float | None:
    return None if isnan(value) else value


def _written(key: str, value: float) -> str:
    """Return a setting as a study writes it."""
    return _KNOWN[key].text(value, DIGITS)


_KNOWN = {item.key: item for item in declarations(Config)}
