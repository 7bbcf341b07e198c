"""Studies beside a finished run: each with some other settings, solved, and what it comes to.

They are a sweep in the run's folder, ``DIR/levers``: what the run has stored is theirs too, flows
start from the run's, they are solved on all cores, and what is there is not computed again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.engine.stages import keys
from fibermelt.engine.store import Store
from fibermelt.errors import ConfigError
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.collect import collect_sweep
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.runner import run_sweep

if TYPE_CHECKING:
    from pathlib import Path

    from fibermelt.engine.progress import Observer
    from fibermelt.engine.tables import Tables

__all__ = ["FOLDER", "Case", "compare"]

FOLDER = "levers"
"""Where they lie in the folder of the run."""

PARTS = ["voids"]
"""What is computed of each: what its answer rests on, nothing to look at."""

SEVERITY = {"fibers": "severity_fibers", "melt": "severity_melt", "void_fraction": "void_fraction"}
"""What is told of each, and the quantities that have it."""


@dataclass(frozen=True)
class Case:
    """What a study comes to; NaN where it has no answer, and why.

    Parameters
    ----------
    fibers, melt : float
        Severity: growth exponents of the melt, and of what fibers add to it.
    void_fraction : float
        Of the bead.
    reason : str
        Why there is no answer.
    """

    fibers: float = np.nan
    melt: float = np.nan
    void_fraction: float = np.nan
    reason: str = ""


def compare(
    directory: Path,
    study: Mapping[str, Any],
    changes: Sequence[Mapping[str, float]],
    *,
    workers: int | None = None,
    observer: Observer | None = None,
) -> list[Case]:
    """Return what a finished run comes to, and then what each of some changed studies does.

    Parameters
    ----------
    directory : Path
        The run's folder.
    study : mapping
        The run's study as tables, resolved.
    changes : sequence of mapping
        For each other study the keys that differ and their values, in SI.
    workers : int, optional
        As in `fibermelt.sweeps.runner.run_sweep`.
    observer : Observer, optional
        Who is told how it goes.

    Returns
    -------
    list of Case
        The run itself, and one for each of ``changes``, in their order.
    """
    own = {"study.parts": PARTS}
    values = load_study(study, own).config.values()
    refused = [_refusal(study, change) for change in changes]
    valid = [change for change, reason in zip(changes, refused, strict=True) if not reason]
    varied = sorted({key for change in valid for key in change})
    rows = [[change.get(key, values[key]) for key in varied] for change in ({}, *valid)]
    swept = load_study(study, own, {", ".join(varied): rows})
    folder = directory / FOLDER
    _lend(directory, folder, swept.config)
    run_sweep(read_sweep(swept), swept, folder, CHAIN, workers=workers, observer=observer)
    found = collect_sweep(folder)
    columns = {told: found[name].to_numpy() for told, name in SEVERITY.items() if name in found}
    reasons = found["reason"].to_numpy() if "reason" in found else [""] * len(rows)
    solved = [
        Case(**{told: float(column[k]) for told, column in columns.items()}, reason=str(reasons[k]))
        for k in range(len(rows))
    ]
    base, others = solved[0], iter(solved[1:])
    return [base, *(Case(reason=reason) if reason else next(others) for reason in refused)]


def _refusal(study: Mapping[str, Any], change: Mapping[str, float]) -> str:
    """Return why a changed study cannot be, or nothing."""
    try:
        load_study(study, {"study.parts": PARTS, **change})
    except ConfigError as error:
        return str(error)
    return ""


def _lend(source: Path, target: Path, config: Tables) -> None:
    """Give a folder what another has stored of the stages of a study."""
    values = config.values()
    stages = CHAIN.needed(PARTS, values)
    found, store = Store.open(source), Store.open(target)
    for name, key in keys(stages, values).items():
        record = found.find(name, key)
        if record is not None and store.find(name, key) is None:
            store.save(record, found.load(record))
