"""What is stored of the paper's claims."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

# fmt: off
QUANTITIES = declared(
    Q("claim", "claim", "1", "name of the claim, as in data/claims.toml", swept="kept"),
    Q("claim_value", "claim", "1", "what it is judged by, in its unit; NaN if not to be had"),
    Q("claim_missing", "claim", "1", "why it is not to be had"),
)
# fmt: on
"""What this part stores, by name."""
