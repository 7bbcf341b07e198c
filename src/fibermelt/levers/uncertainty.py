"""How sure a severity is: each source of doubt as the factor by which it may be off.

What is cheap is computed, of the run's own results or as a case beside it; what is not is stated,
with where it was computed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fibermelt.parts.voids.answer import MOISTURE, SAFETY

if TYPE_CHECKING:
    from fibermelt.levers.cases import Case

__all__ = ["doubts", "uncertainty_of"]

LENGTH = 1.5
"""Factor of the aspect ratio: fibers in printed beads spread by about this around their mean."""

NUCLEUS = "nucleus"

RADII = (1e-7, 5e-6)
"""Radii between which a nucleus is assumed [m], as in the table ``[voids]``."""

CARD = "the material’s moisture data"

FIBERS = "fiber length"

BASIS = {
    CARD: f"computed: {SAFETY:g} times the moisture, and a part of it",
    FIBERS: f"computed: {LENGTH:g} times as long fibers, and as short ones",
}

PLANAR = (4 / 3, "stated: the wall's rate in a round nozzle, 8 U/d, over that in a slot, 6 U/W")
"""The one thing of a third dimension that is known without solving in it."""

THINNING = (
    2.1,
    "stated: the paper's bead of a Carreau melt that has its 817 Pa s at 100 1/s, n = 0.35",
)
"""What fibers add there, 4.72, against 9.84: they thin the melt around themselves."""


def doubts(values: Mapping[str, Any], moisture: float) -> dict[str, list[dict[str, float]]]:
    """Return the changed studies whose spread is a doubt, by what is doubted.

    Parameters
    ----------
    values : mapping
        The resolved study.
    moisture : float
        The run's: by Henry's law a vapor pressure that is off by a factor is a moisture that is.
    """
    aspect = float(values["fiber.aspect_ratio"])
    return {
        CARD: [{MOISTURE: moisture * factor} for factor in (1 / SAFETY, SAFETY)],
        FIBERS: [
            {"fiber.aspect_ratio": max(1.0, aspect * factor)} for factor in (1 / LENGTH, LENGTH)
        ],
        NUCLEUS: [{"voids.nucleus_radius": radius} for radius in RADII],
    }


def _spread(pairs: Iterable[tuple[float, float]]) -> float | None:
    """Return the largest factor between two that are one; None where one of them is nothing.

    What vanishes has no factor: it is told as it is.
    """
    factors = [max(one / base, base / one) for one, base in pairs if one > 0.0 and base > 0.0]
    return max(factors, default=None)


def uncertainty_of(
    voids: Mapping[str, Any],
    values: Mapping[str, Any],
    base: Case,
    computed: Mapping[str, Sequence[Case]],
) -> list[dict[str, Any]]:
    """Return every source of doubt, its factor on what fibers add, and where that is from.

    The largest first; a factor of None is that of a severity which one of the two has not.

    Parameters
    ----------
    voids : mapping
        What summary.json says of voids.
    values : mapping
        The resolved study.
    base : Case
        The run itself.
    computed : mapping
        The cases of `doubts`, by what is doubted.
    """
    found: list[tuple[str, float | None, str]] = [
        (name, _spread(case.beside(base, "fibers") for case in cases), basis)
        for name, basis in BASIS.items()
        for cases in (computed[name],)
    ]
    content = _spread((case.void_fraction, base.void_fraction) for case in computed[NUCLEUS])
    if content is not None:
        basis = f"computed: the severity needs none, the void content is off by {content:.2g}"
        found.append((NUCLEUS, 1.0, f"{basis}, of 0.1 to 5 µm"))
    own, error = (voids[name]["fibers"] for name in ("severity", "severity_error"))
    if own and error is not None:
        found.append(("discretisation", 1.0 + error / own, "estimated: every second point"))
    if (shape := _spheroid(voids)) is not None:
        found.append(
            (
                "fibers as ellipses of a plane, not bodies in space",
                shape,
                "computed: in their worst directions",
            )
        )
    if values["flow.source"] == "deposition":
        found.append(("a slot, not a round nozzle", *PLANAR))
    if values["melt.law"] == "newtonian":
        found.append(("a viscosity that does not thin", *THINNING))
    ranked = sorted(found, key=lambda one: -(one[1] or 1.0))
    return [{"source": name, "factor": factor, "basis": basis} for name, factor, basis in ranked]


def _spheroid(voids: Mapping[str, Any]) -> float | None:
    """Return what spheroids in space add over what ellipses of the plane do, or the inverse."""
    found = voids["by_basis"]
    if "spheroid" not in found:
        return None
    own, plane, space = (found[name]["growth_exponent"] for name in ("melt", "bounds", "spheroid"))
    if None in (own, plane, space):
        return None
    return _spread([(space - own, plane - own)])
