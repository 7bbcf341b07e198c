"""The paper's claims over a sweep: which hold throughout, and which depend on what varied.

Every case of a sweep with the part ``claims`` has the quantities that its claims are judged by;
here they are judged, case by case, as those of a single run are, and compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fibermelt.paper.claims.judge import Claim, Judgement, claims, judge
from fibermelt.sweeps.table import SweepTable

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["SweptClaim", "depends_on", "swept_claims"]


@dataclass(frozen=True)
class SweptClaim:
    """What the cases of a sweep say of a claim.

    Parameters
    ----------
    claim : Claim
        The claim.
    judgements : tuple of Judgement or None
        What each case says; None where it has no answer.
    depends : tuple of str
        Names of what varied that turn the verdict when nothing else changes.
    """

    claim: Claim
    judgements: tuple[Judgement | None, ...]
    depends: tuple[str, ...]

    def count(self, verdict: str) -> int:
        """Return in how many cases a verdict is met."""
        return sum(one is not None and one.verdict == verdict for one in self.judgements)

    @property
    def finding(self) -> str:
        """Return in words what the sweep says of the claim."""
        holds, differs = self.count("holds"), self.count("differs")
        unknown = self.count("cannot be judged")
        if not holds + differs + unknown:
            return "no case has an answer"
        if not holds + differs:
            return "cannot be judged"
        if holds and differs:
            if self.depends:
                return f"depends on {', '.join(self.depends)}"
            return f"holds in {holds} of {holds + differs} cases"
        where = f"where it can be judged ({holds + differs} of {holds + differs + unknown} cases)"
        return f"{'holds' if holds else 'differs'} {where if unknown else 'throughout'}"


def swept_claims(collected: xr.Dataset, table: SweepTable) -> tuple[SweptClaim, ...]:
    """Return what a sweep says of every claim; nothing if it has none.

    Parameters
    ----------
    collected : xarray.Dataset
        The collected sweep.
    table : SweepTable
        Its table.
    """
    if "claim_value" not in collected or "claim" not in collected:
        return ()
    names = list(map(str, collected["claim"].to_numpy()))
    cases = len(table.status)
    values = collected["claim_value"].transpose(..., "claim").to_numpy().reshape(cases, -1)
    missing = collected["claim_missing"].transpose(..., "claim").to_numpy().reshape(cases, -1)
    found = []
    for claim in claims():
        if claim.id not in names:
            continue
        place = names.index(claim.id)
        judgements = tuple(
            judge(claim, float(values[case, place]), str(missing[case, place]))
            if table.status[case] == "done"
            else None
            for case in range(cases)
        )
        verdicts = [one.verdict if one is not None else "" for one in judgements]
        found.append(SweptClaim(claim, judgements, depends_on(table, verdicts)))
    return tuple(found)


def depends_on(table: SweepTable, verdicts: Sequence[str]) -> tuple[str, ...]:
    """Return what of a sweep turns a verdict when nothing else changes.

    Only ``"holds"`` against ``"differs"`` counts: a case that cannot be judged says nothing.

    Parameters
    ----------
    table : SweepTable
        The sweep. Samples differ in everything at once: of them nothing can be said.
    verdicts : sequence of str
        The verdict of each case.
    """
    return tuple(
        axis.title
        for place, axis in enumerate(table.axes)
        if any(
            {"holds", "differs"} <= {verdicts[case] for case in line}
            for line in _lines(table, place)
        )
    )


def _lines(table: SweepTable, place: int) -> Sequence[Sequence[int]]:
    """Return the sets of cases that differ in one parameter only."""
    if table.groups:
        return [(0, case) for case in table.groups[place][1:]]
    if table.is_sampled:
        return []
    grid = np.moveaxis(np.arange(len(table.status)).reshape(table.shape), place, -1)
    lines: list[list[int]] = grid.reshape(-1, grid.shape[-1]).tolist()
    return lines
