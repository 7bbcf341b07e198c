"""A recommendation: one complete setting, made of the steps that help and cost no output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import ROUND_DOWN, Context
from math import isnan
from typing import TYPE_CHECKING, Any

from fibermelt.levers.steps import COSTS_NOTHING

if TYPE_CHECKING:
    from fibermelt.levers.cases import Case
    from fibermelt.levers.steps import Step

__all__ = ["HELPS", "proposals", "ratio"]

HELPS = 0.99
"""Share of the severity that must be left at most for a step to count as one that helps: what is
nearer to one lies within the error of the flow."""

BELOW_BOILING = 0.5
"""Part of the boiling moisture that a melt is dried to: half leaves room for what a dryer and an
isotherm are off."""

MOISTURE = "voids.moisture"


def ratio(case: float, base: float) -> float | None:
    """Return what is left of a severity; None where there is none to begin with, or no answer."""
    return case / base if base > 0.0 and not isnan(case) else None


def proposals(
    weighed: Sequence[tuple[Step, Case]],
    base: Case,
    rest: Mapping[str, Any],
    moisture: float,
) -> list[dict[str, float]]:
    """Return the settings to try as a recommendation, the boldest first.

    A melt that boils is dried; besides, of each lever that costs neither output nor another
    material the step that leaves least of what the fibers add, where it leaves clearly less: all
    together, then drying and the best of them, which do not stand in one another's way.

    Parameters
    ----------
    weighed : sequence of (Step, Case)
        Each step that was run, and what it came to.
    base : Case
        The run itself.
    rest : mapping
        The melt at rest: ``"boils"`` and ``"boiling_moisture"``.
    moisture : float
        The run's.
    """
    best: dict[str, tuple[float, Step]] = {}
    for step, case in weighed:
        left = ratio(case.fibers, base.fibers)
        if left is None or step.costs != COSTS_NOTHING or left > HELPS:
            continue
        if step.lever not in best or left < best[step.lever][0]:
            best[step.lever] = left, step
    chosen = [step.settings for _, step in sorted(best.values(), key=lambda one: one[0])]
    dried: dict[str, float] = {}
    if rest["boils"] and rest["boiling_moisture"] is not None:
        dried = {MOISTURE: _rounded(BELOW_BOILING * float(rest["boiling_moisture"]))}
    others = [dict(one) for one in chosen if not (dried and MOISTURE in one)]
    together = dried | {key: value for one in reversed(others) for key, value in one.items()}
    tried = [together, dried | (others[0] if others else {}), dried]
    return [one for k, one in enumerate(tried) if one and one not in tried[:k]]


def _rounded(share: float) -> float:
    """Return a moisture with two digits, not above it."""
    return float(Context(prec=2, rounding=ROUND_DOWN).create_decimal_from_float(share))
