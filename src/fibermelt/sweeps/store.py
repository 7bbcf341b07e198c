"""The part of a results folder that a sweep has besides the stages of `fibermelt.engine.store`.

::

    DIR/sweep.json                        what was asked: the study, its cases, their keys
    DIR/cases/batch-<digest>.npz          numbers of finished cases, some tens in a file
    DIR/cases/failed-<stage>-<key>.json   a stage without an answer: why, and its parameters
    DIR/cases/progress.json               how far the last run was
    DIR/cases/locks/                      who computes what at this moment

Every file is written under another name and renamed, so it is there whole or not at all, and
carries its digest, in its name or inside. Arrays are of numbers and texts, all else is
JSON: no pickle is read, nothing that is read is run.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fibermelt.engine.files import (
    digest,
    read_sealed,
    remove_leftovers,
    replace_file,
    sealed,
    storage_errors,
    write_sealed,
)
from fibermelt.engine.schema import SCHEMA, is_ours, no_folder
from fibermelt.engine.store import KEY_LENGTH, Store, stage_name
from fibermelt.errors import DamagedError, StoreError
from fibermelt.sweeps.collection import Batch

__all__ = ["CaseStore", "Failure", "damaged_batch", "open_case_store", "stage_folder"]


NO_BATCH = (ValueError, KeyError, EOFError, zipfile.BadZipFile)
"""What reading a file raises that no sweep wrote, whatever its name: objects in it, for one."""


@dataclass(frozen=True)
class Failure:
    """Why a stage has no answer.

    Parameters
    ----------
    stage, key : str
        The stage, and its key.
    kind : str
        Type of the error.
    reason : str
        What it says.
    parameters : dict
        What the stage was given, resolved, in SI.
    lasting : bool
        Whether it would fail again: a solve without an answer does, a worker that was killed or a
        mistake in the code need not.
    """

    stage: str
    key: str
    kind: str
    reason: str
    parameters: Mapping[str, Any]
    lasting: bool


class CaseStore:
    """What a results folder holds of a sweep; nothing is written until a method that writes.

    Parameters
    ----------
    directory : Path
        The results folder.
    """

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.folder = directory / "cases"
        self.locks = self.folder / "locks"
        self.damaged: list[Path] = []
        self._results: dict[str, tuple[str, ...]] = {}

    # What was asked.

    def write_sweep(self, content: Mapping[str, Any]) -> None:
        """Write what was asked, unless it is there already."""
        path = self.directory / "sweep.json"
        data = sealed({"schema": SCHEMA, **content}, compact=True)
        with storage_errors(path):
            if path.exists() and path.read_bytes() == data:
                return
        replace_file(path, data)

    def read_sweep(self) -> dict[str, Any]:
        """Return what was asked.

        Raises
        ------
        StoreError
            If no sweep was, or the file is damaged or of another schema.
        """
        path = self.directory / "sweep.json"
        if not path.exists():
            if self.is_begun():
                msg = f"{path}: is missing; {self._anew()}"
                raise StoreError(msg)
            what = no_folder(self.directory) or "holds no sweep"
            msg = f"{self.directory}: {what}; name a folder that fibermelt sweep wrote"
            raise StoreError(msg)
        try:
            content = read_sealed(path)
        except ValueError as error:
            msg = f"{path}: is damaged, or was changed since it was written; {self._anew()}"
            raise StoreError(msg) from error
        if content.get("schema") != SCHEMA:
            msg = f"{path}: has schema {content.get('schema')}, this fibermelt reads {SCHEMA}"
            raise StoreError(msg)
        return content

    def is_begun(self) -> bool:
        """Tell whether a sweep ran into the folder, also if what was asked is lost."""
        return (self.directory / "sweep.json").exists() or self.folder.is_dir()

    def _anew(self) -> str:
        return (
            f"run fibermelt sweep STUDY --out {self.directory} again to write it anew: finished "
            "cases are kept"
        )

    # Finished cases.

    def refresh(self) -> set[str]:
        """Return the keys of all finished cases; only files that are new are read.

        Files that are damaged are named in ``damaged``, and their cases count as not finished.

        Raises
        ------
        StoreError
            If a file cannot be read: it may be whole.
        """
        found: dict[str, tuple[str, ...]] = {}
        self.damaged = []
        with storage_errors(self.folder):
            names = sorted(path.name for path in self.folder.glob("batch-*.npz"))
        for name in names:
            if name in self._results:
                found[name] = self._results[name]
                continue
            try:
                if (data := self._whole(name)) is not None:
                    found[name] = Batch.keys_in(data)
            except (DamagedError, *NO_BATCH):
                self.damaged.append(self.folder / name)
        self._results = found
        return {key for keys in found.values() for key in keys}

    def batches(self) -> Iterator[Batch]:
        """Yield the content of every whole file of finished cases, in order."""
        self.refresh()
        for name in self._results:
            try:
                if (data := self._whole(name)) is not None:
                    yield Batch.from_bytes(data)
            except NO_BATCH as error:
                msg = f"{self.folder / name}: no sweep wrote this: remove it and resume"
                raise StoreError(msg) from error

    def batch_results(self) -> Mapping[str, tuple[str, ...]]:
        """Return the keys of the cases in every file that `refresh` found, by its name."""
        return self._results

    def write_batch(self, batch: Batch) -> None:
        """Write some finished cases.

        Raises
        ------
        StoreError
            If that cannot be; nothing of it is left then.
        """
        data = batch.to_bytes()
        replace_file(self.folder / f"batch-{digest(data)[:KEY_LENGTH]}.npz", data)

    def discard_damaged(self) -> list[Path]:
        """Remove the damaged files that `refresh` found, and return what they were."""
        gone, self.damaged = self.damaged, []
        for path in gone:
            with storage_errors(path):
                path.unlink(missing_ok=True)
        return gone

    def _whole(self, name: str) -> bytes | None:
        """Return the bytes of a file, those which its name tells; None if it was removed."""
        path = self.folder / name
        with storage_errors(path):
            try:
                data = path.read_bytes()
            except FileNotFoundError:
                return None
        if digest(data)[:KEY_LENGTH] != name.removeprefix("batch-").removesuffix(".npz"):
            raise damaged_batch(path)
        return data

    # What has no answer.

    def write_failure(self, failure: Failure) -> None:
        """Write why a stage has no answer."""
        write_sealed(self._failure_path(failure.stage, failure.key), asdict(failure))

    def failures(self) -> dict[str, Failure]:
        """Return all stages that have no answer by their keys; a damaged file counts as none."""
        read = map(_failure, sorted(self.folder.glob("failed-*.json")))
        return {failure.key: failure for failure in read if failure is not None}

    def failure(self, stage: str, key: str) -> Failure | None:
        """Return why a stage has no answer, or None if nothing is known against it."""
        path = self._failure_path(stage, key)
        return _failure(path) if path.exists() else None

    def forget_failures(self, *, lasting: bool) -> None:
        """Remove the failures that may have been an accident, and with ``lasting`` all."""
        # Each is read before it goes: another client may write one at any time.
        for path in self.folder.glob("failed-*.json"):
            known = None if lasting else _failure(path)
            if known is None or not known.lasting:
                with storage_errors(path):
                    path.unlink(missing_ok=True)

    def _failure_path(self, stage: str, key: str) -> Path:
        return self.folder / f"failed-{stage}-{key[:KEY_LENGTH]}.json"

    @property
    def progress(self) -> Path:
        """Return the file that tells how far the last run was."""
        return self.folder / "progress.json"

    def lock(self, name: str) -> Path:
        """Return the file whose lock stands for a stage or a case."""
        return self.locks / f"{name[:KEY_LENGTH]}.lock"


def stage_folder(directory: Path, stage: str, key: str) -> Path:
    """Return where a results folder has a kept stage; it is there or not."""
    return directory / "stages" / stage_name(stage, key)


def open_case_store(directory: Path) -> CaseStore:
    """Return what a sweep has of a folder, made if need be, that is known to be writable.

    Raises
    ------
    StoreError
        If the folder is of another schema, holds files that fibermelt did not write, or cannot
        be written.
    """
    cases = CaseStore(directory)
    if not (directory / "stages" / "store.json").exists() and not is_ours(directory):
        for path in (directory / "sweep.json", cases.folder):
            if path.exists():
                msg = (
                    f"{directory}: holds {path.name}, which no run of fibermelt keeps track of; "
                    "it is not overwritten: choose another folder with --out, or move it away"
                )
                raise StoreError(msg)
    store = Store.open(directory)
    try:
        with storage_errors(cases.folder):
            cases.locks.mkdir(parents=True, exist_ok=True)
            remove_leftovers(cases.folder)
    except StoreError:
        store.discard_if_empty()
        raise
    return cases


def _failure(path: Path) -> Failure | None:
    try:
        return Failure(**read_sealed(path))
    except (ValueError, TypeError, StoreError):
        return None


def damaged_batch(path: Path) -> DamagedError:
    """Return what is to be said of numbers of cases that are not what was written."""
    return DamagedError(
        f"{path}: is damaged, or was changed since it was written; fibermelt resume "
        f"{path.parent.parent} computes its cases anew"
    )
