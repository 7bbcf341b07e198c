"""The paper's claims, and whether they hold: statements as data, judged by code on the results.

A claim (``data/claims.toml``) names a quantity of `fibermelt.paper.claims.measures` and what
the paper says of it: a value with a tolerance, or a bound. Nothing here knows the answer.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Literal

from fibermelt.paper.claims.bead import BEAD
from fibermelt.paper.claims.fiber import FIBER
from fibermelt.paper.claims.flow import FLOW
from fibermelt.paper.claims.measures import Measure, NotStoredError
from fibermelt.paper.claims.voids import VOIDS

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MEASURES", "Claim", "Judgement", "Verdict", "claims", "judge", "measured"]

MEASURES: Mapping[str, Measure] = {**FLOW, **BEAD, **FIBER, **VOIDS}
"""What claims are judged by, by name."""

Verdict = Literal["holds", "differs", "cannot be judged"]

UNITS = {
    "": 1.0,
    "%": 0.01,
    "MPa": 1e6,
    "kPa": 1e3,
    "mm": 1e-3,
    "s": 1.0,
    "rad": 1.0,
    "deg": math.radians(1.0),
}
"""What claims are written in, in SI."""


@dataclass(frozen=True)
class Claim:
    """A statement of the paper that its text supports.

    Parameters
    ----------
    id : str
        Its name.
    section : str
        Where the paper makes it.
    statement : str
        What it says, in our words.
    quantity : str
        What of the results it is judged by: a name in `MEASURES`.
    measure : str
        What that quantity is, in words.
    unit : str
        What its numbers are written in.
    why : str
        Why the tolerance or the bound is what it is.
    paper : float or None
        The paper's value, if it gives one.
    tolerance : float or None
        Largest difference from the paper's value with which it holds.
    at_least, at_most : float or None
        Bounds of the quantity within which it holds, if the paper gives no value.
    known : str
        Why ours differs, as far as that is known.
    """

    id: str
    section: str
    statement: str
    quantity: str
    measure: str
    unit: str
    why: str
    paper: float | None = None
    tolerance: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    known: str = ""

    def __post_init__(self) -> None:
        """Refuse a claim that cannot be judged whatever the results are."""
        if self.unit not in UNITS:
            msg = f"claim {self.id}: unit {self.unit!r} is none of {', '.join(UNITS)}"
            raise ValueError(msg)
        given = (self.paper, self.tolerance)
        if (None in given) != (given == (None, None)) or (
            self.paper is None and self.at_least is None and self.at_most is None
        ):
            msg = f"claim {self.id}: give a value and its tolerance, or bounds"
            raise ValueError(msg)

    @property
    def said(self) -> str:
        """Return the number that the paper gives, with its unit; empty where it says it in words.

        What its words are taken to mean is ours, and stands in `passes_if`.
        """
        return "" if self.paper is None else f"{self.paper:g} {self.unit}".rstrip()

    @property
    def passes_if(self) -> str:
        """Return when the claim holds: our bound on the quantity, with its unit."""
        unit = f" {self.unit}" if self.unit else ""
        if self.paper is not None:
            return f"within {self.tolerance:g}{self._apart} of {self.said}"
        if self.at_least is not None and self.at_most is not None:
            return f"{self.at_least:g} to {self.at_most:g}{unit}"
        if self.at_least is not None:
            return f"at least {self.at_least:g}{unit}"
        return f"at most {self.at_most:g}{unit}"

    @property
    def _apart(self) -> str:
        """Return the unit of a difference, with a space: shares differ by percentage points."""
        unit = "percentage points" if self.unit == "%" else self.unit
        return f" {unit}" if unit else ""

    def told_apart(self, difference: float) -> str:
        """Return the size of a difference in words."""
        return f"{abs(difference):.3g}{self._apart}"

    def excess(self, value: float) -> float:
        """Return by how much a value [unit of the claim] misses what the paper says; 0 if not."""
        if self.paper is not None and self.tolerance is not None:
            difference = value - self.paper
            return 0.0 if abs(difference) <= self.tolerance else difference
        if self.at_least is not None and value < self.at_least:
            return value - self.at_least
        if self.at_most is not None and value > self.at_most:
            return value - self.at_most
        return 0.0


@dataclass(frozen=True)
class Judgement:
    """What the results say of a claim.

    Parameters
    ----------
    claim : Claim
        The claim.
    value : float or None
        The quantity in the claim's unit; None if the results do not have it.
    verdict : str
        ``"holds"``, ``"differs"`` or ``"cannot be judged"``.
    reason : str
        By how much it differs and why, or why it cannot be judged; what the bound is otherwise.
    """

    claim: Claim
    value: float | None
    verdict: Verdict
    reason: str

    @property
    def ours(self) -> str:
        """Return our number with its unit."""
        return "" if self.value is None else f"{self.value:.4g} {self.claim.unit}".rstrip()


@cache
def claims() -> tuple[Claim, ...]:
    """Return the claims that ship with the package, in the order of the paper."""
    text = files("fibermelt.data").joinpath("claims.toml").read_text(encoding="utf-8")
    return tuple(Claim(**entry) for entry in tomllib.loads(text)["claim"])


def measured(claim: Claim, results: xr.Dataset) -> tuple[float, str]:
    """Return the quantity of a claim in its unit, and why there is none: NaN and the reason.

    Parameters
    ----------
    claim : Claim
        The claim.
    results : xarray.Dataset
        As in results.nc; a quantity of a part that was not run cannot be had.
    """
    try:
        return MEASURES[claim.quantity](results) / UNITS[claim.unit], ""
    except NotStoredError as error:
        return math.nan, str(error)


def judge(claim: Claim, value: float, missing: str = "", *, as_in_paper: bool = True) -> Judgement:
    """Return what a measured quantity says of a claim.

    Parameters
    ----------
    claim : Claim
        The claim.
    value : float
        The quantity in the claim's unit; NaN if there is none.
    missing : str
        Why there is none.
    as_in_paper : bool
        Whether the study has the paper's conditions; the known reasons are for these.
    """
    if math.isnan(value):
        return Judgement(claim, None, "cannot be judged", missing)
    excess = claim.excess(value)
    if excess == 0.0:
        return Judgement(claim, value, "holds", claim.why)
    against = "what the paper says" if claim.paper is not None else "the bound"
    missed = f"{claim.told_apart(excess)} {'above' if excess > 0 else 'below'} {against}"
    if not as_in_paper:
        return Judgement(claim, value, "differs", f"{missed}; the conditions are not the paper's")
    reason = f"{missed}: {claim.known}" if claim.known else f"{missed}, for no reason that we know"
    return Judgement(claim, value, "differs", reason)
