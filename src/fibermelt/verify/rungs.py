"""All rungs of the ladder, cheap ones first; importing this loads the finite elements."""

from __future__ import annotations

from fibermelt.verify import (
    fiber_cell,
    fiber_fields,
    fiber_forms,
    fiber_motion,
    flow,
    free_surface,
)
from fibermelt.verify.ladder import Rung

__all__ = ["LADDER"]

LADDER: tuple[Rung, ...] = (
    *fiber_forms.RUNGS,
    *fiber_fields.RUNGS,
    *fiber_motion.RUNGS,
    *fiber_cell.RUNGS,
    *free_surface.RUNGS,
    *flow.RUNGS,
)
