"""Studies beside a finished run: each with some other settings, solved, and what it comes to.

They are a sweep in the run's folder, ``DIR/levers``: what the run has stored is theirs too, flows
start from the run's, they are solved on all cores, and what is there is not computed again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fibermelt.engine.stages import keys
from fibermelt.engine.store import Store
from fibermelt.errors import ConfigError
from fibermelt.parts.voids.profile import gas_share
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.collect import collect_sweep
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.runner import run_sweep

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from fibermelt.engine.progress import Observer
    from fibermelt.engine.tables import Tables

    Array = NDArray[np.float64]

__all__ = ["FOLDER", "Case", "compare"]

FOLDER = "levers"
"""Where they lie in the folder of the run."""

PARTS = ["voids"]
"""What is computed of each: what its answer rests on, nothing to look at."""

ALONE = {"numerics.isotropic_angles": 40}
"""Fewer fibers that enter at random: none of it rests on them."""

NEEDED = ("void_added_exponent", "void_exponent", "void_gas")
"""What is told of each streamline of a case."""

NO_LINES = np.full(1, np.nan)


@dataclass(frozen=True, eq=False)
class Case:
    """What a study comes to on each streamline; NaN where there is no answer, and why.

    Parameters
    ----------
    fibers, melt : (streamline,) array
        Severity: growth exponents of what fibers add to the melt's, and of the melt itself.
    gas : (streamline,) array
        Volume of bubbles over that of melt and fibers at the end of the swell.
    reason : str
        Why there is no answer.
    """

    fibers: Array = field(default_factory=NO_LINES.copy)
    melt: Array = field(default_factory=NO_LINES.copy)
    gas: Array = field(default_factory=NO_LINES.copy)
    reason: str = ""

    @property
    def void_fraction(self) -> float:
        """Return the void content of the bead."""
        return float(gas_share(_mean(self.gas, ~np.isnan(self.gas))))

    def beside(self, base: Case, of: Literal["fibers", "melt", "gas"]) -> tuple[float, float]:
        """Return the means of this and of another, over the streamlines that both keep.

        A streamline that passes a sharp corner more closely at one setting than at another counts
        in one of them only: it is no part of what the setting does.
        """
        here, there = getattr(self, of), getattr(base, of)
        if here.shape != there.shape:  # one of them has no answer
            return np.nan, np.nan
        both = ~np.isnan(here) & ~np.isnan(there)
        return _mean(here, both), _mean(there, both)


def _mean(values: Array, kept: NDArray[np.bool_]) -> float:
    return float(np.mean(values[kept])) if kept.any() else np.nan


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
    own = {"study.parts": PARTS, **ALONE}
    refused, cases = [], [load_study(study, own).config.values()]
    for change in changes:
        try:
            cases.append(load_study(study, {**own, **change}).config.values())
        except ConfigError as error:
            refused.append(str(error))
        else:
            refused.append("")
    varied = sorted({key for change in changes for key in change})
    # Of each the values that it has itself: a printer's nozzle takes its land with it.
    rows = [[values[key] for key in varied] for values in cases]
    swept = load_study(study, own, {", ".join(varied): rows})
    folder = directory / FOLDER
    _lend(directory, folder, swept.config)
    run_sweep(read_sweep(swept), swept, folder, CHAIN, workers=workers, observer=observer)
    found = collect_sweep(folder)
    reasons = found["reason"].to_numpy() if "reason" in found else [""] * len(rows)
    if "near_singularity" in found:
        by_line = found[[*NEEDED, "near_singularity"]].transpose(..., "streamline")
        kept = by_line["near_singularity"].to_numpy() == 0  # NaN of a case that failed
        fibers, melt, gas = (
            np.where(kept, values.to_numpy(), np.nan)
            for values in (
                by_line["void_added_exponent"],
                by_line["void_exponent"].sel(void_basis="melt", drop=True),
                by_line["void_gas"].sel(void_station="swell", drop=True),
            )
        )
        solved = [
            Case(added, own, bubbles, str(reason))
            for added, own, bubbles, reason in zip(fibers, melt, gas, reasons, strict=True)
        ]
    else:
        solved = [Case(reason=str(reason)) for reason in reasons]
    base, others = solved[0], iter(solved[1:])
    return [base, *(Case(reason=reason) if reason else next(others) for reason in refused)]


def _lend(source: Path, target: Path, config: Tables) -> None:
    """Give a folder what another has stored of the stages of a study."""
    values = config.values()
    stages = CHAIN.needed(PARTS, values)
    found, store = Store.open(source), Store.open(target)
    for name, key in keys(stages, values).items():
        record = found.find(name, key)
        if record is not None and store.find(name, key) is None:
            store.save(record, found.load(record))
