"""A whole study from Python: run it, vary it, open its results, see them.

What the command line does, without a terminal: the same studies, the same folders, the same errors.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import xarray as xr

from fibermelt.engine.finished import Finished, read_finished
from fibermelt.engine.loading import Study
from fibermelt.engine.named import named
from fibermelt.engine.outputs import has_run
from fibermelt.engine.progress import Observer, observing
from fibermelt.engine.results import study_of
from fibermelt.engine.runner import run_study as run_into
from fibermelt.engine.runner import summarize
from fibermelt.engine.schema import REPORT
from fibermelt.errors import ConfigError, legible
from fibermelt.report.page import draw, render
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study, resolve
from fibermelt.sweeps.collect import collect_sweep
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.runner import run_sweep
from fibermelt.sweeps.store import CaseStore

__all__ = ["StudyAccessor", "open_results", "run_study", "sweep"]

COST = "cost"
"""The attribute of a dataset that holds what each stage took, as JSON."""


def run_study(
    study: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    *,
    page: bool | None = None,
    fresh: bool = False,
    progress: bool = False,
) -> xr.Dataset:
    """Run a study and return its results.

    Parameters
    ----------
    study : str, Path or mapping
        The path of a TOML file, the name of a shipped study (``"paper"``), or what such a file
        says: ``{"preset": "paper", "flow.gap": "3.5 mm"}``.
    overrides : mapping, optional
        Parameters that win over it: ``{"flow.gap": "3.5 mm"}``, or tables as in a file. A quantity
        is a text with a unit, or a number in SI.
    out : str or Path, optional
        The results folder: stages that are stored there already are not computed again, as with
        ``fibermelt run``. Without one nothing is kept on the disk.
    page : bool, optional
        Whether to draw the figures and write the page into ``out``: by default where it has one.
    fresh : bool
        Whether to compute everything again.
    progress : bool
        Whether to tell on standard error how it goes.

    Returns
    -------
    xarray.Dataset
        The content of results.nc, in SI. ``results.fibermelt.summary`` is that of summary.json.

    Raises
    ------
    ConfigError
        If the study cannot be as it is: a line for each fault.
    FibermeltError
        If it has no answer, or the folder cannot be read or written.
    """
    read = _read(study, overrides)
    if read.sweep is not None:
        msg = f"{read.name}: has a table [sweep], and so is many studies: use fibermelt.sweep"
        raise ConfigError(msg)
    if page and out is None:
        msg = "page = True: needs out, the folder that the page is written into"
        raise ConfigError(msg)
    with _folder(out) as folder, _observer(progress) as observer:
        drawn = (folder / REPORT).is_file() if page is None else page
        run_into(
            read,
            folder,
            CHAIN,
            draw=draw if drawn else None,
            report=render if drawn else None,
            fresh=fresh,
            observer=observer,
        )
        return _dataset(read_finished(folder))


def sweep(
    study: str | Path | Mapping[str, Any],
    over: Mapping[str, Any] | None = None,
    overrides: Mapping[str, Any] | None = None,
    out: str | Path | None = None,
    *,
    workers: int = 0,
    scheduler: str | None = None,
    retry_failed: bool = False,
    progress: bool = False,
) -> xr.Dataset:
    """Run a study many times and return the numbers of all cases.

    Parameters
    ----------
    study, overrides, progress
        As in `run_study`; the study may have a table ``[sweep]`` of its own.
    over : mapping, optional
        What varies, as the table ``[sweep]`` has it: ``{"flow.gap": ["3 mm", "4 mm"]}``, a range
        ``{"from": "3 mm", "to": "4 mm", "count": 5}``, or a distribution, with ``"design"`` and
        ``"samples"`` beside it.
    out : str or Path, optional
        The results folder; finished cases in it are not computed again. Without one nothing is
        kept on the disk.
    workers : int
        Processes on this machine; 0 for this one only. A script that asks for more has its calls
        under ``if __name__ == "__main__":``, as each process reads it.
    scheduler : str, optional
        Address or file of a dask scheduler whose workers are used instead.
    retry_failed : bool
        Whether cases without an answer are tried again.

    Returns
    -------
    xarray.Dataset
        As of ``fibermelt collect``: over what varies, NaN where a case has no answer; ``status``
        and ``reason`` tell why. A warning tells that there are such cases.

    Raises
    ------
    ConfigError
        If a case is no valid study.
    FibermeltError
        If the folder cannot be read or written, or the scheduler is gone.
    """
    read = _read(study, overrides, over)
    swept = read_sweep(read)
    with _folder(out) as folder, _observer(progress) as observer:
        found = run_sweep(
            swept,
            read,
            folder,
            CHAIN,
            workers=None if scheduler else workers,
            scheduler=scheduler,
            retry_failed=retry_failed,
            observer=observer,
        )
        results = collect_sweep(folder)
    if found["done"] < found["cases"]:
        told = f"{found['failed']} of {found['cases']} cases have no answer: see status and reason"
        warnings.warn(told, stacklevel=2)
    return results


def open_results(directory: str | Path) -> xr.Dataset:
    """Return what a results folder holds: a run's results, or the numbers of a sweep's cases.

    Parameters
    ----------
    directory : str or Path
        A folder of `run_study` or `sweep`, or of the commands of these names; of one that holds
        both, the run's.

    Returns
    -------
    xarray.Dataset
        As `run_study` and `sweep` return it.

    Raises
    ------
    StoreError
        If it holds neither, or what it holds was changed since it was written.
    """
    folder = Path(directory)
    if not has_run(folder) and CaseStore(folder).is_begun():
        return collect_sweep(folder)
    return _dataset(read_finished(folder))


@xr.register_dataset_accessor("fibermelt")  # type: ignore[no-untyped-call]  # by xarray
class StudyAccessor:
    """What results tell of their study: ``results.fibermelt``.

    Parameters
    ----------
    results : xarray.Dataset
        Results of `run_study`, `sweep` or `open_results`, or the content of a results.nc.
    """

    def __init__(self, results: xr.Dataset) -> None:
        self._results = results

    @property
    def summary(self) -> dict[str, Any]:
        """Return the content of summary.json, in SI.

        Raises
        ------
        ConfigError
            If the results are not those of a run, whole: a sweep has none.
        """
        if not self._is_run:
            msg = "results.fibermelt.summary: is of a run; these are no results of run_study"
            raise ConfigError(msg)
        try:
            found = summarize(self._results, resolve(self.study), CHAIN)
        except (KeyError, ValueError) as error:
            msg = f"results.fibermelt.summary: is of whole results, and these lack some: {error}"
            raise ConfigError(msg) from error
        found["cost"] = json.loads(self._results.attrs.get(COST, "{}"))
        told: dict[str, Any] = json.loads(json.dumps(found))
        return told

    @property
    def study(self) -> dict[str, Any]:
        """Return the study as it was run: its tables, every parameter, in SI."""
        return study_of(self._results)

    @property
    def _is_run(self) -> bool:
        return "config" in self._results.attrs and "sweep" not in self._results.attrs

    def __repr__(self) -> str:
        """Return what the results tell, in a few lines."""
        title = str(self._results.attrs.get("title", "no results of fibermelt"))
        if not self._is_run:
            sizes = {str(name): size for name, size in self._results.sizes.items()}
            varied = [name for name in sizes if "." in name or name == "case"]
            over = " x ".join(f"{name} ({sizes[name]})" for name in varied)
            return f"{title}: over {over}" if over else title
        parts, summary = CHAIN.asked(self.study["study"]["parts"]), self.summary
        return "\n".join([title, *(line for part in parts for line in named(part.words)(summary))])

    def _repr_html_(self) -> str:
        """Return the same for a notebook: the answer that the page begins with."""
        if not self._is_run:
            return f"<p>{escape(repr(self))}</p>"
        from fibermelt.report.page.answer import answer  # noqa: PLC0415  lazy: matplotlib

        return str(answer(self._results, self.summary))


def _read(
    study: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | str | Path | None,
    over: Mapping[str, Any] | None = None,
) -> Study:
    """Return a study; warn of what of it is allowed, and hardly meant."""
    if isinstance(overrides, (str, Path)):
        msg = (
            f'overrides = "{legible(str(overrides))}": must be a mapping, such as '
            '{"flow.gap": "3.5 mm"}; a results folder is named by out='
        )
        raise ConfigError(msg)
    given = study if isinstance(study, Mapping) else str(study)
    read = load_study(given, overrides or {}, over or {})
    for line in CHAIN.unread(read):
        warnings.warn(line, stacklevel=3)
    return read


@contextmanager
def _folder(out: str | Path | None) -> Iterator[Path]:
    """Yield the results folder, or one that is gone when all is read from it."""
    if out is None:
        with TemporaryDirectory(prefix="fibermelt-") as name:
            yield Path(name) / "results"
        return
    if not str(out).strip():
        msg = f'out = "{legible(str(out))}": is no name of a folder; write one, or leave it away'
        raise ConfigError(msg)
    yield Path(out)


@contextmanager
def _observer(progress: bool) -> Iterator[Observer | None]:
    if not progress:
        yield None
        return
    with observing() as observer:
        yield observer


def _dataset(finished: Finished) -> xr.Dataset:
    """Return results with what they cost among the attributes."""
    return finished.results.assign_attrs({COST: json.dumps(finished.summary["cost"])})
