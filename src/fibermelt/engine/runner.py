"""Run a study: reuse what is stored, compute what is not, and put the results on show."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.files import canonical, digest, write_through
from fibermelt.engine.named import named
from fibermelt.engine.netcdf import to_bytes
from fibermelt.engine.outputs import is_published, publish
from fibermelt.engine.parts import Chain
from fibermelt.engine.progress import Observer, Silent
from fibermelt.engine.schema import REPORT, SCHEMA, has_lost_mark
from fibermelt.engine.stages import Neighbour, Parameters, Say, Stage, keys, stage_parameters
from fibermelt.engine.store import Record, Store, stage_name
from fibermelt.engine.toml import resolved_toml
from fibermelt.errors import DamagedError, legible
from fibermelt.software import versions_of

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Value
    from fibermelt.engine.tables import Tables

__all__ = ["DrawFigures", "WriteReport", "run_study", "software_versions", "summarize"]

DrawFigures = Callable[["xr.Dataset", Path], Sequence[Path]]
"""Draws the figures of results into a folder and returns what it wrote."""

WriteReport = Callable[["xr.Dataset", Mapping[str, Any], Mapping[str, bytes]], bytes]
"""Makes the report of results and summary, with the figures that were drawn, by name."""

SOFTWARE = ("fibermelt", "ngsolve", "numpy", "scipy", "xarray", "h5netcdf", "h5py", "matplotlib")
"""Packages whose versions are recorded beside the numbers."""


def run_study(
    study: Study,
    directory: Path,
    chain: Chain,
    *,
    draw: DrawFigures | None = None,
    report: WriteReport | None = None,
    fresh: bool = False,
    observer: Observer | None = None,
) -> dict[str, Any]:
    """Run a study into a folder and return the content of its summary.json.

    Parameters
    ----------
    study : Study
        The study.
    directory : Path
        The results folder; made if need be.
    chain : Chain
        The stages to go through.
    draw : callable, optional
        Draws the figures; without it there are none.
    report : callable, optional
        Makes the report; without it there is none.
    fresh : bool
        Whether to compute every stage again, and replace all that is stored and on show.
    observer : Observer, optional
        Who is told how it goes.

    Returns
    -------
    dict
        The summary, in SI. Its ``"cost"`` holds the wall time [s] that each stage took when it
        was computed, and as ``"total"`` that of the run that wrote the summary: when nothing
        has changed that is an earlier run, and the summary is the very same.

    Raises
    ------
    FibermeltError
        If a stage has no answer, the folder cannot be read or written, or a file on show was
        changed. Stages that were finished before stay, and the next run goes on from them; one
        that is damaged is computed anew.
    """
    run = _Run(study, chain, draw, report, observer or Silent(), time.perf_counter())
    if has_lost_mark(directory):
        run.observer.done("store", "stages/store.json was missing or damaged: written anew")
    store = Store.open(directory, fresh=fresh)
    try:
        return run.into(store, fresh=fresh)
    finally:
        store.discard_if_empty()


def summarize(results: xr.Dataset, config: Tables, chain: Chain) -> dict[str, Any]:
    """Return what summary.json says of results, but for what they cost.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc.
    config : Tables
        The study that they are of.
    chain : Chain
        What it went through.
    """
    summary: dict[str, Any] = {"schema": SCHEMA}
    if notes := config.notes():
        summary["notes"] = notes
    for part in chain.asked(config.study.parts):
        summary |= named(part.summarize)(results)
    return summary


@dataclass(frozen=True)
class _Run:
    """One call of `run_study`: what all of its steps need."""

    study: Study
    chain: Chain
    draw: DrawFigures | None
    report: WriteReport | None
    observer: Observer
    began: float

    def into(self, store: Store, *, fresh: bool) -> dict[str, Any]:
        values = self.study.config.values()
        stages = self.chain.needed(self.study.config.study.parts, values)
        stage_keys = keys(stages, values)
        key = self._key(values, stage_keys)
        found = {} if fresh else self._stored(store, stage_keys)
        if (
            not fresh
            and is_published(store.directory, key, but=self.study.path)
            and all(map(found.get, stage_keys))
        ):
            self.observer.done("study", "nothing has changed: all results are up to date")
            summary: dict[str, Any] = json.loads((store.directory / "summary.json").read_bytes())
            return summary
        data: dict[str, xr.Dataset] = {}
        cost: dict[str, float] = {}
        for number, stage in enumerate(stages, 1):
            record = found.get(stage.name)
            if record is not None:
                data[stage.name] = store.load(record)
                self.observer.done(stage.name, f"reused (took {record.cost:.1f} s when computed)")
            else:
                like = None if fresh else self._like(store, stage, stage_keys)
                record, data[stage.name] = self._compute(stage, stage_keys, data, like)
                # What is damaged is not in what was found: it makes room, as all does afresh.
                record = store.save(record, data[stage.name], replace=stage.name not in found)
                self.observer.done(stage.name, f"done in {record.cost:.1f} s")
            for later in stages[number:]:
                asked = Parameters(stage_parameters(later, values))
                named(later.foresee)(asked, stage.name, data[stage.name])
            cost[stage.heading] = cost.get(stage.heading, 0.0) + record.cost
        return self._publish(store, key, data, cost)

    def _stored(self, store: Store, stage_keys: Mapping[str, str]) -> dict[str, Record | None]:
        """Return the record of each stage, None where there is none; what is damaged is left out.

        A damaged stage costs no more than one that is missing: it is told of, and computed anew.
        """
        found = {}
        for name, key in stage_keys.items():
            try:
                found[name] = store.find(name, key)
            except DamagedError:
                told = f"{stage_name(name, key)} is damaged: it is computed anew"
                self.observer.done("store", told)
        return found

    def _like(self, store: Store, stage: Stage, stage_keys: Mapping[str, str]) -> Neighbour | None:
        """Return a stored result of a stage that differs from the one asked for by a scale only.

        One that itself began with another's is none: it differs within its error.
        """
        if stage.compute_from is None:
            return None
        values = self.study.config.values()
        asked = dict(named(stage.but_for_scale)(stage_parameters(stage, values)))
        inputs = {name: stage_keys[name] for name in stage.fed(values)}
        for record, _ in store.records():
            is_whole = not record.neighbour and dict(record.inputs) == inputs
            if (record.stage, record.version, is_whole) != (stage.name, stage.version, True):
                continue
            if dict(named(stage.but_for_scale)(record.parameters)) == asked:
                with suppress(DamagedError):
                    return Neighbour(Parameters(record.parameters), store.load(record), record.key)
        return None

    def _compute(
        self,
        stage: Stage,
        stage_keys: Mapping[str, str],
        data: Mapping[str, xr.Dataset],
        like: Neighbour | None,
    ) -> tuple[Record, xr.Dataset]:
        values = self.study.config.values()
        parameters, fed = stage_parameters(stage, values), stage.fed(values)
        start, busy = time.perf_counter(), time.process_time()
        self.observer.step(stage.name, "started")
        from threadpoolctl import threadpool_limits  # noqa: PLC0415  lazy: a stored study needs none

        # Stages do much small algebra: threads of a BLAS that wait cost more than they bring.
        with threadpool_limits(limits=1, user_api="blas"):
            inputs = {name: data[name] for name in fed}
            dataset, neighbour = stage.begin(parameters, inputs, self._say(stage), like)
        record = Record(
            stage=stage.name,
            version=stage.version,
            key=stage_keys[stage.name],
            parameters=dict(parameters),
            inputs={name: stage_keys[name] for name in fed},
            cost=time.perf_counter() - start,
            data="",
            software=software_versions(),
            processor=time.process_time() - busy,
            neighbour=neighbour,
        )
        return record, dataset

    def _say(self, stage: Stage) -> Say:
        return lambda line: self.observer.step(stage.name, line)

    def _key(self, values: Mapping[str, Value], stage_keys: Mapping[str, str]) -> str:
        """Return the hash of all that the files on show depend on, but for the study's name.

        Of every parameter: config.toml and the report show also those that no stage reads.
        """
        content = {
            "parameters": dict(values),
            "stages": dict(stage_keys),
            "version": self.chain.version,
            "fibermelt": version("fibermelt"),
            "figures": self.draw is not None,
            "report": self.report is not None,
        }
        return digest(canonical(content))

    def _publish(
        self, store: Store, key: str, data: Mapping[str, xr.Dataset], cost: Mapping[str, float]
    ) -> dict[str, Any]:
        """Write what a person looks at, all of it or nothing, and return the summary."""
        import xarray as xr  # noqa: PLC0415  lazy: a run that finds everything done never needs it

        results = xr.merge(
            data.values(), combine_attrs="identical", compat="identical", join="exact"
        )
        preamble = (
            f"The study {legible(self.study.name)} ({self.study.origin}) as it was run, in SI, "
            "with all defaults: fibermelt run on this file gives these results again, to rounding."
        )
        config = resolved_toml(self.study.config, preamble)
        results.attrs = {
            "title": f"fibermelt study {legible(self.study.name)}",
            "schema": SCHEMA,
            "config": config,
            "software": json.dumps(software_versions()),
        }
        for part in self.chain.parts:
            if part.attributes:
                results.attrs |= named(part.attributes)(self.study.config)
        parts = self.chain.asked(self.study.config.study.parts)
        summary = {**summarize(results, self.study.config, self.chain), "cost": dict(cost)}

        def write(folder: Path) -> None:
            write_through(folder / "config.toml", config.encode())
            write_through(folder / "results.nc", to_bytes(results))
            for part in parts:
                named(part.write_fields)(results, folder)
            start = time.perf_counter()
            (folder / "figures").mkdir()
            if self.draw is not None:
                self.observer.step("figures", "started")
                count = len(self.draw(results, folder / "figures"))
                spent = time.perf_counter() - start
                self.observer.done("figures", f"{count} files in {spent:.1f} s")
            summary["cost"]["figures"] = time.perf_counter() - start
            summary["cost"]["total"] = time.perf_counter() - self.began
            text = json.dumps(summary, indent=1, allow_nan=False)
            write_through(folder / "summary.json", text.encode())
            if self.report is not None:
                self.observer.step("report", "started")
                drawn = {path.name: path.read_bytes() for path in (folder / "figures").iterdir()}
                page = self.report(results, json.loads(text), drawn)
                write_through(folder / REPORT, page)
                self.observer.done("report", f"{len(page) / 1e6:.1f} MB")

        publish(store.directory, key, write)
        return summary


def software_versions() -> dict[str, str]:
    """Return the versions of what computes."""
    return versions_of(SOFTWARE)
