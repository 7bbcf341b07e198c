"""What is stored of the melt: its law as a curve, beside the streamlines."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

# fmt: off
QUANTITIES = declared(
    Q("law_rate", "law_point", "1/s", "rates of deformation at which the melt's law is drawn"),
    Q("law_viscosity", "law_point", "Pa s", "viscosity of the melt at them"),
)
# fmt: on
"""What this part stores, by name."""
