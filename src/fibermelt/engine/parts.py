"""The parts of a study: which stages each needs, and what it tells of their results."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.named import named
from fibermelt.engine.overrides import varied
from fibermelt.engine.schema import REPORT
from fibermelt.engine.stages import Stage
from fibermelt.engine.wrapping import WIDTH, unbroken, wrapped
from fibermelt.errors import legible_path

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Section, Value

__all__ = ["Chain", "Lent", "Part", "in_words"]


Address = str | Callable[..., Any]
"""A function, or where it is: ``"fibermelt.parts.bead.summary:summarize_bead"``."""


def _no_stages(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return no stage: most parts need the same in every study."""
    return ()


def _nothing(results: xr.Dataset) -> dict[str, Any]:
    """Return what a part says that cannot be asked for."""
    return {}


def _no_words(summary: Mapping[str, Any]) -> list[str]:
    """Return the lines of such a part."""
    return []


def _no_fields(results: xr.Dataset, folder: Path) -> None:
    """Write nothing: most parts have no field besides what is in the results."""


@dataclass(frozen=True)
class Lent:
    """What a part gives to a key of another table that a study leaves out (`Part.lend`).

    Parameters
    ----------
    value : float
        The value, in SI.
    by : tuple of str
        The keys of the part's own tables that it follows from: where a file or an override says one
        of them, what an earlier one said of the key is left behind.
    """

    value: float
    by: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """A share of a study: the tables that it reads, what computes it, and what it tells.

    Parameters
    ----------
    name : str
        What ``study.parts`` calls it.
    stages : tuple of str
        The stages that it needs; those who feed them come along.
    stages_if : callable
        From the resolved study to stages that it needs besides, in some studies only.
    summarize : address
        From the results to its share of summary.json.
    words : address
        From the whole summary to lines for a person.
    write_fields : address
        Writes the fields of the results into a folder (flow.vtu).
    meaning : str
        What it computes, in words; a part without one cannot be asked for: others stand on it.
    brings : tuple of Stage
        The stages that are its own.
    tables : mapping
        The tables of a study that are its own, by name; several parts may bring keys of one.
    traits : frozenset of str
        What it takes for granted of a study, for other parts to refuse what contradicts it.
    refuse : address, optional
        From a resolved study to nothing: raises a `ConfigError` where the part cannot do with it.
    derive : address, optional
        From a resolved study to further values that stages can read.
    derived : mapping
        The tables of those values, and which table of a study each follows from.
    notes : address, optional
        From a resolved study to sentences on what is allowed, and perhaps not meant.
    attributes : address, optional
        From a resolved study to attributes of its results.
    renew : mapping of address
        By the table's name: what of a table is left under one that names another card, law or
        model.
    lend : address, optional
        From the tables of a study as written to a `Lent` for keys of other tables, by key,
        whether the study says those itself or not; asked where there is a table of its own. It
        raises nothing: a table that is at fault lends nothing, and is refused when it is read.
    """

    name: str
    stages: tuple[str, ...] = ()
    summarize: Address = _nothing
    words: Address = _no_words
    write_fields: Address = _no_fields
    meaning: str = ""
    brings: tuple[Stage, ...] = ()
    tables: Mapping[str, type[Section]] = field(default_factory=dict)
    traits: frozenset[str] = frozenset()
    refuse: Address | None = None
    derive: Address | None = None
    derived: Mapping[str, str] = field(default_factory=dict)
    notes: Address | None = None
    attributes: Address | None = None
    renew: Mapping[str, Address] = field(default_factory=dict)
    lend: Address | None = None
    stages_if: Callable[[Mapping[str, Value]], tuple[str, ...]] = _no_stages


@dataclass(frozen=True)
class Chain:
    """All stages that there are, and the parts of a study that are made of them.

    Parameters
    ----------
    stages : tuple of Stage
        In any order.
    parts : tuple of Part
        In the order in which they are told.
    version : int
        Raised whenever the same stages give other files on show.
    """

    stages: tuple[Stage, ...]
    parts: tuple[Part, ...]
    version: int

    def asked(self, names: Collection[str]) -> tuple[Part, ...]:
        """Return the parts of some names."""
        return tuple(part for part in self.parts if part.name in names)

    def needed(self, names: Collection[str], values: Mapping[str, Value]) -> tuple[Stage, ...]:
        """Return the stages that parts of a resolved study need, each after those that feed it."""
        by_name = {stage.name: stage for stage in self.stages}
        found: dict[str, Stage] = {}

        def come(name: str) -> None:
            if name not in found:
                for fed in by_name[name].fed(values):
                    come(fed)
                found[name] = by_name[name]

        for part in self.asked(names):
            for name in part.stages + part.stages_if(values):
                come(name)
        return tuple(found.values())

    def unread(self, study: Study) -> list[str]:
        """Return the tables that a study has, or varies, and none of its parts reads, in lines.

        What has every table is a resolved copy or the defaults: nobody chose its tables.
        """
        parts, values = study.config.study.parts, study.config.values()
        is_copy = set(study.own) >= set(type(study.config).model_fields)
        swept = [key.partition(".")[0] for key in varied(study.sweep or {})]
        tables = dict.fromkeys([*(() if is_copy else study.own), *swept])
        asked = ", ".join(f'"{name}"' for name in parts)
        idle: dict[str, list[str]] = {}
        for table in tables:
            readers = [
                part.name for part in self.parts if table in self._tables([part.name], values)
            ]
            # What names the parts is read, whoever they are.
            if table != "study" and readers and table not in self._tables(parts, values):
                idle.setdefault(readers[0], []).append(f"[{table}]")
        return [
            f"{' and '.join(filter(None, [', '.join(names[:-1]), names[-1]]))} "
            f"{'is' if len(names) == 1 else 'are'} read by no part of this study, study.parts = "
            f'[{asked}]: "{reader}" reads {"it" if len(names) == 1 else "them"}: name that too, or '
            f"leave {'it' if len(names) == 1 else 'them'} away"
            for reader, names in idle.items()
        ]

    def _tables(self, names: Collection[str], values: Mapping[str, Value]) -> set[str]:
        """Return the tables that the stages of some parts read."""
        stages = self.needed(names, values)
        read = {key.partition(".")[0] for stage in stages for key in stage.parameters}
        derived = {name: table for part in self.parts for name, table in part.derived.items()}
        return {derived.get(table, table) for table in read}


def in_words(
    summary: Mapping[str, Any], chain: Chain, study: Study, folder: Path, width: int = WIDTH
) -> str:
    """Return a summary as a few lines for a person, that say where to look.

    Parameters
    ----------
    summary : mapping
        The content of summary.json.
    chain, study : Chain, Study
        What was run.
    folder : Path
        The results folder.
    width : int
        Columns that a line may have; paths are never broken.
    """
    parts = chain.asked(study.config.study.parts)
    names = {"total": "this run"}  # what was reused tells what it took when it was computed
    cost = ", ".join(
        unbroken(f"{names.get(name, name)} {seconds:.1f} s")
        for name, seconds in summary["cost"].items()
    )
    return wrapped(
        [
            *(line for part in parts for line in named(part.words)(summary)),
            *(f"note            {note}" for note in summary.get("notes", ())),
            f"cost            {cost}",
            f"results         {unbroken(legible_path(folder))}",
            f"report          {unbroken(legible_path(folder / REPORT))}",
        ],
        width,
    )
