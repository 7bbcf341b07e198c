"""The words of pages and pictures, each defined once: for the reports and for the documentation."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from fibermelt.report.kit.templates import rendered

__all__ = ["TERMS", "Term", "glossary"]


@dataclass(frozen=True)
class Term:
    """A word and what it stands for.

    Parameters
    ----------
    name : str
        The word, or several that are told together.
    meaning : str
        What it stands for, in words of the trade.
    """

    name: str
    meaning: str

    @property
    def anchor(self) -> str:
        """Return where it stands in a page, such as ``term-sharp-corner``."""
        kept = "".join(letter if letter.isalnum() else " " for letter in self.name.lower())
        return f"term-{'-'.join(kept.split())}"


TERMS = (
    Term(
        "void",
        "A bubble in the bead: water vapor that comes out of the melt where its pressure is lower "
        "than the vapor pressure.",
    ),
    Term(
        "vapor pressure",
        "The pressure at which the moisture in the melt boils, absolute; it rises with moisture "
        "and temperature. Red in every picture is below it, and nothing else is red.",
    ),
    Term(
        "critical moisture",
        "The moisture at which the vapor pressure is as low as the lowest pressure: below it no "
        "bubble can grow.",
    ),
    Term(
        "melt’s own pressure",
        "What the flow has without any fiber. Every fiber raises it on some of its surface and "
        "lowers it elsewhere, most at its ends.",
    ),
    Term(
        "growth exponent",
        "How far a bubble can grow on its way: pressure below the vapor’s over four times the "
        "viscosity, summed over the time that it lasts, (P_V - p)/(4 η) dt. The radius grows by "
        "the factor e to that power at most: 600 for 6.4.",
    ),
    Term(
        "severity",
        "The growth exponent as a mean over all melt that flows; that of the melt itself, and what "
        "fibers add to it.",
    ),
    Term(
        "upstream, downstream",
        "Against the motion of the bed, and with it. Pictures have upstream at the left; the bead "
        "leaves downstream, at the right.",
    ),
    Term(
        "streamline",
        "The way of a bit of melt from the inlet to the finished bead. Streamlines are numbered "
        "from the upstream edge of the nozzle, which becomes the bottom of the bead; each stands "
        "for the same share of the melt.",
    ),
    Term(
        "mean by flux",
        "A mean in which each bit of melt counts the same, fast or slow.",
    ),
    Term("capillary", "The narrow straight end of the nozzle, its land."),
    Term("gap", "The distance from the nozzle’s end to the bed."),
    Term(
        "sharp corner",
        "The entrance of the capillary, the nozzle’s lips, and the line where the melt meets the "
        "bed: the computed stress there has no bound (a singular corner). Streamlines that pass "
        "close by are hatched in pictures and left out of means, and judged by the most that a "
        "fiber can feel there, which has a bound.",
    ),
    Term(
        "zones 1 to 3",
        "The entrance of the capillary, the exit of the nozzle, and where the bead has come to "
        "rest on the bed (the end of the swell).",
    ),
    Term(
        "Loc. 1, Loc. 2",
        "Where the paper reads the pressure on a fiber: on its way to the entrance of the "
        "capillary, and from the nozzle’s exit to the end of the swell.",
    ),
    Term(
        "initial angle",
        "The direction in which a fiber enters, as an angle from the bed’s motion; on every "
        "streamline a fiber of each is followed.",
    ),
    Term(
        "worst direction",
        "The direction of a fiber, place by place, in which the pressure on it is lowest: no "
        "fiber sees less, however it entered.",
    ),
    Term(
        "randomly entering fibers",
        "Fibers that have all directions alike at the inlet (an isotropic start); the flow then "
        "turns them.",
    ),
    Term(
        "aspect ratio",
        "Length of a fiber over its width.",
    ),
    Term(
        "cell, domain-size factor M",
        "A fiber among others is computed in a round cell of melt, M half-lengths of the fiber "
        "across; more fibers, a smaller cell.",
    ),
)
"""In the order in which a reader meets them."""


def glossary() -> Markup:
    """Return the words of a page, folded away."""
    return rendered("report/kit/glossary.html.j2", {"terms": TERMS})
