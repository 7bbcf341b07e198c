"""Templates of the pages, which lie beside the code that fills them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from fibermelt.report.kit import tables

__all__ = ["rendered", "text_of"]

FILTERS = (
    tables.fixed,
    tables.measured,
    tables.number,
    tables.percent,
    tables.ranged,
    tables.short,
    tables.sized,
    tables.unbroken,
)
"""How numbers are written, by the same names in templates."""


def text_of(name: str) -> str:
    """Return a file as it is, by its path within fibermelt."""
    return files("fibermelt").joinpath(name).read_text(encoding="utf-8")


@cache
def _environment() -> Environment:
    """Return where templates are found; what they name must be there, and is escaped."""
    environment = Environment(
        loader=PackageLoader("fibermelt", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update({one.__name__: one for one in FILTERS})
    return environment


def rendered(name: str, values: Mapping[str, Any]) -> Markup:
    """Return a template with values in it.

    Parameters
    ----------
    name : str
        Its path within fibermelt, such as ``parts/voids/risk.html.j2``.
    values : mapping
        What it is filled with.
    """
    return Markup(_environment().get_template(name).render(values))
