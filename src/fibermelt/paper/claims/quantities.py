"""What is stored of the paper's claims."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity, declared

__all__ = ["QUANTITIES"]

QUANTITIES = declared(
    Quantity("claim", "claim", "1", "name of the claim, as in data/claims.toml", swept="kept"),
    Quantity(
        "claim_value", "claim", "1", "what it is judged by, in its unit; NaN if not to be had"
    ),
    Quantity("claim_missing", "claim", "1", "why it is not to be had"),
)
"""What this part stores, by name."""
