"""A study, as a value: every parameter of the chain in SI, declared once with its source."""

from __future__ import annotations

from fibermelt.engine.tables import tables_of
from fibermelt.study.parts import parts

__all__ = ["Config"]

Config = tables_of(parts())
"""A study: what `fibermelt run` is given, resolved."""
