"""The verification ladder: what fibermelt computes, against what is known by other ways.

Exact solutions, observed orders of convergence, and independent paths against one another, each a
number with a bound that was stated before. `fibermelt verify` climbs it on a user's own machine;
`fibermelt.verify.rungs.LADDER` has all there is to climb. A longer list, with what was measured
while developing, is in docs/verification.md.
"""

from __future__ import annotations

from fibermelt.verify.ladder import (
    LADDER_VERSION,
    Check,
    Expectation,
    Rung,
    as_dataset_rows,
    below,
    chosen,
    climb,
    order,
)

__all__ = [
    "LADDER_VERSION",
    "Check",
    "Expectation",
    "Rung",
    "as_dataset_rows",
    "below",
    "chosen",
    "climb",
    "order",
]
