"""A file on show that is written anew after its run: the list of what is on show goes with it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fibermelt.study.files import (
    digest,
    locked,
    read_sealed,
    replace_file,
    storage_errors,
    write_sealed,
)
from fibermelt.study.store import not_as_written

__all__ = ["replace_shown"]


def replace_shown(directory: Path, name: str, data: bytes) -> None:
    """Replace one file on show, so that the next run knows it for fibermelt's own.

    Another version writes another page of the same results: without its digest a run would take
    it for one that somebody changed. Killed in between, the same call mends it.

    Parameters
    ----------
    directory : Path
        The results folder of a finished run.
    name : str
        The file, from there.
    data : bytes
        Its new content.

    Raises
    ------
    StoreError
        If the file or the list cannot be written, or the list was changed.
    """
    manifest = directory / "stages" / "outputs.json"
    if _listed(manifest)["files"].get(name) in (None, digest(data)):
        replace_file(directory / name, data)
        return
    with storage_errors(manifest), locked(directory / "stages" / "lock"):
        content = _listed(manifest)
        replace_file(directory / name, data)
        files = {**content["files"], name: digest(data)}
        write_sealed(manifest, {**content, "files": files})


def _listed(manifest: Path) -> Mapping[str, Any]:
    try:
        return read_sealed(manifest)
    except ValueError:
        raise not_as_written(manifest) from None
