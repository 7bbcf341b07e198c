"""What a results folder has on show: the files of the last run, and the digests that they had.

``stages/outputs.json`` says which run they are of and which they are. It is gone while they are
replaced, so that files of two runs never pass for those of one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path

from fibermelt.engine.files import (
    claimed,
    digest,
    partial,
    read_sealed,
    remove,
    replace_file,
    storage_errors,
    write_sealed,
)
from fibermelt.errors import DamagedError, StoreError, legible_path

__all__ = [
    "Outputs",
    "has_run",
    "is_published",
    "not_as_written",
    "publish",
    "read_outputs",
    "replace_output",
]


@dataclass(frozen=True)
class Outputs:
    """The files on show.

    Parameters
    ----------
    run : str
        Key of the run that they are of.
    files : dict
        Their digests, by their paths in the folder.
    """

    run: str
    files: Mapping[str, str]


def has_run(directory: Path) -> bool:
    """Tell whether a folder has a finished run on show."""
    return _manifest(directory).exists()


def read_outputs(directory: Path) -> Outputs:
    """Return what a folder has on show.

    Raises
    ------
    DamagedError
        If what says so is not what was written.
    StoreError
        If there is nothing on show (`has_run`), or it cannot be read.
    """
    try:
        return Outputs(**read_sealed(_manifest(directory)))
    except (ValueError, TypeError):
        raise not_as_written(_manifest(directory)) from None


def is_published(directory: Path, run: str, *, but: Path | None = None) -> bool:
    """Tell whether the files on show are those of a run, complete and unchanged.

    Parameters
    ----------
    directory : Path
        The results folder.
    run : str
        Key of the run.
    but : Path, optional
        A file that may have been changed: the study itself, where it is this config.toml.
        It then no longer says what the results are of, and they count as not published.

    Raises
    ------
    DamagedError
        If one of them was changed since it was written: it is not overwritten silently.
    """
    with storage_errors(_manifest(directory)), _alone(directory):
        if not has_run(directory):
            return False
        outputs, complete = read_outputs(directory), True
        for name, expected in outputs.files.items():
            path = directory / name
            if not path.exists():
                complete = False
            elif digest(path.read_bytes()) != expected:
                if but is None or not path.samefile(but):
                    raise not_as_written(path)
                complete = False
        return complete and outputs.run == run


def publish(directory: Path, run: str, write: Callable[[Path], None]) -> None:
    """Put the files of a run on show: all of them are written before the first is replaced.

    Parameters
    ----------
    directory : Path
        A results folder that is there.
    run : str
        Key of the run.
    write : callable
        Writes the files into the folder that it is given.

    Raises
    ------
    StoreError
        If they cannot be written; what was on show before is still there then.
    """
    temporary = partial(directory)
    with storage_errors(directory):
        try:
            temporary.mkdir()
            write(temporary)
            written = [path for path in sorted(temporary.rglob("*")) if path.is_file()]
            digests = {
                path.relative_to(temporary).as_posix(): digest(path.read_bytes())
                for path in written
            }
            with _alone(directory):
                _unlist(directory, but=digests)
                for name in digests:
                    (directory / name).parent.mkdir(parents=True, exist_ok=True)
                    (temporary / name).replace(directory / name)
                _write(directory, run, digests)
        finally:
            remove(temporary)


def replace_output(directory: Path, name: str, data: bytes, run: str) -> None:
    """Replace a file on show by one that was made again from the others.

    It counts as written by the run if the one before did: nobody takes it for changed.

    Parameters
    ----------
    directory : Path
        The results folder.
    name : str
        Path of the file in it.
    data : bytes
        Its content.
    run : str
        Key of the run that it was made of.

    Raises
    ------
    StoreError
        If it cannot be written, or another run was put on show meanwhile; an older file is still
        there then.
    """
    with _alone(directory):
        outputs = read_outputs(directory)
        if outputs.run != run:
            msg = (
                f"{legible_path(directory)}: another run was put on show while {name} was made of "
                "the one before: make it again"
            )
            raise StoreError(msg)
        new = digest(data)
        is_moved = outputs.files.get(name, new) != new
        if is_moved:
            # Who is killed in between leaves a file that is not listed, not a changed one.
            others = {other: seal for other, seal in outputs.files.items() if other != name}
            _write(directory, run, others)
        replace_file(directory / name, data)
        if is_moved:
            _write(directory, run, {**outputs.files, name: new})


def not_as_written(path: Path) -> DamagedError:
    """Return what to say of a file on show that is not what a run wrote, and how to mend it."""
    return DamagedError(
        f"{legible_path(path)}: is damaged, or was changed since it was written; move it away and "
        "run the study again: it is written anew from the stages that are stored (--fresh "
        "computes these anew too)"
    )


def _manifest(directory: Path) -> Path:
    return directory / "stages" / "outputs.json"


def _alone(directory: Path) -> AbstractContextManager[bool]:
    """Hold the lock of what is on show."""
    return claimed(directory / "stages" / "lock", wait=True)


def _write(directory: Path, run: str, files: Mapping[str, str]) -> None:
    write_sealed(_manifest(directory), {"run": run, "files": dict(files)})


def _unlist(directory: Path, but: Mapping[str, str]) -> None:
    """Forget what is on show, and remove what no file of a new run will replace."""
    with suppress(StoreError):
        for name in read_outputs(directory).files.keys() - but.keys():
            remove(directory / name)
    _manifest(directory).unlink(missing_ok=True)
