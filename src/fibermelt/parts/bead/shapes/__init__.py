"""The shapes of fibers that there are: a module each, whose `SHAPE` is found here by itself."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import cast

from fibermelt.parts.bead.shape import FiberShape

__all__ = ["SHAPES", "choices"]


def _found() -> dict[str, FiberShape]:
    """Return all shapes by name, in the order of their ranks."""
    modules = (import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__))
    shapes = sorted((cast("FiberShape", one.SHAPE) for one in modules), key=lambda one: one.rank)
    return {shape.name: shape for shape in shapes}


SHAPES = _found()
"""The shapes by the names that a study has for them, the default first."""


def choices(able: str) -> str:
    """Return the shapes that have an attribute, as words: ``"spheroid" or "ellipsoid"``.

    Parameters
    ----------
    able : str
        Such as ``in_space``.
    """
    return " or ".join(f'"{name}"' for name, shape in SHAPES.items() if getattr(shape, able))
