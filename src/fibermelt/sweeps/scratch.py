"""Where the workers of this machine put what nobody needs once they are gone."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fibermelt.engine.files import has_dead_maker, made_name
from fibermelt.errors import StoreError

__all__ = ["scratch_folder"]

PREFIX = "fibermelt-"
"""How the names begin, in the folder of all temporary files of this machine."""

LOCKS = "*.dirlock"
"""Files that workers of dask lock as long as they live."""


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Yield a new folder for temporary files, which is gone at the end.

    A client that is killed leaves its folder there: the next one removes it, once no process of
    ours is left that may use it.

    Raises
    ------
    StoreError
        If there is no place for it.
    """
    try:
        parent = Path(tempfile.gettempdir())
        _remove_leftovers(parent)
        folder = parent / made_name(PREFIX)
        folder.mkdir(mode=0o700)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        msg = (
            f"no place for the temporary files of workers: {reason}; have TMPDIR name a folder "
            "that can be written, or take --workers 0"
        )
        raise StoreError(msg) from error
    try:
        yield folder
    finally:
        # A worker that is slow to end may still write there: then the next sweep removes it.
        shutil.rmtree(folder, ignore_errors=True)


def _remove_leftovers(parent: Path) -> None:
    for folder in parent.glob(f"{PREFIX}*"):
        if has_dead_maker(folder.name, PREFIX) and _is_ours(folder) and not _is_used(folder):
            shutil.rmtree(folder, ignore_errors=True)


def _is_ours(folder: Path) -> bool:
    """Tell whether this user made a folder: others share the place, and may put links there."""
    try:
        return not folder.is_symlink() and folder.stat().st_uid == os.getuid()
    except OSError:
        return False


def _is_used(folder: Path) -> bool:
    """Tell whether a worker outlived its client, and holds its lock."""
    import fcntl  # noqa: PLC0415  there is none on Windows, where no maker is known to be dead

    for lock in folder.rglob(LOCKS):
        try:
            with lock.open("rb") as stream:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except FileNotFoundError:
            continue
        except OSError:
            return True
    return False
