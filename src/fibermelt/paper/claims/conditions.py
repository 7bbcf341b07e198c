"""Under which conditions a study is the paper's."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from fibermelt.errors import ConfigError

if TYPE_CHECKING:
    from fibermelt.engine.tables import Tables

__all__ = ["conditions_of", "refuse_nothing_to_judge"]

CONDITIONS = ("flow", "melt", "fiber", "streamlines", "interaction", "sensitivity", "numerics")
"""The tables of a study that make its conditions."""


def conditions_of(study: Tables) -> dict[str, str]:
    """Return the attribute that says whose conditions a study has, the paper's or its own."""
    paper = _paper()
    same = all(
        table == type(table).model_validate(paper.get(name, {}))
        for name in CONDITIONS
        for table in [getattr(study, name)]
    )
    return {"conditions": "paper" if same else "own"}


@cache
def _paper() -> dict[str, Any]:
    """Return the tables of the paper's study, as they ship."""
    return tomllib.loads(
        files("fibermelt.data").joinpath("studies", "paper.toml").read_text("utf-8")
    )


def refuse_nothing_to_judge(study: Tables) -> None:
    """Refuse claims alone.

    Raises
    ------
    ConfigError
        What to name beside them.
    """
    if study.study.parts == ("claims",):
        msg = (
            'study.parts = ["claims"]: nothing to judge them by; name "bead", "orbits", '
            '"interaction" or "voids" beside it'
        )
        raise ConfigError(msg)
