"""What a person should know of a study that is allowed, and perhaps not meant: a sentence each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.parts.melt.melt import melt_notes

if TYPE_CHECKING:
    from fibermelt.study.config import Config

__all__ = ["LONGEST_FIBER", "study_notes"]

LONGEST_FIBER = 0.1
"""Length of a fiber over that of the flow around it, or over that on which the gradient changes: a
fiber is followed as if the gradient were the same all along it, which errs by the square of this.
"""


def study_notes(config: Config) -> list[str]:
    """Return what `run`, `validate`, the summary and the page tell of a study's scales and melt."""
    return [*_long_fiber(config), *melt_notes(config)]


def _long_fiber(config: Config) -> list[str]:
    """Tell of a fiber that is no longer small beside the capillary, the gap or the bead."""
    flow, length = config.flow, 2 * config.fiber.half_length
    if flow.source != "deposition":
        return []
    across = {
        "the capillary (flow.capillary_width)": flow.capillary_width,
        "the gap (flow.gap)": flow.gap,
        "the bead (its height by mass balance)": flow.bead_height,
    }
    tight = [
        f"{length / size:.2g} of {what}"
        for what, size in across.items()
        if length > LONGEST_FIBER * size
    ]
    if not tight:
        return []
    return [
        f"a fiber is {length:.3g} m long, {', '.join(tight)}: above {LONGEST_FIBER:g} the flow "
        "changes along the fiber, and what it feels is only roughly that of its middle"
    ]
