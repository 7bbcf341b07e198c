"""What the parts of a study declare for the page: found where they keep it, listed nowhere."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

from fibermelt.study.parts import HOMES

__all__ = ["found"]

T = TypeVar("T")


def found(kind: type[T], room: str) -> list[T]:
    """Return all values of a type that the parts' modules of a name hold, each once.

    Parameters
    ----------
    kind : type
        What is looked for.
    room : str
        Name of the module, or of the package of modules, in each part's package.
    """
    values = [
        value
        for home in HOMES
        for module in _modules(f"{home}.{room}")
        for value in vars(module).values()
        if isinstance(value, kind)
    ]
    return [one for k, one in enumerate(values) if not any(one is other for other in values[:k])]


def _modules(name: str) -> Iterator[ModuleType]:
    """Yield a module and those within it; none if there is none of that name."""
    if find_spec(name) is None:
        return
    module = import_module(name)
    yield module
    for inner in iter_modules(getattr(module, "__path__", ())):
        yield import_module(f"{name}.{inner.name}")
