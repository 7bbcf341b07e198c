"""How the quantiles of a population are told: their rule, and what they are shares of."""

from __future__ import annotations

from fibermelt.sweeps.table import Varied

__all__ = ["QUANTILE_RULE", "weighing_told"]

QUANTILE_RULE = (
    "Each case stands in the middle of its share, and quantiles are linear between cases "
    "(Hazen's rule)."
)

MEANINGS = {
    "fiber.aspect_ratio": "of fibers of one width, shares of the fiber length and volume",
    "fiber.half_length": "shares of the fiber length",
}
"""What weighing by a key gives shares of, where the cases are counted by number."""


def weighing_told(weighing: Varied) -> str:
    """Return how cases are weighed, and what shares that gives.

    Parameters
    ----------
    weighing : Varied
        What a case is weighed by.
    """
    meaning = MEANINGS.get(weighing.keys[0])
    return f"each weighed by its {weighing.title}" + (f" ({meaning})" if meaning else "")
