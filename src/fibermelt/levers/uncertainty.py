"""How sure a severity is: each source of doubt as the factor by which it may be off.

What is cheap is computed, of the run's own results or as a case beside it; what is not is stated,
with where it was computed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fibermelt.levers.cases import Case

__all__ = ["doubts", "uncertainty_of"]

ISOTHERM = 2.0
"""Factor by which vapor pressures at one moisture differ between the sources of a card: of water
in ABS the humidity's slope and what filaments take up (0.17 to 0.75 %) leave as much."""

LENGTH = 1.5
"""Factor of the aspect ratio: fibers in printed beads spread by about this around their mean."""


def doubts(values: Mapping[str, Any], moisture: float) -> dict[str, list[dict[str, float]]]:
    """Return the changed studies whose spread is a doubt, by what is doubted.

    Parameters
    ----------
    values : mapping
        The resolved study.
    moisture : float
        The run's: by Henry's law a vapor pressure that is off by a factor is a moisture that is.
    """
    aspect = float(values["fiber.aspect_ratio"])
    return {
        "card": [{"voids.moisture": moisture * factor} for factor in (1 / ISOTHERM, ISOTHERM)],
        "aspect ratio": [
            {"fiber.aspect_ratio": max(1.0, aspect * factor)} for factor in (1 / LENGTH, LENGTH)
        ],
    }


def spread(base: float, others: Sequence[float]) -> float | None:
    """Return the largest factor between a severity and others; None where one of them is nothing.

    What vanishes has no factor: it is told as it is.
    """
    factors = [max(one / base, base / one) for one in others if one > 0.0 and base > 0.0]
    return max(factors, default=None)


def uncertainty_of(
    voids: Mapping[str, Any], base: Case, computed: Mapping[str, Sequence[Case]]
) -> list[dict[str, Any]]:
    """Return every source of doubt and its factor, the largest first.

    Parameters
    ----------
    voids : mapping
        What summary.json says of voids.
    base : Case
        The run itself.
    computed : mapping
        The cases of `doubts`, by what is doubted.
    """
    found = [
        {"source": name, "factor": spread(base.fibers, [case.fibers for case in cases])}
        for name, cases in computed.items()
    ]
    return sorted(found, key=lambda one: -(one["factor"] or 1.0))
