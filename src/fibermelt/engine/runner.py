"""Run a study: reuse what is stored, compute what is not, and put the results on show."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from threading import Condition
from typing import TYPE_CHECKING, Any

from fibermelt.engine.execution import execute, software_versions
from fibermelt.engine.files import canonical, digest, write_through
from fibermelt.engine.helper import Helper, HelperLostError, helped, one_helper
from fibermelt.engine.named import named
from fibermelt.engine.netcdf import to_bytes
from fibermelt.engine.outputs import is_published, publish
from fibermelt.engine.parts import Chain
from fibermelt.engine.progress import Observer, Silent
from fibermelt.engine.schema import REPORT, SCHEMA, has_lost_mark
from fibermelt.engine.stages import Inputs, Say, Stage, keys, stage_parameters
from fibermelt.engine.store import Record, Store, stage_name
from fibermelt.engine.toml import resolved_toml
from fibermelt.errors import DamagedError, legible
from fibermelt.threads import cores

if TYPE_CHECKING:
    import xarray as xr

    from fibermelt.engine.loading import Study
    from fibermelt.engine.parameters import Value
    from fibermelt.engine.tables import Tables

WORTH_A_HELPER = 3
"""Stages that wait for nothing, for which a second process is started: it takes as long as most of
them to be there, and there is one to compute here meanwhile."""

EXECUTE = "fibermelt.engine.execution:execute"

__all__ = ["DrawFigures", "WriteReport", "run_study", "summarize"]

DrawFigures = Callable[["xr.Dataset", Path], Sequence[Path]]
"""Draws the figures of results into a folder and returns what it wrote."""

WriteReport = Callable[["xr.Dataset", Mapping[str, Any], Mapping[str, bytes]], bytes]
"""Makes the report of results and summary, with the figures that were drawn, by name."""


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
        with one_helper():
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
        data, records = _Work(self, store, stages, values, stage_keys, found).done()
        cost: dict[str, float] = {}
        for stage in stages:
            cost[stage.heading] = cost.get(stage.heading, 0.0) + records[stage.name].cost
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


@dataclass
class _Work:
    """The stages of a run, each done once what it is fed is: here, by a helper where it pays."""

    run: _Run
    store: Store
    stages: Sequence[Stage]
    values: Mapping[str, Value]
    keys: Mapping[str, str]
    found: Mapping[str, Record | None]

    def __post_init__(self) -> None:
        self.left = list(self.stages)
        self.data: dict[str, xr.Dataset] = {}
        self.records: dict[str, Record] = {}
        self.changed = Condition()
        self.failure: Exception | None = None

    def done(self) -> tuple[dict[str, xr.Dataset], dict[str, Record]]:
        """Do all stages, and return their data and their records in the order of the chain."""
        apart = [stage for stage in self._missing() if not stage.fed(self.values)]
        pays = cores() > 1 and len(apart) >= WORTH_A_HELPER
        with helped(self._give) if pays else nullcontext():
            try:
                self._do()
            finally:
                self._leave()
        names = [stage.name for stage in self.stages]
        return {name: self.data[name] for name in names}, self.records

    def _do(self) -> None:
        """Do stages in the order of the chain until all are done, here or by the helper."""
        while (stage := self._taken()) is not None:
            record = self.found.get(stage.name)
            if record is not None:
                told = f"reused (took {record.cost:.1f} s when computed)"
                self._finish(stage, record, self.store.load(record), told)
            else:
                self.run.observer.step(stage.name, "started")
                self._save(stage, *execute(*self._asked(stage), self._say(stage)))
        if self.failure is not None:
            raise self.failure

    def _give(self, helper: Helper) -> None:
        """Have a helper compute stages from the end of the chain on, as long as there are any."""
        while (stage := self._taken(by_helper=True)) is not None:
            self.run.observer.step(stage.name, "started")
            try:
                answer = helper.call(EXECUTE, *self._asked(stage), say=self._say(stage))
                self._save(stage, *answer)
            except HelperLostError:
                with self.changed:  # done here, which tells why
                    self.left.insert(0, stage)
                    self.changed.notify_all()
                return
            except Exception as failure:  # raised where the run is waited for
                self._leave(failure)
                return

    def _leave(self, failure: Exception | None = None) -> None:
        """Have nobody begin or wait for another stage."""
        with self.changed:
            self.failure, self.left = failure or self.failure, []
            self.changed.notify_all()

    def _missing(self) -> list[Stage]:
        return [stage for stage in self.left if self.found.get(stage.name) is None]

    def _taken(self, *, by_helper: bool = False) -> Stage | None:
        """Return the next stage that is fed, waiting for it.

        None where nothing is left to take, of what is not stored; but here, where what the helper
        does may come back, only where everything is done, or failed.
        """
        with self.changed:
            while self.failure is None and len(self.data) < len(self.stages):
                left = self._missing()[::-1] if by_helper else self.left
                for stage in left:
                    if all(name in self.data for name in stage.fed(self.values)):
                        self.left.remove(stage)
                        return stage
                if by_helper and not left:
                    return None
                self.changed.wait()
        return None

    def _asked(self, stage: Stage) -> tuple[Stage, Mapping[str, Value], Mapping[str, str], Inputs]:
        inputs = {name: self.data[name] for name in stage.fed(self.values)}
        return stage, self.values, self.keys, inputs

    def _say(self, stage: Stage) -> Say:
        return lambda line: self.run.observer.step(stage.name, line)

    def _save(self, stage: Stage, record: Record, stored: xr.Dataset) -> None:
        # What is damaged is not in what was found: it makes room, as all does afresh.
        record = self.store.save(record, stored, replace=stage.name not in self.found)
        self._finish(stage, record, stored, f"done in {record.cost:.1f} s")

    def _finish(self, stage: Stage, record: Record, stored: xr.Dataset, told: str) -> None:
        """Take note of a stage's data, and refuse what cannot come after them."""
        self.run.observer.done(stage.name, told)
        found = stage.multiple(stage_parameters(stage, self.values)).of(stored)
        for one in self.stages[self.stages.index(stage) + 1 :]:
            named(one.foresee)(stage_parameters(one, self.values), stage.name, found)
        with self.changed:
            self.data[stage.name], self.records[stage.name] = found, record
            self.changed.notify_all()
