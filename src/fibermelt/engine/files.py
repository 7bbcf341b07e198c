"""Files that are either there and whole, or not there: atomic writes, digests, sealed JSON."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import secrets
import shutil
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from fibermelt.errors import StoreError

__all__ = [
    "canonical",
    "claimed",
    "digest",
    "has_dead_maker",
    "made_name",
    "partial",
    "read_sealed",
    "refuse_no_parent",
    "remove",
    "remove_leftovers",
    "replace_file",
    "replace_folder",
    "storage_errors",
    "write_sealed",
    "write_through",
]

PARTIAL = ".partial-"
"""How a name begins while its content is being written."""

_PROCESS = secrets.token_hex(4)
"""Tells this process from an earlier one that had the same number."""

LEFTOVER_AGE = 24 * 3600.0
"""Age [s] after which a partial file of another machine is taken for the leftover of a dead run."""


@contextmanager
def storage_errors(path: Path) -> Iterator[None]:
    """Turn what the operating system says of a file into one line with a remedy.

    Raises
    ------
    StoreError
        For every OSError inside.
    """
    try:
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        if error.errno in {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}:
            remedy = "free some space and run again: finished stages are kept"
        elif error.errno in {errno.EIO}:
            remedy = "the disk reports a fault: choose another folder with --out"
        else:
            remedy = "choose another folder with --out"
        msg = f"{path}: cannot be written or read: {reason}; {remedy}"
        raise StoreError(msg) from error


@contextmanager
def claimed(path: Path, *, wait: bool) -> Iterator[bool]:
    """Hold a lock that goes when its process goes, and yield whether it is ours.

    Where there is no such lock (Windows, some network drives) it is always ours: clients that
    share a folder there may compute the same twice, to the same result.

    Parameters
    ----------
    path : Path
        A file of its own, removed at the end.
    wait : bool
        Whether to wait for who has it.

    Raises
    ------
    StoreError
        If the file cannot be made.
    """
    try:
        import fcntl  # noqa: PLC0415  there is none on Windows
    except ImportError:
        yield True
        return
    while True:
        with storage_errors(path):
            # Held to the end of the block below: no context manager spans the retries.
            stream = path.open("ab")
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            stream.close()
            yield False
            return
        except OSError:
            break  # no locks on this file system
        if _still_there(path, stream):
            break
        stream.close()
    try:
        yield True
    finally:
        path.unlink(missing_ok=True)
        stream.close()


def _still_there(path: Path, stream: BinaryIO) -> bool:
    """Tell whether a file that was opened is the one that has its name now."""
    try:
        return os.fstat(stream.fileno()).st_ino == path.stat().st_ino
    except FileNotFoundError:
        return False


def canonical(value: Any) -> bytes:
    """Return JSON bytes that depend on the value only: sorted keys, no blanks, no NaN."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False).encode()


def digest(data: bytes) -> str:
    """Return the SHA-256 of some bytes, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def write_through(path: Path, data: bytes) -> None:
    """Write a file and wait until it is on the disk."""
    with path.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())


def made_name(prefix: str) -> str:
    """Return a name that nothing else has, and that tells which process gave it.

    Parameters
    ----------
    prefix : str
        How it begins.
    """
    return f"{prefix}{_host()}-{os.getpid()}-{_PROCESS}{secrets.token_hex(4)}"


def has_dead_maker(name: str, prefix: str) -> bool | None:
    """Tell whether the process that gave a name is gone.

    Parameters
    ----------
    name, prefix : str
        What `made_name` returned, and how it begins.

    Returns
    -------
    bool or None
        None if nothing tells: the process is of another machine, or nothing of ours gave the name.
    """
    maker = _maker(name, prefix)
    if maker is None or maker[0] != _host() or os.name != "posix":
        return None
    _, process, token = maker
    return _is_dead(process) or (process == os.getpid() and not token.startswith(_PROCESS))


def _maker(name: str, prefix: str) -> tuple[str, int, str] | None:
    """Return machine, process and token of a name that `made_name` gave, None of any other."""
    parts = name.removeprefix(prefix).split("-")
    if len(parts) != 3 or not parts[1].isdecimal():
        return None
    return parts[0], int(parts[1]), parts[2]


def _host() -> str:
    return socket.gethostname().replace("-", "_")


def partial(folder: Path) -> Path:
    """Return a name in ``folder`` for what is not finished: it tells who writes it."""
    return folder / made_name(PARTIAL)


def replace_file(path: Path, data: bytes) -> None:
    """Write a file under another name and rename it: nobody ever sees half of it.

    Raises
    ------
    StoreError
        If the disk is full, the folder is read-only or the like; the old file is still there.
    """
    with storage_errors(path):
        temporary = partial(path.parent)
        try:
            write_through(temporary, data)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)


def replace_folder(path: Path, write: Callable[[Path], None]) -> None:
    """Write a folder under another name and rename it: nobody ever sees half of it.

    Parameters
    ----------
    path : Path
        Where to; what is there already goes once the new one is whole.
    write : callable
        Writes the folder that it is given the name of, which is not there yet.

    Raises
    ------
    StoreError
        If it cannot be written; the old folder is still there then.
    """
    temporary, old = partial(path.parent), partial(path.parent)
    with storage_errors(path):
        try:
            write(temporary)
            if path.exists():
                path.rename(old)
            try:
                temporary.rename(path)
            except OSError:
                if old.exists():
                    old.rename(path)
                raise
        finally:
            remove(temporary)
            remove(old)


def refuse_no_parent(path: Path) -> None:
    """Refuse to write where there is no folder for it (`StoreError`)."""
    if not path.parent.is_dir():
        msg = f"{path}: there is no folder {path.parent}; make it, or name another with --to"
        raise StoreError(msg)


def remove_leftovers(folder: Path) -> None:
    """Remove what killed runs left unfinished; what a living process writes stays."""
    for leftover in folder.glob(f"{PARTIAL}*"):
        if _is_abandoned(leftover):
            remove(leftover)


def remove(path: Path) -> None:
    """Remove a file or a folder with all that is in it, if it is there."""
    with suppress(FileNotFoundError):
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()


def _is_abandoned(leftover: Path) -> bool:
    if _maker(leftover.name, PARTIAL) is None:
        return False
    is_dead = has_dead_maker(leftover.name, PARTIAL)
    if is_dead is not None:
        return is_dead
    try:
        return time.time() - leftover.stat().st_mtime > LEFTOVER_AGE
    except FileNotFoundError:
        return False


def _is_dead(process: int) -> bool:
    """Tell whether a process of this machine is gone, or was killed and waits for its parent."""
    try:
        os.kill(process, 0)
        # The state follows the name in brackets, which may hold anything.
        state = Path(f"/proc/{process}/stat").read_text(errors="replace").rpartition(")")[2].split()
    except ProcessLookupError:
        return True
    except OSError:
        return False
    return state[:1] == ["Z"]


def write_sealed(path: Path, content: Mapping[str, Any]) -> None:
    """Write JSON with its own digest in it, so that a later reader knows that it is whole."""
    replace_file(path, sealed(content))


def read_sealed(path: Path) -> dict[str, Any]:
    """Return the content of sealed JSON.

    Every byte counts: the last of 17 digits need not change the number that is read, and no
    digest of what is read would tell.

    Raises
    ------
    ValueError
        If it is not what was written.
    """
    with storage_errors(path):
        data = path.read_bytes()
    is_compact = not data.startswith(b"{\n")
    with suppress(ValueError, KeyError, TypeError, RecursionError):
        content = json.loads(data)["content"]
        if isinstance(content, dict) and sealed(content, compact=is_compact) == data:
            return content
    msg = f"{path} is not what was written"
    raise ValueError(msg)


def sealed(content: Mapping[str, Any], *, compact: bool = False) -> bytes:
    """Return content as JSON with its own digest in it, for a reader or without a blank."""
    body = canonical(content)
    seal = digest(body)
    if compact:
        return b'{"content":%b,"sha256":"%b"}' % (body, seal.encode())
    return json.dumps({"content": content, "sha256": seal}, indent=1).encode()
