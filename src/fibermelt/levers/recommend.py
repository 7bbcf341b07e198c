"""A recommendation: one complete setting, made of the steps that help and cost no output."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from fibermelt.levers.steps import COSTS_NOTHING
from fibermelt.parts.voids.answer import MOISTURE, NO_CHANGE

if TYPE_CHECKING:
    from fibermelt.levers.cases import Case
    from fibermelt.levers.steps import Step

__all__ = ["WORTH", "proposals", "ratio"]

NOTHING = 0.05
"""Severity below which there is nothing to take a share of: a nucleus grows by a twentieth."""

WORTH = 0.9
"""What must be left at most by settings beside drying: a smaller gain cannot be promised by a model
that is known to a factor of two."""


def ratio(case: Case, base: Case, of: Literal["fibers", "melt"] = "fibers") -> float | None:
    """Return what is left of a severity; None where there was next to none, or is no answer."""
    left, before = case.beside(base, of)
    return left / before if before > NOTHING and not math.isnan(left) else None


def proposals(
    weighed: Sequence[tuple[Step, Case]],
    base: Case,
    dried: Mapping[str, float],
    values: Mapping[str, Any],
) -> list[dict[str, float]]:
    """Return the settings to try as a recommendation, the boldest first.

    A melt that may boil is dried; besides, each lever that costs neither output nor another
    compound is moved the way that leaves clearly less of what the fibers add: all of them, then
    those that were seen to help, then the best of these, then none. What is not worth a flow of its
    own by the product of what each leaves is not tried.

    Parameters
    ----------
    weighed : sequence of (Step, Case)
        Each step that was run, and what it came to, of the dried melt.
    base : Case
        The run itself, of the dried melt.
    dried : mapping
        The moisture that it has to be dried to, if it has.
    values : mapping
        The resolved study.
    """
    seen: list[tuple[float, Mapping[str, float]]] = []
    turned: list[tuple[float, Mapping[str, float]]] = []
    for step, case in weighed:
        left = ratio(case, base)
        if left is None or step.costs != COSTS_NOTHING or MOISTURE in step.settings:
            continue
        if left < NO_CHANGE:
            seen.append((left, step.settings))
        elif left > 1.0 / NO_CHANGE:
            turned.append((1.0 / left, step.mirrored(values)))
    tried = [[*seen, *turned], seen, sorted(seen, key=lambda one: one[0])[:1], []]
    found = [
        dict(dried) | _together(several)
        for several in tried
        if not several or math.prod(left for left, _ in several) < WORTH
    ]
    return [one for k, one in enumerate(found) if one and one not in found[:k]]


def _together(several: Sequence[tuple[float, Mapping[str, float]]]) -> dict[str, float]:
    """Return the settings of several steps, the strongest first; of one key the strongest."""
    found: dict[str, float] = {}
    for _, settings in sorted(several, key=lambda one: one[0]):
        found |= {key: value for key, value in settings.items() if key not in found}
    return found
