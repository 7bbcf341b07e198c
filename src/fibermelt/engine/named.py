"""What is named now and loaded when it is used, so that a study that is stored costs nothing."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

__all__ = ["named"]


def named(address: str | Callable[..., Any]) -> Callable[..., Any]:
    """Return the function of an address, ``"fibermelt.parts.bead.stages:motion_stage"``.

    Parameters
    ----------
    address : str or callable
        Module and name with a colon between; a function is its own address.
    """
    return address if callable(address) else _loaded(address)


@cache
def _loaded(address: str) -> Callable[..., Any]:
    module, _, name = address.partition(":")
    found: Callable[..., Any] = getattr(import_module(module), name)
    return found
