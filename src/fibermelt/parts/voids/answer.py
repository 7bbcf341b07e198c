"""What an engineer asks about voids, answered: the same sentences on page, terminal and summary.

Whether the pressure somewhere falls below the vapor's is true of nearly every print and decides
nothing. How long and how deep does: the growth exponent (`fibermelt.voids.exposure`), whose mean
over the bead is its severity.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from decimal import ROUND_DOWN, Context
from typing import Any

from fibermelt.parts.voids.profile import FELT
from fibermelt.report.kit.tables import number, short
from fibermelt.units import MM, MPA, PERCENT, ZERO_CELSIUS
from fibermelt.voids.constants import ATMOSPHERE

__all__ = [
    "LABELS",
    "MOISTURE",
    "NO_CHANGE",
    "PAPER",
    "SAFETY",
    "answered",
    "by_layer",
    "dry_enough",
]

BOILS = "Does the melt boil at rest?"
ADDED = "What do the fibers add?"
HELPS = "What helps most?"
SURE = "How sure is that?"
ADVICE = "What to do?"

LABELS = {
    BOILS: "boils at rest",
    ADDED: "fibers add",
    HELPS: "helps most",
    SURE: "how sure",
    ADVICE: "what to do",
}
"""The questions, and what stands for each at the head of a line on a terminal."""

PAPER: Mapping[str, Any] = {
    "name": "the paper’s bead",
    "fibers": 9.844,
    "melt": 22.92,
    "profile": [
        {"fibers": fibers, "melt": melt}
        for fibers, melt in (
            (15.33, 37.62), (16.74, 35.92), (14.83, 27.62), (10.18, 22.52), (7.224, 20.35),
            (5.914, 19.24), (6.147, 18.74), (7.257, 18.66), (9.843, 19.28), (11.20, 19.79),
        )
    ],
}  # fmt: skip
"""Severity of the paper's bead at its 0.17 % moisture, and by layer from the bed, as
`fibermelt run paper` finds it."""

SAFETY = 2.0
"""Factor by which the vapor pressure of a card may be off at one moisture: of water in ABS the
humidity's slope and what filaments take up (0.17 to 0.75 %) leave as much. What is called free of
voids is so at this much of it."""

ENDLESS = 12.0
"""Growth exponent beyond which the moisture in reach of a tip is used up, whatever its size: the
radius would grow by more than a hundred thousand."""

MOISTURE = "voids.moisture"
"""The key of the moisture."""

STRONGEST = 3
"""How many levers the answer names; the page has all of them."""

TELLING = 1.05
"""Least factor of a doubt that is worth a word beside the others; the page has all."""

NO_CHANGE = 0.99
"""What is left of the severity at least where a lever does nothing, within the flow's error."""


def dry_enough(voids: Mapping[str, Any]) -> float | None:
    """Return the moisture that a melt which may boil at rest has to be dried to; None if it is.

    It is what the melt boils from on over `SAFETY`, with two digits, not above it.

    Parameters
    ----------
    voids : mapping
        What summary.json has under ``"voids"``: its ``"moisture"`` and ``"rest"``.
    """
    limit = voids["rest"]["boiling_moisture"]
    if limit is None or voids["moisture"] <= limit / SAFETY:
        return None
    return float(Context(prec=2, rounding=ROUND_DOWN).create_decimal_from_float(limit / SAFETY))


def answered(voids: Mapping[str, Any]) -> list[dict[str, str]]:
    """Return the questions with their answers, ``[{"question", "answer"}]``.

    Parameters
    ----------
    voids : mapping
        What summary.json has under ``"voids"``; with ``"levers"``, ``"recommendation"`` and
        ``"uncertainty"`` where these were computed.
    """
    told = {
        BOILS: _boils(voids),
        ADDED: _added(voids),
        HELPS: _helps(voids),
        SURE: _sure(voids),
        ADVICE: _advice(voids),
    }
    return [{"question": question, "answer": answer} for question, answer in told.items() if answer]


def _boils(voids: Mapping[str, Any]) -> str:
    """Return whether the melt boils where it is at rest in the air."""
    vapor, limit = voids["vapor_pressure"], voids["rest"]["boiling_moisture"]
    at = (
        f"{_percent(voids['moisture'])} moisture has a vapor pressure of {_mpa(vapor)} at "
        f"{voids['temperature'] - ZERO_CELSIUS:.0f} °C"
    )
    if voids["rest"]["boils"]:
        return (
            f"Yes, whatever the nozzle does: {at}, {number(vapor / ATMOSPHERE, 2)} times the "
            f"air’s. From {_percent(limit)} down it does not."
        )
    if (target := dry_enough(voids)) is not None:
        return (
            f"Barely not: {at}, where the air has {_mpa(ATMOSPHERE)}, and what is known "
            f"of a material’s moisture may be off by a factor of {SAFETY:g}. Count on it; it is "
            f"sure not to from {_percent(target)} down."
        )
    beyond = (
        "no moisture that the polymer can hold makes it boil"
        if limit is None
        else f"it would from {_percent(limit)} on"
    )
    return f"No: {at}, below the air’s {_mpa(ATMOSPHERE)}; {beyond}."


def _added(voids: Mapping[str, Any]) -> str:
    """Return by how much the fibers let a nucleus grow, where most, and beside what."""
    fibers, melt = (voids["severity"][of] for of in ("fibers", "melt"))
    if fibers is None:
        word = "streamline" if voids["profile"] else "path"
        return f"Not told: every {word} passes a sharp corner of the nozzle; follow more of them."
    if _is_free(voids):
        return (
            "Nothing: on no fiber, however it lies, does the pressure fall below "
            f"{SAFETY:g} times this vapor pressure, which is as far as that may be off."
        )
    if fibers == 0.0 and melt == 0.0:
        return (
            "Nothing on the fibers that were followed; one in its worst direction meets "
            f"{_mpa(_lowest(voids))}, absolute, where the vapor pressure may be "
            f"{_mpa(SAFETY * voids['vapor_pressure'])}."
        )
    told = (
        f"A growth exponent of {number(fibers, 2)}, on average, beside the melt’s own "
        f"{number(melt, 2)}: {_grown(fibers)}"
    )
    return f"{told}{_where(voids)}{_against(voids, fibers)}.{_content(voids)}"


def _grown(exponent: float) -> str:
    """Return what an exponent does to a nucleus, in words."""
    if exponent > ENDLESS:
        return "a nucleus at a fiber’s tip grows until the moisture around it is used up"
    factor = float(f"{math.exp(exponent):.2g}")
    return (
        f"a nucleus at a fiber’s tip grows {number(factor, 2)} times as wide as one in the melt, "
        "as long as moisture lasts"
    )


def _where(voids: Mapping[str, Any]) -> str:
    """Return in which layers the fibers add most and least."""
    layers = [one for one in voids["profile"] if one["severity"]["fibers"] is not None]
    if len(layers) < 2:
        return ""
    low, high = (
        extreme(layers, key=lambda layer: float(layer["severity"]["fibers"]))
        for extreme in (min, max)
    )
    most, least = (float(one["severity"]["fibers"]) for one in (high, low))
    if number(most, 2) == number(least, 2):
        return ""
    return (
        f". Most, {number(most, 2)}, {number(MM * high['height'], 2)} mm above the bed, least, "
        f"{number(least, 2)}, at {number(MM * low['height'], 2)} mm"
    )


def _left_out(voids: Mapping[str, Any]) -> str:
    """Return how much of the melt no number of the bead is of."""
    lines = voids["streamlines"]
    flagged = sum(bool(line["near_singularity"]) for line in lines)
    if not flagged:
        return ""
    felt = ""
    if FELT in voids["by_basis"]:
        lowest = voids["including_singular"]["lowest_pressure"]
        felt = f"; by what a fiber can feel at most, none comes below {_mpa(lowest)}"
    word, past = ("streamlines", " of the nozzle") if voids["profile"] else ("paths", "")
    return (
        f" Without the {flagged} of {len(lines)} {word}, {_share(flagged / len(lines))} of the "
        f"melt, that pass a sharp corner{past} so closely that the mesh decides{felt}."
    )


def _content(voids: Mapping[str, Any]) -> str:
    """Return the void content that nuclei of the assumed size and number come to."""
    found = voids["void_fraction"]
    if found["bead"] is None:
        return ""
    return (
        " Nuclei of the size and number that are assumed make that a void content of "
        f"{_share(found['bead'])} at the end of the swell, {_share(found['tips'])} by the fibers."
    )


def _against(voids: Mapping[str, Any], fibers: float) -> str:
    """Return the severity beside that of another run, or of the paper's bead."""
    other = _other(voids)
    if other is None:
        return ""
    if not other["fibers"]:
        return f"; on {other['name']} they add nothing"
    told = f"; {number(fibers / other['fibers'], 2)} times what they add on {other['name']}"
    known = [one for one in by_layer(voids) if one["ratio"] is not None]
    if len(known) < 2:
        return told
    low, high = (extreme(known, key=lambda one: float(one["ratio"])) for extreme in (min, max))
    least, most = (number(one["ratio"], 2) for one in (low, high))
    if least == most:
        return told
    return (
        f"{told}, layer by layer from {least} ({number(MM * low['height'], 2)} mm above the bed) "
        f"to {most} ({number(MM * high['height'], 2)} mm)"
    )


def _other(voids: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return what a bead is held against: another run, or the paper's bead; paths have none."""
    found: Mapping[str, Any] | None = voids.get("against", PAPER if voids["profile"] else None)
    return found


def by_layer(voids: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what fibers add in each layer from the bed up, over that of the bead held against.

    Layers are of equal flux: those of another number of layers are taken by what lies below them.

    Parameters
    ----------
    voids : mapping
        What summary.json has under ``"voids"``; with ``"against"`` where that is another run.

    Returns
    -------
    list of dict
        ``"height"`` [m] and ``"ratio"``; None where either is not known, or adds nothing.
    """
    layers, other = voids["profile"], _other(voids)
    others = other["profile"] if other is not None else []
    found = []
    for k, layer in enumerate(layers):
        here = layer["severity"]["fibers"]
        place = int((k + 0.5) / len(layers) * len(others))
        there = others[place]["fibers"] if others else None
        ratio = here / there if here is not None and there else None
        found.append({"height": layer["height"], "ratio": ratio})
    return found


def _lowest(voids: Mapping[str, Any]) -> float:
    """Return the lowest pressure [Pa, absolute] of all that was judged, on whatever fiber."""
    judged = [*voids["by_basis"].values(), voids["including_singular"]]
    return min(
        float(one["lowest_pressure"]) for one in judged if one["lowest_pressure"] is not None
    )


def _is_free(voids: Mapping[str, Any]) -> bool:
    """Tell whether no fiber, however it lies, can void, with all that the answer may be off."""
    return _lowest(voids) > SAFETY * float(voids["vapor_pressure"])


def _helps(voids: Mapping[str, Any]) -> str:
    """Return the levers that change most of what fibers add, and those that do nothing.

    Of a melt that boils, moisture first, and the others as they are once it is dried.
    """
    if "levers" not in voids:
        return ""
    boils = voids["rest"]["boils"]
    moisture = [one for one in voids["levers"] if one["key"] == MOISTURE]
    others = [one for one in voids["levers"] if not (boils and one["key"] == MOISTURE)]
    known = [
        (left, one)
        for one in others
        if (left := one["dry_ratio" if boils else "fibers_ratio"]) is not None
    ]
    told = []
    if boils:
        told += [
            f"Drying: {one['moved']} leaves {_share(one['fibers_ratio'])} of what fibers add"
            for one in moisture
            if one["fibers_ratio"] is not None
        ]
    moving = sorted(
        (one for one in known if abs(1.0 - one[0]) > 1.0 - NO_CHANGE),
        key=lambda one: -abs(math.log(one[0])) if one[0] > 0 else -math.inf,
    )
    if moving:
        listed = "; ".join(f"{one['moved']}, {_share(left)}" for left, one in moving[:STRONGEST])
        told.append(f"{'Once dry, of' if boils else 'Of'} what fibers add there is left: {listed}")
    elif known:
        told.append(f"{'Once dry, no' if boils else 'No'} lever that was tried changes it")
    idle = [one["lever"] for left, one in known if abs(1.0 - left) <= 1.0 - NO_CHANGE]
    if idle and moving:
        told.append(f"No effect: {_joined(list(dict.fromkeys(idle)))}")
    return f"{'. '.join(told)}." if told else "There is no severity that a lever could lower."


def _sure(voids: Mapping[str, Any]) -> str:
    """Return the largest doubts, each with its factor, and what was left out."""
    known = [one for one in voids.get("uncertainty", ()) if (one["factor"] or 1.0) >= TELLING]
    listed = ", ".join(f"{one['source']} {number(one['factor'], 2)}" for one in known)
    told = f"The severity may be off by these factors: {listed}." if known else ""
    return f"{told}{_left_out(voids)}".lstrip()


def _advice(voids: Mapping[str, Any]) -> str:
    """Return the recommendation that was run, or what can be said without one."""
    found = voids.get("recommendation")
    if found is None:
        if (target := dry_enough(voids)) is not None:
            return f"Dry below {_percent(target)} first: no setting of the nozzle makes up for it."
        return "Ask `fibermelt voids` on this folder: it tries each lever, in about a minute."
    if not found["settings"]:
        return "Leave it: no setting that costs no output leaves clearly less."
    listed = ", ".join(f"{key} = {text}" for key, text in found["written"].items())
    return f"Set {listed}. That was run: {_outcome(found)}."


def _outcome(found: Mapping[str, Any]) -> str:
    """Return what a recommendation came to."""
    told = [
        f"{of} {_share(found[f'{key}_ratio'])} of what {it} now"
        for key, of, it in (
            ("fibers", "the fibers add", "they add"),
            ("melt", "the melt alone has", "it has"),
        )
        if found[f"{key}_ratio"] is not None
    ]
    before, after = (found.get(f"void_fraction{when}") for when in ("_before", ""))
    if before is not None and after is not None:
        told.append(
            f"the void content at the end of the swell goes {_share(before)} to {_share(after)}"
        )
    return ", ".join(told) or "no severity is left to compare"


def _joined(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))


def _share(ratio: float) -> str:
    return f"{number(PERCENT * ratio, 2)} %"


def _percent(share: float) -> str:
    return f"{short(PERCENT * share, 2)} %"


def _mpa(pressure: float) -> str:
    return f"{number(MPA * pressure, 3)} MPa"
