"""A second process that works beside the first, where there is a core for it.

``python -m fibermelt.engine.helper`` takes pickled calls of functions from its input, each by its
address (`fibermelt.engine.named`), and answers one after the other. A plain child process: it does
not run the caller's script again, as those of multiprocessing do.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from threading import Thread
from typing import Any

from fibermelt.engine.named import named
from fibermelt.engine.stages import Say

__all__ = ["Helper", "HelperLostError", "helped", "one_helper"]

_IDLE: ContextVar[list[Helper] | None] = ContextVar("_IDLE", default=None)
"""Who waits for the next who asks, within `one_helper`."""


def _ignore(line: str) -> None:
    """Ignore a line of progress."""


class HelperLostError(Exception):
    """The second process is gone, or what it was asked for failed: do it here, to be told why."""


class Helper:
    """The second process."""

    def __init__(self) -> None:
        self.is_lost = False
        self._process = subprocess.Popen(
            [sys.executable, "-m", "fibermelt.engine.helper"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )

    def call(self, address: str, *arguments: object, say: Say = _ignore) -> Any:
        """Have a function called there, and return what it returns.

        Parameters
        ----------
        address : str
            Of the function, which is given the arguments and who takes its lines of progress.
        arguments : object
            They and the answer must be such as can be pickled.
        say : callable
            Is told here what the function says there.

        Raises
        ------
        HelperLostError
            If there is no answer.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(pickle.dumps((address, arguments)))
            self._process.stdin.flush()
            while True:
                is_answer, told = pickle.load(self._process.stdout)
                if is_answer:
                    return told
                say(told)
        # AttributeError: a function within a function cannot be pickled.
        except (OSError, EOFError, ValueError, AttributeError, pickle.PickleError) as error:
            self.is_lost = True
            raise HelperLostError from error

    def kill(self) -> None:
        """End it, whatever it does: who waits for an answer is told that it is lost."""
        self._process.kill()

    def close(self) -> None:
        """Let go of it once it has ended and nobody waits."""
        with suppress(OSError, ValueError):
            self._process.communicate()


@contextmanager
def one_helper() -> Iterator[None]:
    """Have all who are `helped` meanwhile helped by one process, which ends with this."""
    idle: list[Helper] = []
    token = _IDLE.set(idle)
    try:
        yield
    finally:
        _IDLE.reset(token)
        for helper in idle:
            helper.kill()
            helper.close()


@contextmanager
def helped(work: Callable[[Helper], None]) -> Iterator[None]:
    """Have a helper at work while the caller is, and wait for it at the end.

    What fails meanwhile ends it.

    Parameters
    ----------
    work : callable
        Has the helper do what there is, in a thread of its own; it ends where the helper is lost.
    """
    idle = _IDLE.get()
    helper = idle.pop() if idle else Helper()
    thread = Thread(target=work, args=(helper,), daemon=True)
    thread.start()
    is_done = False
    try:
        yield
        thread.join()
        is_done = True
    finally:
        if is_done and idle is not None and not helper.is_lost:
            idle.append(helper)
        else:
            helper.kill()
            thread.join()
            helper.close()


def _main() -> None:
    """Answer calls until there are no more."""
    with os.fdopen(os.dup(1), "wb") as output:
        # What a library prints must not stand between the answers.
        os.dup2(2, 1)

        def tell(*answer: object) -> None:
            pickle.dump(answer, output)
            output.flush()

        while True:
            try:
                address, arguments = pickle.load(sys.stdin.buffer)
            except EOFError:
                return
            tell(True, named(address)(*arguments, lambda line: tell(False, line)))


if __name__ == "__main__":
    _main()
