"""Every quantity of the results, as the parts declare them."""

from __future__ import annotations

from importlib import import_module

from fibermelt.engine.quantities import declared
from fibermelt.study.parts import HOMES

__all__ = ["QUANTITIES"]

QUANTITIES = declared(
    *(one for home in HOMES for one in import_module(f"{home}.quantities").QUANTITIES.values())
)
"""By name, in the order of the parts."""
