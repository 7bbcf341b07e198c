"""What parts of a study cannot do with of its melt, before anything is computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.errors import ConfigError
from fibermelt.parts.flow.config import SOLVED, Flow, Numerics
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.melt.melt import refuse_incomplete, refuse_unphysical, thins

if TYPE_CHECKING:
    from fibermelt.engine.tables import Tables

__all__ = ["NEWTONIAN", "WITHOUT_VISCOSITY", "refuse_melts"]

WITHOUT_VISCOSITY = "without a viscosity"
"""Trait of parts that ask no viscosity of the melt."""

NEWTONIAN = "Newtonian"
"""Trait of parts that begin with a Newtonian melt: the paper's section 2.3, what thinning changes.
"""

USUAL_RATE = 1e3
"""Rate [1/s] that a flow may have that is not known before its file is read."""


def refuse_melts(study: Tables) -> None:
    """Refuse a melt without its constants, or beyond all bounds, or that parts have no answer for.

    Raises
    ------
    ConfigError
        The key, the value, the bound and the way out.
    """
    melt, flow = study.table(Melt), study.table(Flow)
    if not all(WITHOUT_VISCOSITY in part.traits for part in study.asked):
        refuse_incomplete(melt)
        # The highest rate of deformation that the flow's mesh resolves at a lip.
        lip = study.table(Numerics).lip_edge * flow.capillary_width
        fastest = max(flow.bed_speed, flow.inlet_speed) / lip
        refuse_unphysical(melt, fastest if flow.source in SOLVED else USUAL_RATE)
    known = [part.name for part in study.asked if NEWTONIAN in part.traits]
    if known and not melt.missing and thins(study.values()):
        rest = ", ".join(f'"{name}"' for name in study.study.parts if name not in known)
        named = " and ".join(f'"{name}"' for name in known)
        msg = (
            f'study.parts: {named} has no answer in a melt that thins, melt.law = "{melt.law}": '
            f'say study.parts = [{rest}], or melt.law = "newtonian" and melt.viscosity'
        )
        raise ConfigError(msg)
