"""What a check is, and how the ladder of them is climbed.

A check compares one measured number with a band that was stated before: an error with the bound it
must stay below, an observed order of convergence with where theory puts it. What is expected is
declared apart from how it is measured, so that a check that could not be carried out still says
what it was to show.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Any, Literal

from fibermelt.errors import FibermeltError, legible

__all__ = [
    "LADDER_VERSION",
    "Check",
    "Expectation",
    "Extent",
    "Kind",
    "Rung",
    "as_dataset_rows",
    "below",
    "chosen",
    "climb",
    "order",
]

Kind = Literal["error below bound", "order within band"]

Extent = Literal["brief", "quick", "full"]
"""How much of the ladder: what a study stores by default, what takes ten seconds, all of it."""

LADDER_VERSION = 5
"""Raised whenever a check is added, changed or moved, or what it checks: no stored one is kept."""

LONGEST_REASON = 400
"""Characters of an error message that a check keeps: all of those that fibermelt itself writes."""

Say = Callable[[str, str], None]
"""Told, before a rung is climbed, its subject and what it measures."""


@dataclass(frozen=True)
class Expectation:
    """What a check is to find, stated before it is carried out.

    Parameters
    ----------
    name : str
        A few words, unique in the ladder.
    what : str
        One sentence: what is compared with what.
    reference : str
        Where the other side comes from: literature, or the independent path.
    because : str
        Why the bound is what it is.
    kind : str
        ``"error below bound"`` or ``"order within band"``.
    lowest, highest : float
        The band that passes, ends included; an error has the lowest 0.
    unit : str
        Of value and band; empty for a pure number.
    """

    name: str
    what: str
    reference: str
    because: str
    kind: Kind
    lowest: float
    highest: float
    unit: str


@dataclass(frozen=True)
class Check(Expectation):
    """An expectation with what was measured.

    Parameters
    ----------
    subject : str
        What of fibermelt was checked: ``"flow"``, ``"fiber"``, ...
    value : float
        The number; NaN if there is none.
    seconds : float
        What measuring it took [s]; checks of one rung share theirs evenly.
    failure : str
        Why there is no number; empty if there is one.
    """

    subject: str
    value: float
    seconds: float
    failure: str

    @property
    def passed(self) -> bool:
        """Return whether the number lies in its band; NaN does not."""
        return self.lowest <= self.value <= self.highest


@dataclass(frozen=True)
class Rung:
    """Checks that one measurement answers.

    Parameters
    ----------
    subject : str
        What of fibermelt is checked.
    expected : tuple of Expectation
        One or more.
    measure : callable
        Returns their numbers, in the same order.
    quick : bool
        Whether it is part of the quick ladder: a second or so.
    brief : bool
        Whether it is also part of the brief one, which a study stores: all of it in six seconds.
    """

    subject: str
    expected: tuple[Expectation, ...]
    measure: Callable[[], Sequence[float]]
    quick: bool
    brief: bool = False


def below(
    name: str, what: str, reference: str, bound: float, because: str, unit: str = ""
) -> Expectation:
    """Return the expectation that an error, never negative, does not exceed its bound.

    Parameters as in `Expectation`.
    """
    return Expectation(name, what, reference, because, "error below bound", 0.0, bound, unit)


def order(
    name: str, what: str, reference: str, band: tuple[float, float], because: str
) -> Expectation:
    """Return the expectation that an observed order lies in a band, ends included.

    Parameters as in `Expectation`.
    """
    return Expectation(name, what, reference, because, "order within band", *band, "")


def chosen(rungs: Iterable[Rung], extent: Extent) -> tuple[Rung, ...]:
    """Return the rungs of a ladder that belong to its brief, quick or full one."""
    if extent == "full":
        return tuple(rungs)
    return tuple(rung for rung in rungs if (rung.brief if extent == "brief" else rung.quick))


def climb(
    rungs: Iterable[Rung], *, quick: bool = False, say: Say | None = None
) -> tuple[Check, ...]:
    """Carry out the checks of all rungs, or of the quick ones, whatever becomes of each.

    Parameters
    ----------
    rungs : iterable of Rung
        In the order of climbing.
    quick : bool
        Whether to leave out those that take long.
    say : callable, optional
        Told before each rung: its subject, and the name of its first check.

    Returns
    -------
    tuple of Check
        A rung that raises a `FibermeltError` fails with its reason and does not stop the others.
    """
    checks: list[Check] = []
    for rung in rungs:
        if quick and not rung.quick:
            continue
        if say is not None:
            say(rung.subject, rung.expected[0].name)
        checks.extend(_measured(rung))
    return tuple(checks)


def _measured(rung: Rung) -> list[Check]:
    """Return the checks of one rung, done or failed."""
    start = perf_counter()
    failure = ""
    values: Sequence[float]
    try:
        values = rung.measure()
    except FibermeltError as error:
        failure = legible(str(error), LONGEST_REASON)
        values = [math.nan] * len(rung.expected)
    share = (perf_counter() - start) / len(rung.expected)
    return [
        Check(
            **asdict(expected),
            subject=rung.subject,
            value=float(value),
            seconds=share,
            failure=failure,
        )
        for expected, value in zip(rung.expected, values, strict=True)
    ]


def as_dataset_rows(checks: Sequence[Check]) -> dict[str, list[Any]]:
    """Return the checks as columns of equal length, ready for a table or a labelled dataset.

    Parameters
    ----------
    checks : sequence of Check
        One for each row.

    Returns
    -------
    dict of lists
        ``subject, name, what, reference, because, kind, unit, failure`` as strings,
        ``value, lowest, highest, seconds`` as floats (``value`` is NaN where there is none),
        ``passed`` as booleans.
    """
    texts = ("subject", "name", "what", "reference", "because", "kind", "unit", "failure")
    numbers = ("value", "lowest", "highest", "seconds")
    return {key: [getattr(check, key) for check in checks] for key in (*texts, *numbers, "passed")}
