"""What is to be done in a sweep, and what became of it: values that travel between processes.

No error crosses from process to process. What is in a task may be imported wherever fibermelt is;
the results folder must be the same for all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value
    from fibermelt.engine.parts import Chain
    from fibermelt.sweeps.plan import PlannedCase

__all__ = ["Folder", "Outcome", "Task"]

State = Literal["done", "found", "failed", "busy", "storage"]


@dataclass(frozen=True)
class Folder:
    """Where a sweep writes, and what all of its tasks have in common.

    Parameters
    ----------
    directory : str
        The results folder, absolute.
    base : dict
        The study without its sweep, resolved, in SI.
    chain : Chain
        The stages that there are.
    """

    directory: str
    base: Mapping[str, Value]
    chain: Chain


@dataclass(frozen=True)
class Task:
    """Some work of one kind, done one after the other.

    Parameters
    ----------
    folder : Folder
        Where.
    stage : str
        The stage to keep for each of the cases; empty for the numbers of the cases themselves.
    cases : tuple of PlannedCase
        For which cases.
    starts : dict
        For each of their stages that starts from a neighbour, by its key: a case with that
        neighbour; and so on up to those that start from cold, should one have to be mended.
    """

    folder: Folder
    stage: str
    cases: tuple[PlannedCase, ...]
    starts: Mapping[str, PlannedCase] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What became of one case, or of one stage.

    Parameters
    ----------
    key : str
        Key of the case's numbers, or of the stage.
    state : str
        ``"done"``; ``"found"``: it was there; ``"failed"``; ``"busy"``: somebody else is at it;
        ``"storage"``: the folder cannot be written or read.
    seconds, processor : float
        Wall time and processor time that it took [s].
    failed : str
        Key of the stage that has no answer.
    note : str
        What went wrong with the folder, or what was mended in it.
    """

    key: str
    state: State
    seconds: float = 0.0
    processor: float = 0.0
    failed: str = ""
    note: str = ""
