"""The settings of a sweep: its design, and what of samples, seed and weight that design takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast, get_args

from fibermelt.engine.overrides import SETTINGS
from fibermelt.engine.parameters import excerpt
from fibermelt.errors import ConfigError

__all__ = ["SAMPLED", "SETTINGS", "Design", "Settings", "read_settings"]

Design = Literal["grid", "one-at-a-time", "latin-hypercube", "sobol", "saltelli"]
DESIGNS: tuple[str, ...] = get_args(Design)
SAMPLED = ("latin-hypercube", "sobol", "saltelli")
"""Designs whose cases are samples of distributions."""

UNUSED = {
    "samples": "draws no samples",
    "seed": "draws nothing at random",
    "weight": "has no population whose cases could be weighed",
}
"""Settings of samples, and why a design of another kind takes none of them."""


@dataclass(frozen=True)
class Settings:
    """How the cases of a sweep are made of what varies.

    Parameters
    ----------
    design, samples, seed, weight : str, int, int, str
        As `fibermelt.sweeps.design.Sweep` has them.
    """

    design: Design
    samples: int
    seed: int
    weight: str


def read_settings(table: Mapping[str, Any], varying: Sequence[str]) -> Settings:
    """Return the settings of a table ``[sweep]``.

    Parameters
    ----------
    table : mapping
        The table.
    varying : sequence of str
        Keys under which what varies is told (`Axis.name`).

    Raises
    ------
    ConfigError
        If one cannot be, or is of no use to the design: the key, the value and the way out.
    """
    design = table.get("design", "grid")
    if design not in DESIGNS:
        choices = " or ".join(f'"{name}"' for name in DESIGNS)
        msg = f'sweep.design = "{excerpt(design)}": must be {choices}'
        raise ConfigError(msg)
    samples, seed = _whole(table, "samples"), _whole(table, "seed")
    if design in SAMPLED:
        _refuse_samples(samples, design, len(varying))
    else:
        _refuse_unused(table, design)
    return Settings(cast("Design", design), samples, seed, _weight(table, varying))


def _refuse_unused(table: Mapping[str, Any], design: str) -> None:
    """Refuse settings of samples where none are drawn: mostly the design was forgotten."""
    for name, why in UNUSED.items():
        if name not in table:
            continue
        value = table[name]
        shown = f'"{excerpt(value)}"' if isinstance(value, str) else excerpt(value)
        default = "" if "design" in table else ", which is meant where none is named,"
        msg = (
            f'sweep.{name} = {shown}: design = "{design}"{default} {why}: take design = '
            f'"latin-hypercube", "sobol" or "saltelli", or leave {name} away'
        )
        raise ConfigError(msg)


def _refuse_samples(samples: int, design: str, axes: int) -> None:
    """Refuse a number of samples that a design cannot have."""
    if samples < 1:
        msg = f'sweep.samples = {samples}: design = "{design}" needs at least one'
        raise ConfigError(msg)
    if design in {"saltelli", "sobol"} and samples.bit_count() != 1:
        below = 1 << (samples.bit_length() - 1)
        needs, rest = (
            ("a Saltelli design", f"each is a block of {axes + 2} cases")
            if design == "saltelli"
            else ("a Sobol sequence", 'a Latin hypercube, design = "latin-hypercube", takes any')
        )
        msg = (
            f"sweep.samples = {samples}: {needs} needs a power of two, such as {below} or "
            f"{2 * below}; {rest}"
        )
        raise ConfigError(msg)


def _whole(table: Mapping[str, Any], name: str) -> int:
    value = table.get(name, 0)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        msg = f"sweep.{name} = {excerpt(value)}: must be a whole number, at least 0"
        raise ConfigError(msg)
    return value


def _weight(table: Mapping[str, Any], varying: Sequence[str]) -> str:
    """Return the key by whose value cases are weighed."""
    if "weight" not in table:
        return ""
    weight = table["weight"]
    if weight not in varying:
        msg = (
            f'sweep.weight = "{excerpt(weight)}": must be one of the keys that are sampled, such '
            f"as {varying[0]}"
        )
        raise ConfigError(msg)
    return str(weight)
