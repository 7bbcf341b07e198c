"""What results say of the study that they are of."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any, TypeVar

from fibermelt.engine.parameters import Section

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["has_conditions_of_paper", "study_of", "table_of"]

Table = TypeVar("Table", bound=Section)


def study_of(results: xr.Dataset) -> dict[str, Any]:
    """Return the study that results hold as tables, in SI; empty if they hold none."""
    return tomllib.loads(results.attrs.get("config", ""))


def table_of(results: xr.Dataset, name: str, kind: type[Table]) -> Table:
    """Return a table of the study that results hold; what they do not hold has its default."""
    return kind.model_validate(study_of(results).get(name, {}))


def has_conditions_of_paper(results: xr.Dataset) -> bool:
    """Tell whether results are of the paper's study, whatever parts of it were computed."""
    return results.attrs.get("conditions") == "paper"
