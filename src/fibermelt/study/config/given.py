"""Files that a study names and that its results depend on: known again by what is in them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import model_validator

from fibermelt.errors import ConfigError, legible_path
from fibermelt.study.parameters import Section, setting

__all__ = ["GivenFile", "fingerprint", "refuse_changed"]

BLOCK = 1 << 20
"""Bytes that are read at a time."""


def fingerprint(file: str) -> str:
    """Return a digest of a file and of those that belong to it, or of all files of a folder.

    Formats of several files name them alike: ``nozzle.cas.h5`` and ``nozzle.dat.h5``,
    ``flow.case`` and ``flow.geo``; what lies beside a file and begins with its name up to the first
    dot belongs to it.

    Raises
    ------
    ConfigError
        If there is no such file, or it cannot be read.
    """
    path = Path(file)
    try:
        if path.is_dir():
            files = sorted(entry for entry in path.rglob("*") if entry.is_file())
        else:
            path.stat()
            stem = path.name.partition(".")[0]
            files = sorted(
                entry
                for entry in path.parent.iterdir()
                if entry.is_file() and entry.name.startswith(stem)
            )
        whole = hashlib.sha256()
        for entry in files:
            whole.update(entry.name.encode() + b"\0")
            with entry.open("rb") as stream:
                while block := stream.read(BLOCK):
                    whole.update(block)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = f"{legible_path(path)}: cannot be read: {reason}"
        raise ConfigError(msg) from error
    return whole.hexdigest()


def refuse_changed(table: str, file: str, content: str) -> None:
    """Refuse a file that is no longer what it was when the study was read (`ConfigError`)."""
    if fingerprint(file) != content:
        msg = (
            f'{table}.file = "{file}": is not what it was when the study was read: bring that file '
            f"back, or leave {table}.content away, and run the study with this one"
        )
        raise ConfigError(msg)


class GivenFile(Section):
    """A table that names a file."""

    content: str = setting(
        "", "Fingerprint of the file, filled in as a study is read: what has changed is computed."
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any) -> Any:
        """Fill in the fingerprint; results that know it do without the file."""
        if not isinstance(data, Mapping):
            return data
        file = data.get("file")
        if not isinstance(file, str) or not file or data.get("content"):
            return data
        try:
            return {**data, "content": fingerprint(file)}
        except ConfigError as error:
            raise ValueError(str(error)) from error
