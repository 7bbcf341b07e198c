"""A distribution in words: as the study has it, and what is left of one that is cut off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fibermelt.engine.parameters import declarations
from fibermelt.study.config import Config
from fibermelt.sweeps.axes import DISTRIBUTIONS, read_axis
from fibermelt.sweeps.distributions import Truncated

__all__ = ["distribution_told"]

ORDER = ("low", "high", "mean", "std", "median", "factor", "scale", "shape")
"""In which the entries of a table are told: files that were written by machine have others."""


def distribution_told(key: str, entry: object) -> str:
    """Return what a key of ``[sweep]`` samples; empty for a list and for a range.

    Parameters
    ----------
    key : str
        The key.
    entry : object
        Its value, as TOML has it.
    """
    if not isinstance(entry, Mapping):
        return ""
    given = {name: value for name, value in entry.items() if name != "between"}
    kind = DISTRIBUTIONS.get(frozenset(given))
    if kind is None:
        return ""
    if kind == "measured":
        edges, counts = given["edges"], given["counts"]
        told = f"measured, {len(counts)} bins from {edges[0]} to {edges[-1]}"
    else:
        told = f"{kind}, " + ", ".join(f"{name} {given[name]}" for name in ORDER if name in given)
    return told + _cut(key, entry)


def _cut(key: str, entry: Mapping[str, Any]) -> str:
    """Return between what a distribution is left, and how much of it."""
    known = {declaration.key: declaration for declaration in declarations(Config)}
    found = read_axis(key, entry, known).distribution
    if not isinstance(found, Truncated):
        return ""
    low, high = entry["between"]
    return f", between {low} and {high} ({100 * found.kept:.3g} % of it)"
