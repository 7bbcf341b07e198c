"""The scheduler of a cluster that is there already: its address, and whether one answers there.

dask.distributed is imported when a cluster is wanted, and never for anything else.
"""

from __future__ import annotations

import asyncio
import json
import re
from concurrent import futures
from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import Any

from fibermelt.engine.parameters import excerpt
from fibermelt.errors import ConfigError, FibermeltError

__all__ = ["CONNECT", "GONE", "connect", "distributed"]

CONNECT = 20.0
"""Time [s] in which a scheduler has to answer: it is there, or it is not."""

ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://[^/\s]+:\d{1,5}/?")
"""What dask takes for the address of a scheduler."""


GONE = (OSError, RuntimeError, asyncio.CancelledError, futures.CancelledError)
"""What a client of dask raises whose scheduler goes while it is asked: a connection that breaks or
cannot be made, one wanted of a client that was closed, a future that is given up."""


def distributed() -> Any:
    """Return dask.distributed, of whose functions some have types and some have not."""
    return import_module("distributed")


def connect(scheduler: str, folder: Path) -> Any:
    """Return a client of a scheduler.

    Parameters
    ----------
    scheduler : str
        Its address (``"tcp://host:port"``) or the path of its file.
    folder : Path
        The results folder, from which no scheduler is ever taken.

    Raises
    ------
    ConfigError
        If that is no address, no file with one, or the address of something else of dask.
    FibermeltError
        If no scheduler answers there.
    """
    address = _address(scheduler, folder)
    try:
        kind = _kind_of(address)
        client = None
        if kind == "Scheduler":
            client = distributed().Client(address, timeout=CONNECT, set_as_default=False)
    except Exception as error:
        is_told = isinstance(error, OSError | ValueError | TypeError | ImportError)
        reason = (str(error) or type(error).__name__) if is_told else "it sends what dask does not"
        msg = (
            f"--scheduler {scheduler}: does not answer as a scheduler does ({reason}): "
            "start one with dask scheduler, or drop --scheduler"
        )
        raise FibermeltError(msg) from error
    if client is None:
        msg = (
            f"--scheduler {scheduler}: is the address of a {excerpt(kind)} of dask, not of its "
            "scheduler, which dask scheduler tells as it starts"
        )
        raise ConfigError(msg)
    return client


def _address(scheduler: str, folder: Path) -> str:
    """Return the address of a scheduler that is told by it or by a file."""
    address = scheduler
    if "://" not in scheduler:
        path = Path(scheduler)
        if not path.is_file():
            msg = (
                f"--scheduler {scheduler}: neither an address such as tcp://host:8786 nor a "
                "scheduler file"
            )
            raise ConfigError(msg)
        if path.resolve().is_relative_to(folder.resolve()):
            msg = (
                f"--scheduler {scheduler}: lies in the results folder, whose content is never "
                "taken for the address of a scheduler: keep it elsewhere"
            )
            raise ConfigError(msg)
        address = _written(path)
    if not ADDRESS.fullmatch(address):
        # dask would answer with a client half made, that hangs and complains as it is dropped.
        msg = f"--scheduler {scheduler}: is no address such as tcp://host:8786"
        raise ConfigError(
            msg if address == scheduler else f"{msg}, nor is {excerpt(address)} in it"
        )
    return address


def _kind_of(address: str) -> str:
    """Return what of dask listens at an address, such as ``"Scheduler"``.

    A client of dask bounds the time of a connection only: it would wait forever for the first
    word of another service that keeps silent.

    Raises
    ------
    TimeoutError
        If nothing of dask has answered in `CONNECT`.
    Exception
        Whatever dask makes of what answers.
    """
    dd = distributed()

    async def ask() -> str:
        secrets = dd.Security().get_connection_args("client")
        # Bounded by who waits, below: of two limits that are alike, now one would end it, now one.
        async with dd.rpc(address, timeout=2 * CONNECT, connection_args=secrets) as link:
            return str((await link.identity())["type"])

    answer: futures.Future[str] = futures.Future()

    def wait() -> None:
        try:
            answer.set_result(asyncio.run(asyncio.wait_for(ask(), CONNECT)))
        except Exception as error:
            answer.set_exception(error)

    # A loop of its own: there may be one in this thread, as in a notebook.
    Thread(target=wait, daemon=True).start()
    try:
        return answer.result(CONNECT + 1.0)
    except TimeoutError:
        msg = f"nothing of dask has answered in {CONNECT:g} s"
        raise TimeoutError(msg) from None


def _written(path: Path) -> str:
    """Return the address that a scheduler file holds."""
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["address"])
    except (OSError, ValueError, LookupError, TypeError):
        msg = (
            f"--scheduler {path}: holds no address of a scheduler: have dask scheduler "
            "--scheduler-file write it"
        )
        raise ConfigError(msg) from None
