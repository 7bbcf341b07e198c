"""What a study may not say of its fibers, and what a person should know of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.errors import ConfigError
from fibermelt.parts.bead.config import Fiber, Numerics
from fibermelt.parts.bead.shape import Sizes
from fibermelt.parts.bead.shapes import SHAPES, choices
from fibermelt.parts.flow.config import SOLVED, Flow
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.melt.melt import melt_of, thins
from fibermelt.units import UM

if TYPE_CHECKING:
    from fibermelt.engine.tables import Tables

__all__ = ["LONGEST_FIBER", "fiber_notes", "refuse_fibers", "refuse_in_plane"]

LONGEST_FIBER = 0.1
"""Length of a fiber over that of the flow around it, or over that on which the gradient changes: a
fiber is followed as if the gradient were the same all along it, which errs by the square of this.
"""

LOCAL = 'fiber.melt = "local-viscosity", an approximation'
"""The way out of what has no answer in a melt that thins."""


def refuse_fibers(study: Tables) -> None:
    """Refuse fibers that see the walls, and those that have no answer in the study's melt.

    Raises
    ------
    ConfigError
        The key, the value, the bound and the way out.
    """
    source = study.table(Flow).source
    if source in SOLVED:
        _refuse_long(study.table(Fiber), study.table(Flow).capillary_width)
    if source == "deposition-3d":
        refuse_in_plane(study.table(Fiber).model, study.table(Fiber).directions)
    if not study.table(Melt).missing and thins(study.values()):
        _refuse_in_thinning_melts(study)


def refuse_in_plane(model: str, directions: str) -> None:
    """Refuse fibers that are known in a plane only, where the flow is in space."""
    if SHAPES[model].in_space and directions == "equal-area":
        return
    msg = (
        f'fiber.model = "{model}" with fiber.directions = "{directions}": the flow is in space, '
        f"and this fiber is known in a plane: say fiber.model = {choices('in_space')} and "
        'fiber.directions = "equal-area"'
    )
    raise ConfigError(msg)


def _refuse_long(fiber: Fiber, width: float) -> None:
    """Refuse a fiber that sees the walls: every model takes the flow for a uniform gradient."""
    half_length = fiber.half_length
    if not fiber.shape.has_cell and 2 * half_length >= width:
        msg = (
            f"fiber.half_length = {half_length:g} m is too long: the fiber does not fit across "
            f"the capillary, flow.capillary_width = {width:g} m; shorten the fiber"
        )
        raise ConfigError(msg)
    if not fiber.shape.has_cell or fiber.domain_size == "from-content":
        return
    cell = fiber.domain_size * half_length
    if cell >= width:
        msg = (
            f"fiber.half_length = {half_length:g} m is too long: its cell is {cell:g} m "
            f"across (fiber.domain_size = {fiber.domain_size:g} half-lengths), "
            f"flow.capillary_width = {width:g} m; shorten the fiber or lower fiber.domain_size"
        )
        raise ConfigError(msg)


def _refuse_in_thinning_melts(study: Tables) -> None:
    """Refuse what has no answer in a melt that thins."""
    fiber, melt = study.table(Fiber), f'in a melt that thins, melt.law = "{study.table(Melt).law}"'
    if fiber.melt == "local-viscosity":
        if fiber.path == "newton":
            msg = (
                f'fiber.path = "newton" with fiber.melt = "local-viscosity": has no answer '
                f'{melt}: take fiber.path = "superposition"'
            )
            raise ConfigError(msg)
        return
    if fiber.directions == "equal-area":
        msg = (
            f'fiber.directions = "equal-area": has no answer {melt}, where fibers are known in '
            f'the plane of the flow: take "in-plane", or {LOCAL}'
        )
        raise ConfigError(msg)
    shape, sizes = fiber.shape, Sizes(fiber.half_length, fiber.aspect_ratio, fiber.thickness_ratio)
    if not shape.thins:
        way = f'take "{shape.instead}", or {LOCAL}'
        msg = f'fiber.model = "{shape.name}": has no answer {melt}: {way}'
        raise ConfigError(msg)
    try:
        shape.refuse_in_melt(sizes, melt_of(study.table(Melt)).law)
    except ConfigError as error:
        msg = f'{error}; or take fiber.model = "{shape.instead}", or {LOCAL}'
        raise ConfigError(msg) from error
    if study.table(Numerics).cell_mesh == "paper":
        msg = (
            f'numerics.cell_mesh = "paper": is too coarse for a fiber {melt}: take "graded", '
            f"or {LOCAL}"
        )
        raise ConfigError(msg)


def fiber_notes(study: Tables) -> list[str]:
    """Tell of a fiber that is no longer small beside the capillary, the gap or the bead."""
    flow, length = study.table(Flow), 2 * study.table(Fiber).half_length
    if flow.source not in SOLVED:
        return []
    across = {
        "the capillary (flow.capillary_width)": flow.capillary_width,
        "the gap (flow.gap)": flow.gap,
    }
    if flow.source == "deposition":
        across["the bead (its height by mass balance)"] = flow.bead_height
    tight = [
        f"{length / size:.2g} of {what}"
        for what, size in across.items()
        if length > LONGEST_FIBER * size
    ]
    if not tight:
        return []
    return [
        f"a fiber is {UM * length:.3g} um long, {', '.join(tight)}: above {LONGEST_FIBER:g} "
        "the flow changes along the fiber, and what it feels is only roughly that of its middle"
    ]
