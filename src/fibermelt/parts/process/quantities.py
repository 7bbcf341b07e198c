"""What this part stores: nothing; its values are those of other tables."""

from __future__ import annotations

from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

QUANTITIES = declared()
"""What this part stores, by name."""
