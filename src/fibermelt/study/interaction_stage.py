"""The paper's section 2.5 for any fiber: its Fig. 14 and 15, each beside the paper's polynomial.

What computes is imported when the stage runs, so that a study that is stored costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fibermelt.study.orientation_stages import (
    distribution_angle,
    folgar_tucker,
    preferred_angle,
    stored_curve,
)
from fibermelt.study.stages import Inputs, Parameters, Say
from fibermelt.study.variables import labelled

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

    from fibermelt.fiber.stall_data import StallCurve

    Array = NDArray[np.float64]

__all__ = ["interaction_stage"]

CLOSURES = ("ORE", "ORF", "ORW3", "IBOF", "exact", "quadratic", "hybrid")
"""Closures whose preferred angles are drawn: the paper's, the fits in use, and the crude ones."""

DISTRIBUTION = "exact-pdf"
"""What stands for the distribution itself, which needs no closure."""

CONVENTIONS = ("standard", "paper")

INTERACTIONS = (0.003, 0.04, 19)
"""From, to, and how many interaction coefficients of a curve; Eq. 34 holds up to 0.041."""

SIZES = 121
"""Points of the stall angle's curve."""

SMALLEST_DRAWN, LONGEST_TIME, TIMES = 3.0, 20.0, 241
"""Smallest cell, longest time [1/gamma_dot] and points of a fiber's motion towards its stall."""


def interaction_stage(parameters: Parameters, inputs: Inputs, say: Say) -> xr.Dataset:
    """Compute stall angles against cells, preferred angles against C_I, and one against another."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    curve = stored_curve(inputs["stall"])
    interaction = np.geomspace(*INTERACTIONS)
    say(f"{len(CLOSURES)} closures and the distribution at {len(interaction)} C_I")
    aspect_ratio, closure = parameters["fiber.aspect_ratio"], parameters["interaction.closure"]
    angle = _preferred_angles(aspect_ratio, interaction)
    chosen = np.array(
        [
            [_angle(aspect_ratio, float(C_I), convention, closure) for C_I in interaction]
            for convention in CONVENTIONS
        ]
    )
    domain = np.array([[_domain_size(curve, one) for one in row] for row in chosen])
    return labelled(
        {
            **_stalling(curve),
            **_stall_angles(curve),
            "closure": [*CLOSURES, DISTRIBUTION],
            "convention": list(CONVENTIONS),
            "interaction": interaction,
            "interaction_angle": angle,
            "interaction_domain_size": domain,
            "interaction_closure": closure,
            **_polynomials(interaction, chosen, domain),
        }
    )


def _stalling(curve: StallCurve) -> dict[str, Any]:
    """Return how fibers turn, from across the flow, until they stall (the paper's Fig. 14a-b)."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.tumbling import turned_angle  # noqa: PLC0415

    largest = np.floor(10 * curve.largest_stalling_domain) / 10
    sizes = np.linspace(min(SMALLEST_DRAWN, largest), largest, 5)
    time, factor = np.linspace(0.0, LONGEST_TIME, TIMES), curve.value(sizes)
    angle = np.stack([turned_angle(float(B), 1.0, time, 0.5 * np.pi) for B in factor])
    return {
        "stalling_domain_size": sizes,
        "stalling_time": time,
        "stalling_angle": angle,
        "stalling_spin": 0.5 * (factor[:, None] * np.cos(2 * angle) - 1),
    }


def _stall_angles(curve: StallCurve) -> dict[str, Any]:
    """Return the stall angle against the size of the cell (Fig. 14c), Eq. 32 where it holds."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.fiber.stall import PAPER_DOMAINS, paper_stall_angle  # noqa: PLC0415

    sizes = np.linspace(float(curve.domain_size[0]), curve.largest_stalling_domain, SIZES)
    angle = np.nan_to_num(curve.stall_angle(sizes), nan=0.0)
    low, high = PAPER_DOMAINS
    fitted = (sizes >= low) & (sizes <= high)
    paper = np.full(SIZES, np.nan)
    paper[fitted] = paper_stall_angle(sizes[fitted])
    return {
        "stall_curve_domain_size": sizes,
        "stall_curve_angle": angle,
        "stall_curve_paper": paper,
        "stall_curve_difference": _largest(angle - paper),
    }


def _preferred_angles(aspect_ratio: float, interaction: Array) -> Array:
    """Return the preferred angle by convention, closure and C_I (Fig. 14d), the true one last."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    return np.array(
        [
            [
                [_angle(aspect_ratio, float(C_I), convention, closure) for C_I in interaction]
                for closure in (*CLOSURES, DISTRIBUTION)
            ]
            for convention in CONVENTIONS
        ]
    )


def _angle(aspect_ratio: float, interaction: float, convention: str, closure: str) -> float:
    """Return one preferred angle [rad], NaN where the closure has no steady state."""
    from fibermelt.errors import ConvergenceError  # noqa: PLC0415  lazy: see the module

    model = folgar_tucker(aspect_ratio, interaction, convention)
    try:
        if closure == DISTRIBUTION:
            return distribution_angle(model)
        return preferred_angle(model, closure)
    except ConvergenceError:
        return float("nan")


def _domain_size(curve: StallCurve, angle: float) -> float:
    """Return the cell that stalls the fiber at an angle, NaN where none does."""
    from fibermelt.errors import ConfigError  # noqa: PLC0415  lazy: see the module

    try:
        return curve.domain_size_at(angle)
    except ConfigError:
        return float("nan")


def _polynomials(interaction: Array, angle: Array, domain: Array) -> dict[str, Any]:
    """Return the paper's Eq. 33 and 34 and how far the computed curves are, by convention."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    from fibermelt.orientation.interaction import (  # noqa: PLC0415
        paper_domain_size,
        paper_preferred_angle,
    )

    angles, sizes = paper_preferred_angle(interaction), paper_domain_size(interaction)
    return {
        "interaction_angle_paper": angles,
        "interaction_angle_difference": np.array([_largest(one - angles) for one in angle]),
        "interaction_domain_size_paper": sizes,
        "interaction_domain_size_difference": np.array([_largest(one - sizes) for one in domain]),
    }


def _largest(difference: Array) -> float:
    """Return the largest size of a difference, over where both sides are."""
    import numpy as np  # noqa: PLC0415  lazy: see the module

    known = np.abs(difference[np.isfinite(difference)])
    return float(known.max()) if known.size else float("nan")
