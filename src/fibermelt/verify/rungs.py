"""All rungs of the ladder, cheap ones first; importing this loads the finite elements."""

from __future__ import annotations

from fibermelt.verify import (
    closures,
    distribution,
    fiber_cell,
    fiber_fields,
    fiber_forms,
    fiber_motion,
    flow,
    free_surface,
    melt,
    models,
    orientation,
    voids,
)
from fibermelt.verify.ladder import Rung

__all__ = ["LADDER"]

LADDER: tuple[Rung, ...] = (
    *fiber_forms.RUNGS,
    *fiber_fields.RUNGS,
    *fiber_motion.RUNGS,
    *fiber_cell.RUNGS,
    *closures.RUNGS,
    *distribution.RUNGS,
    *models.RUNGS,
    *orientation.RUNGS,
    *voids.RUNGS,
    *melt.RUNGS,
    *free_surface.RUNGS,
    *flow.RUNGS,
)
