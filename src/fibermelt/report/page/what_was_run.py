"""What was run, for a person: every parameter in the unit that its default is written in."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from fibermelt.engine.parameters import Declaration, declarations, flatten
from fibermelt.errors import ConfigError, StoreError
from fibermelt.parts.flow.config import SOLVED
from fibermelt.parts.interaction.config import OWN
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.process.config import Process
from fibermelt.report.kit.tables import Column, number
from fibermelt.report.kit.templates import rendered
from fibermelt.study.config import Config
from fibermelt.study.loading import resolve

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["parameters", "title_of", "what_was_run"]

KEY = ("process", "flow", "strand", "field", "paths", "melt", "fiber", "streamlines")
"""Tables of a study of the bead that are open; the others are folded."""

OF_OTHERS = frozenset(
    [f"melt.{name}" for name in Melt.model_fields]
    + [f"process.{name}" for name in Process.model_fields]
    + [f"interaction.{name}" for own in OWN.values() for name in own]
)
"""What a study may have none of and is then not shown: constants of another law or model, what of
the printer is not known."""

LONGEST_LIST = 5
"""Items of a list that are written out; of a longer one the first two, the last, and how many."""

DIGITS = 6
"""Significant digits of a parameter: as many as anybody writes."""

_WRITTEN = {"um": "µm", "kg/m^3": "kg/m³", "degC": "°C"}
"""Units that type has signs for."""

COLUMNS = (Column("Parameter", is_text=True), Column("Value"), Column("", is_text=True))


def title_of(results: xr.Dataset) -> str:
    """Return the study's name."""
    return str(results.attrs.get("title", "")).removeprefix("fibermelt study ") or "unnamed"


def parameters(results: xr.Dataset) -> dict[str, Any]:
    """Return the parameters that were run, flattened, in SI.

    Raises
    ------
    StoreError
        If the results do not hold a study that this fibermelt can read.
    """
    try:
        return dict(flatten(resolve(tomllib.loads(results.attrs["config"]))))
    except (KeyError, tomllib.TOMLDecodeError, ConfigError) as error:
        first = str(error).splitlines()[0]
        msg = (
            f"results.nc: holds no study that this fibermelt reads ({first}); run the study again, "
            "or use the fibermelt that wrote the results"
        )
        raise StoreError(msg) from error


def what_was_run(results: xr.Dataset) -> Markup:
    """Return where the study came from, and its parameters by table.

    Parameters
    ----------
    results : xarray.Dataset
        The store. Parameters that are as `fibermelt defaults` has them are marked as such.
    """
    values = parameters(results)
    defaults = flatten(Config())
    by_section: dict[str, list[Declaration]] = {}
    for declaration in declarations(Config):
        by_section.setdefault(declaration.key.partition(".")[0], []).append(declaration)
    by_section.pop("study", None)
    if all(values[item.key] == defaults[item.key] for item in by_section["process"]):
        del by_section["process"]
    _of_the_source(by_section, values["flow.source"])
    parts = values["study.parts"]
    is_open = set(KEY if "bead" in parts else by_section)
    tables = {
        name: [
            _row(item, values[item.key], defaults[item.key])
            for item in items
            if values[item.key] is not None
            or defaults[item.key] is not None
            or item.key not in OF_OTHERS
        ]
        for name, items in by_section.items()
    }
    return rendered(
        "report/page/what_was_run.html.j2",
        {
            "origin": _origin(results),
            "parts": parts,
            "changed": sum(
                values[item.key] != defaults[item.key]
                for items in by_section.values()
                for item in items
            ),
            "columns": COLUMNS,
            "open": {name: rows for name, rows in tables.items() if name in is_open},
            "others": {name: rows for name, rows in tables.items() if name not in is_open},
        },
    )


def _of_the_source(by_section: dict[str, list[Declaration]], source: str) -> None:
    """Leave out what says of a flow where it does not come from."""
    if source != "deposition-3d":
        del by_section["strand"]
    if source in SOLVED:
        del by_section["field"], by_section["paths"]
        return
    by_section["flow"] = [item for item in by_section["flow"] if item.key == "flow.source"]
    if source == "histories":
        del by_section["field"]
    of_the_file = ("paths.file", "paths.content")
    by_section["paths"] = [
        item for item in by_section["paths"] if (item.key in of_the_file) == (source == "histories")
    ]


def _origin(results: xr.Dataset) -> str:
    """Return the first sentence of the stored study: which one it is, with what overridden."""
    lines = []
    for line in str(results.attrs["config"]).splitlines():
        if not line.startswith("# "):
            break
        lines.append(line.removeprefix("# "))
    preamble = " ".join(lines)
    start, marker, _ = preamble.partition(" as it was run")
    return f"{start}." if marker else ""


def _row(item: Declaration, value: object, default: object) -> dict[str, Any]:
    """Return what is told of a parameter."""
    return {
        "meaning": item.doc.removesuffix("."),
        "key": item.key,
        "value": _value(item, value),
        "is_default": value == default,
        "default": _value(item, default),
    }


def _value(item: Declaration, value: object) -> str:
    """Return a value in the unit of its default; a list too long to read by its ends."""
    if value is None:
        return "not given"
    if not isinstance(value, tuple):
        return _one(item, value)
    items = [_one(item, one) for one in value]
    if not items:
        return "none"
    if len(items) <= LONGEST_LIST:
        return ", ".join(items)
    return f"{items[0]}, {items[1]}, …, {items[-1]} ({len(items)})"


def _one(item: Declaration, value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    if isinstance(value, int) and not item.unit:
        return number(value, DIGITS)
    count, _, unit = item.text(value, DIGITS).partition(" ")
    count = count.replace("-", "−")
    if not unit:
        return count
    return f"{count}°" if unit == "deg" else f"{count}\N{NO-BREAK SPACE}{_WRITTEN.get(unit, unit)}"
