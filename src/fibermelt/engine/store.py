"""The results folder: finished stages under the hash of what made them.

::

    DIR/config.toml  summary.json  results.nc  flow.vtu  figures/     what a person looks at
    DIR/stages/store.json                                             the schema of this folder
    DIR/stages/<stage>-<key>/data.nc, record.json                     a finished stage
    DIR/stages/outputs.json                     digests of what is on show (`study.outputs`)

A stage is written under a temporary name and renamed when it is whole, so a killed run loses
at most the stage that it was in. Every file is checked against its digest before it is used.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from dataclasses import replace as changed
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import (
    digest,
    partial,
    read_sealed,
    remove,
    remove_leftovers,
    replace_file,
    storage_errors,
    write_sealed,
    write_through,
)
from fibermelt.engine.netcdf import from_bytes, to_bytes
from fibermelt.engine.schema import SCHEMA, refuse_foreign
from fibermelt.errors import DamagedError, StoreError, legible_path

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["KEY_LENGTH", "Record", "Store", "stage_name"]

KEY_LENGTH = 20
"""Digits of a key in a file name: 80 bits; the record holds, and is checked for, all of them."""


@dataclass(frozen=True)
class Record:
    """What is known of a finished stage.

    Parameters
    ----------
    stage, version : str, int
        Which stage, and of which version.
    key : str
        Hash of the stage, its version, its parameters and the keys of its inputs.
    parameters : dict
        The parameters that it read, resolved, in SI.
    inputs : dict
        Keys of the stages that it was fed.
    cost : float
        Wall time that it took [s].
    data : str
        SHA-256 of its data.nc.
    software : dict
        Versions of what computed it.
    processor : float
        Processor time that it took [s]; 0 in records from before it was kept.
    neighbour : str
        Key of the same stage of another case from whose result this one came; empty: from cold,
        also where it was to start from one that led nowhere.
    """

    stage: str
    version: int
    key: str
    parameters: Mapping[str, Any]
    inputs: Mapping[str, str]
    cost: float
    data: str
    software: Mapping[str, str]
    processor: float = 0.0
    neighbour: str = ""


class Store:
    """A results folder that can be read and written; use `Store.open`."""

    def __init__(self, directory: Path, made: tuple[Path, ...]) -> None:
        self.directory = directory
        self._stages = directory / "stages"
        self._made = made

    @classmethod
    def open(cls, directory: Path, *, fresh: bool = False) -> Store:
        """Return the store of a folder, made if need be, that is known to be writable.

        With ``fresh`` a damaged mark of its schema is written anew rather than refused.

        Raises
        ------
        StoreError
            If the folder is of another schema, holds files that fibermelt did not write, or
            cannot be written.
        """
        with storage_errors(directory):
            refuse_foreign(directory, directory / "stages" / "store.json", fresh=fresh)
            chain = (directory / "stages", directory, *directory.parents)
            store = cls(directory, tuple(folder for folder in chain if not folder.exists()))
        try:
            with storage_errors(directory):
                store._mark()
                remove_leftovers(directory)
                remove_leftovers(store._stages)
        except StoreError:
            store.discard_if_empty()
            raise
        return store

    def discard_if_empty(self) -> None:
        """Remove what `open` made if no stage was finished in it: a failure leaves nothing."""
        with suppress(OSError):
            names = {entry.name for entry in self._stages.iterdir()}
            if self._made and names <= {"store.json"}:
                (self._stages / "store.json").unlink(missing_ok=True)
            for folder in self._made:
                folder.rmdir()

    def find(self, stage: str, key: str) -> Record | None:
        """Return the record of a finished stage whose data are whole, or None if there is none.

        Raises
        ------
        DamagedError
            If it is there but damaged.
        """
        folder = self._folder(stage, key)
        if not folder.is_dir():
            return None
        record = self._read_record(folder)
        if record.key != key:
            raise _damaged_stage(folder / "record.json")
        self._read_data(record)
        return record

    def records(self) -> Iterator[tuple[Record, int]]:
        """Yield the record of every finished stage and its size [bytes]; no damaged one."""
        for folder in sorted(self._stages.glob("[!.]*-*")):
            with suppress(StoreError, OSError):
                record = self._read_record(folder)
                yield record, sum(path.stat().st_size for path in folder.iterdir())

    def load(self, record: Record) -> xr.Dataset:
        """Return the data of a finished stage.

        Raises
        ------
        DamagedError
            If they are damaged.
        """
        return from_bytes(self._read_data(record))

    def save(self, record: Record, dataset: xr.Dataset, *, replace: bool = False) -> Record:
        """Store a finished stage and return its record with the digest of its data.

        Parameters
        ----------
        record : Record
            What is known of it.
        dataset : xarray.Dataset
            Its data.
        replace : bool
            Whether it takes the place of one that is there; else whoever came first stays.

        Raises
        ------
        StoreError
            If it cannot be written; nothing of it is left then.
        """
        data = to_bytes(dataset)
        sealed = changed(record, data=digest(data))
        folder = self._folder(record.stage, record.key)
        temporary = partial(self._stages)
        with storage_errors(folder):
            try:
                self._mark()
                temporary.mkdir()
                write_through(temporary / "data.nc", data)
                write_sealed(temporary / "record.json", asdict(sealed))
                if replace and folder.exists():
                    old = partial(self._stages)
                    folder.rename(old)
                    remove(old)
                try:
                    temporary.rename(folder)
                except OSError:
                    if not folder.exists():
                        raise
            finally:
                remove(temporary)
        return sealed

    def _mark(self) -> None:
        """Say which schema this folder has; the write shows that it can be written at all."""
        self._stages.mkdir(parents=True, exist_ok=True)
        replace_file(self._stages / "store.json", json.dumps({"schema": SCHEMA}).encode())

    def _folder(self, stage: str, key: str) -> Path:
        return self._stages / stage_name(stage, key)

    def _read(self, path: Path) -> bytes:
        with storage_errors(path):
            return path.read_bytes()

    def _read_record(self, folder: Path) -> Record:
        path = folder / "record.json"
        if not path.exists():
            raise _damaged_stage(path)
        try:
            return Record(**read_sealed(path))
        except (ValueError, TypeError) as error:
            raise _damaged_stage(path) from error

    def _read_data(self, record: Record) -> bytes:
        path = self._folder(record.stage, record.key) / "data.nc"
        if not path.exists() or digest(data := self._read(path)) != record.data:
            raise _damaged_stage(path)
        return data


def stage_name(stage: str, key: str) -> str:
    """Return the name of the folder of a finished stage."""
    return f"{stage}-{key[:KEY_LENGTH]}"


def _damaged_stage(path: Path) -> DamagedError:
    return DamagedError(
        f"{legible_path(path)}: is damaged, or was changed since it was written; run "
        "again: this stage alone is computed anew"
    )
