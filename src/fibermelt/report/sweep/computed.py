"""What the report of a sweep tells of how it was computed, and of its sources."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from fibermelt.engine.progress import duration
from fibermelt.numerals import ERROR_DIGITS
from fibermelt.parts.flow.quantities import QUANTITIES as FLOW
from fibermelt.report.kit.tables import Column, Table, fixed, number
from fibermelt.report.kit.templates import rendered
from fibermelt.report.page.endmatter import versions_table
from fibermelt.report.page.sources import USES, Source, read_sources, sources_of
from fibermelt.report.page.what_was_run import parameters

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.sweeps.status import Computed
    from fibermelt.sweeps.table import SweepTable

__all__ = ["computed_told", "sources_told"]

INDEX_USES = {
    "saltelli": [
        ("sobol2001", "indices of what a variance is due to"),
        ("saltelli2010", "the design, and the estimators of first and total indices"),
        ("herman2017", "computing them"),
    ],
    "given samples": [
        ("sobol2001", "indices of what a variance is due to"),
        ("plischke2010", "first indices from given samples"),
        ("tissot2012", "the correction of their bias"),
        ("herman2017", "computing them"),
    ],
}
"""Sources of the indices by the kind of design, with what comes from each."""


def computed_told(collected: xr.Dataset, found: SweepTable, computed: Computed) -> Markup:
    """Return how the numbers were computed: from where flows started, errors, cost, versions.

    Parameters
    ----------
    collected : xarray.Dataset
        The collected sweep.
    found : SweepTable
        Its table.
    computed : Computed
        What the records of its folder tell.
    """
    progress = computed.progress
    versions = {name: ", ".join(several) for name, several in computed.software.items()}
    return rendered(
        "report/sweep/computed.html.j2",
        {
            "begun": {name: one for name, one in computed.stages.items() if one.from_neighbour},
            "errors": _errors(collected, found),
            "cost": _cost(computed),
            "wall": duration(progress.wall_s),
            "reused": progress.reused_stages,
            "versions": versions_table("Software that computed", versions),
        },
    )


def _errors(collected: xr.Dataset, found: SweepTable) -> Table:
    """Return the largest error that any flow states of itself, and in which case."""
    rows = []
    for one in FLOW.values():
        if not one.title or one.error not in collected or one.name not in collected:
            continue
        errors = _over_cases(collected, one.error)
        if not np.isfinite(errors).any():
            continue
        case = int(np.nanargmax(errors))
        value = float(_over_cases(collected, one.name)[case])
        rows.append(
            (
                one.title,
                number(one.factor * float(errors[case]), ERROR_DIGITS),
                number(one.factor * value),
                one.shown_unit or "–",
                f"{case + 1}. {found.point(case)}",
            )
        )
    columns = (
        Column("Quantity", is_text=True),
        Column("Largest error"),
        Column("Value there"),
        Column("Unit", is_text=True),
        Column("Case", is_text=True),
    )
    return Table("Largest stated errors of the flows", columns, rows)


def _cost(computed: Computed) -> Table:
    """Return what stages and cases cost when they were computed."""
    progress = computed.progress
    rows = [
        (name, str(cost.stored), _seconds(cost.processor), fixed(cost.seconds, 1))
        for name, cost in computed.stages.items()
    ]
    processor, wall = progress.cases_processor_s, progress.cases_s
    if progress.cases:
        count = str(progress.cases)
        rows.append(("all else, by case", count, _seconds(processor), fixed(wall, 1)))
    if rows:
        kept = computed.stages.values()
        processor += sum(cost.processor for cost in kept)
        wall += sum(cost.seconds for cost in kept)
        rows.append(("together", "", _seconds(processor), fixed(wall, 1)))
    columns = (
        Column("Stage", is_text=True),
        Column("Computed"),
        Column("Processor time", "s"),
        Column("Wall time", "s"),
    )
    return Table("Cost", columns, rows)


def _seconds(value: float) -> str:
    """Return a time [s]; a dash for what was computed before it was recorded."""
    return fixed(value, 1) if value else "–"


def sources_told(collected: xr.Dataset, found: SweepTable) -> Markup:
    """Return the sources that any case makes use of, and those of the design.

    Parameters
    ----------
    collected : xarray.Dataset
        The collected sweep; models and laws may be what varies.
    found : SweepTable
        Its table.
    """
    values = parameters(collected)
    every: dict[str, tuple[Source, str]] = {}
    for choice in _choices(collected, values):
        for source, what in sources_of({**values, **choice}):
            every.setdefault(source.key, (source, what))
    order = [use.key for use in USES]
    used = sorted(every.values(), key=lambda one: order.index(one[0].key))
    every_source = [*used, *_design_sources(collected, found)]
    return rendered("report/page/sources.html.j2", {"sources": every_source})


def _design_sources(collected: xr.Dataset, found: SweepTable) -> list[tuple[Source, str]]:
    """Return the sources of a sampled design: of its quantiles, indices and distributions."""
    if not found.is_sampled:
        return []
    uses = [("hyndman1996", "quantiles of samples (its fifth rule, Hazen's)")]
    if len(found.axes) > 1:
        uses += INDEX_USES["saltelli" if found.design == "saltelli" else "given samples"]
    entries = json.loads(collected.attrs["sweep"]).values()
    if any(isinstance(entry, dict) and "shape" in entry for entry in entries):
        uses.append(("fu1996", "the Weibull distribution of fiber lengths"))
    every = read_sources()
    return [(every[key], what) for key, what in uses]


def _choices(collected: xr.Dataset, values: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the different values of all that varies and is no number, as they come together.

    Of numbers it matters only that they are given: the first stands for all.
    """
    varied = [str(key) for key in collected.coords if key in values]
    columns = [_over_cases(collected, key) for key in varied]
    if not columns:
        return [{}]
    texts = [column.dtype.kind in "OUS" for column in columns]
    rows = {
        tuple(
            column[case if is_text else 0].item() if not is_text else str(column[case])
            for column, is_text in zip(columns, texts, strict=True)
        )
        for case in range(len(columns[0]))
    }
    return [dict(zip(varied, row, strict=True)) for row in sorted(rows, key=str)]


def _over_cases(collected: xr.Dataset, name: str) -> Any:
    """Return a variable that each case has one of, case by case, or what varies likewise."""
    status = collected["status"]
    return collected[name].broadcast_like(status).transpose(*status.dims).to_numpy().ravel()
