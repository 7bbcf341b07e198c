"""The files that a page of the report is made of, and its template."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

__all__ = ["page_file", "page_template"]


def page_file(name: str) -> str:
    """Return a file of the folder ``page``."""
    return files("fibermelt.report").joinpath("page", name).read_text(encoding="utf-8")


@cache
def page_template(name: str) -> Any:
    """Return a template of the folder ``page``: what it names must be there, and is escaped."""
    environment = Environment(
        loader=FunctionLoader(page_file),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)
