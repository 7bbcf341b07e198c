"""One stage, done: from its parameters and inputs to its record and its data, for all who run."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from fibermelt.engine.named import named
from fibermelt.engine.stages import Inputs, Neighbour, Say, Stage, refuse_beyond, stage_parameters
from fibermelt.engine.store import Record
from fibermelt.software import versions_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.parameters import Value

__all__ = ["execute", "software_versions"]

SOFTWARE = ("fibermelt", "ngsolve", "numpy", "scipy", "xarray", "h5netcdf", "h5py", "matplotlib")
"""Packages whose versions are recorded beside the numbers."""


def execute(
    stage: Stage,
    values: Mapping[str, Value],
    keys: Mapping[str, str],
    inputs: Inputs,
    say: Say,
    start: Neighbour | None = None,
) -> tuple[Record, xr.Dataset]:
    """Compute a stage and return its record and its data, both as they are stored.

    Parameters
    ----------
    stage : Stage
        What to compute.
    values : mapping
        The resolved study.
    keys : mapping
        The keys of its stages, by their names.
    inputs : mapping
        The data of the stages that it is fed, by their names.
    say : callable
        Takes lines of progress.
    start : Neighbour, optional
        What it begins with, if it can; the record names it where it led to the data.

    Raises
    ------
    FibermeltError
        If it has no answer, also where what it found is not good by its own estimate.
    """
    from threadpoolctl import threadpool_limits  # noqa: PLC0415  lazy: what is stored needs none

    parameters = stage_parameters(stage, values)
    scaled = stage.multiple(parameters)
    began, busy = time.perf_counter(), time.process_time()
    # Stages do much small algebra: threads of a BLAS that wait cost more than they bring.
    with threadpool_limits(limits=1, user_api="blas"):
        if stage.compute_from is None or start is None:
            data, is_from_it = named(stage.compute)(scaled.reference, inputs, say), False
        else:
            data, is_from_it = named(stage.compute_from)(scaled.reference, inputs, say, start)
        refuse_beyond(stage.name, named(stage.estimates)(parameters, scaled.of(data)))
    record = Record(
        stage=stage.name,
        version=stage.version,
        key=keys[stage.name],
        parameters=dict(scaled.reference),
        inputs={name: keys[name] for name in stage.fed(values)},
        cost=time.perf_counter() - began,
        data="",
        software=software_versions(),
        processor=time.process_time() - busy,
        neighbour=start.key if start is not None and is_from_it else "",
    )
    return record, data


@cache
def software_versions() -> dict[str, str]:
    """Return the versions of what computes."""
    return versions_of(SOFTWARE)
