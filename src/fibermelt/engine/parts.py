"""The parts of a study: which stages each needs, and what it tells of their results."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.schema import REPORT
from fibermelt.engine.stages import Stage
from fibermelt.engine.wrapping import WIDTH, unbroken, wrapped
from fibermelt.errors import legible_path
from fibermelt.parts.melt.melt import DERIVED, values_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Value

__all__ = ["Chain", "Part", "in_words"]


def no_fields(results: xr.Dataset, folder: Path) -> None:
    """Write nothing: most parts have no field besides what is in the results."""


@dataclass(frozen=True)
class Part:
    """A share of a study that can be asked for by its name: some stages, and what they tell.

    Parameters
    ----------
    name : str
        What ``study.parts`` calls it.
    stages : tuple of str
        The stages that it needs; those who feed them come along.
    summarize : callable
        From the results to its share of summary.json.
    words : callable
        From the whole summary to lines for a person.
    write_fields : callable
        Writes the fields of the results into a folder (flow.vtu).
    """

    name: str
    stages: tuple[str, ...]
    summarize: Callable[[xr.Dataset], dict[str, Any]]
    words: Callable[[Mapping[str, Any]], list[str]]
    write_fields: Callable[[xr.Dataset, Path], None] = no_fields


@dataclass(frozen=True)
class Chain:
    """All stages that there are, and the parts of a study that are made of them.

    Parameters
    ----------
    stages : tuple of Stage
        Inputs before those who need them.
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
        """Return the stages that some parts of a resolved study need, with all that feeds them."""
        wanted = {stage for part in self.asked(names) for stage in part.stages}
        for stage in reversed(self.stages):
            if stage.name in wanted:
                wanted.update(stage.fed(values))
        return tuple(stage for stage in self.stages if stage.name in wanted)

    def unread(self, study: Study) -> list[str]:
        """Return the tables that a study has, or varies, and none of its parts reads, in lines.

        What has every table is a resolved copy or the defaults: nobody chose its tables.
        """
        parts, values = study.config.study.parts, values_of(study.config)
        is_copy = set(study.own) >= set(type(study.config).model_fields)
        varied = [
            key.partition(".")[0].strip() for name in study.sweep or () for key in name.split(",")
        ]
        tables = dict.fromkeys([*(() if is_copy else study.own), *varied])
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
        return {DERIVED.get(table, table) for table in read}


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
            *(line for part in parts for line in part.words(summary)),
            *(f"note            {note}" for note in summary.get("notes", ())),
            f"cost            {cost}",
            f"results         {unbroken(legible_path(folder))}",
            f"report          {unbroken(legible_path(folder / REPORT))}",
        ],
        width,
    )
