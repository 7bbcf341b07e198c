"""Commands for sweeps: `fibermelt sweep`, `status`, `resume`, `clean` and `collect`."""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fibermelt.cli.common import (
    INCOMPLETE,
    INTERRUPTED,
    ColdOption,
    JsonOption,
    OutOption,
    OverOption,
    SetOption,
    StudyArgument,
    WorkersOption,
    columns,
    complain,
    given_folder,
    read_study,
    results_folder,
    say,
    told,
)
from fibermelt.cli.signals import Ended, ended_in_order
from fibermelt.engine.progress import Silent
from fibermelt.errors import ConfigError, legible

if TYPE_CHECKING:
    from fibermelt.engine.loading import Study
    from fibermelt.engine.progress import Observer
    from fibermelt.sweeps.design import Sweep

__all__ = ["clean", "collect", "resume", "status", "sweep"]

Folder = Annotated[str, typer.Argument(metavar="DIR", help="Results folder of a sweep.")]
AnyFolder = Annotated[
    str, typer.Argument(metavar="DIR", help="Results folder of runs, of a sweep, or of both.")
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDR",
        help="Use the workers of a dask scheduler: tcp://host:port, or its scheduler file.",
    ),
]
RetryOption = Annotated[
    bool, typer.Option("--retry-failed", help="Try cases again that had no answer.")
]

NETCDF = "sweep.nc"
"""What the collected numbers are called in a results folder."""


class _Notes(Silent):
    """Prints nothing; keeps what was mended in the folder, which must not go unsaid."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def done(self, stage: str, line: str) -> None:
        """Keep what concerns the folder."""
        if stage == "store":
            self.lines.append(line)


@contextmanager
def _watching(*, as_json: bool) -> Iterator[Observer]:
    """Yield the observer of a sweep: a silent one where JSON is asked for."""
    from fibermelt.engine.progress import observing  # noqa: PLC0415  lazy: help needs none of it

    if not as_json:
        with observing() as observer:
            yield observer
        return
    notes = _Notes()
    try:
        yield notes
    finally:
        for line in notes.lines:
            complain(f"note: {line}")


def sweep(
    study: StudyArgument,
    out: OutOption = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    sets: SetOption = None,
    over: OverOption = None,
    retry_failed: RetryOption = False,
    cold: ColdOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run every case of a study with a [sweep].

    What is stored already is reused, and a sweep that was stopped goes on. The exit code is 0 if
    every case is done, 1 if some or all have no answer, 2 if the study or the folder is of no use.
    """

    def read() -> tuple[Sweep, Study, Path]:
        from fibermelt.sweeps.design import read_sweep  # noqa: PLC0415  lazy, as in _watching

        swept = read_study(study, sets, over)
        return read_sweep(swept, cold=cold), swept, results_folder(out, swept.name)

    _go(read, workers, scheduler, retry_failed, as_json)


def resume(
    directory: Folder,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    retry_failed: RetryOption = False,
    as_json: JsonOption = False,
) -> None:
    """Go on with the sweep of a results folder.

    What is finished is not computed again; the study's file is not needed. Exit codes are those of
    fibermelt sweep.
    """

    def read() -> tuple[Sweep, Study, Path]:
        from fibermelt.sweeps.record import restored  # noqa: PLC0415  lazy, as above
        from fibermelt.sweeps.store import CaseStore  # noqa: PLC0415

        folder = given_folder(directory)
        return *restored(CaseStore(folder)), folder

    _go(read, workers, scheduler, retry_failed, as_json)


def _go(
    read: Callable[[], tuple[Sweep, Study, Path]],
    workers: int | None,
    scheduler: str | None,
    retry_failed: bool,
    as_json: bool,
) -> None:
    with told():
        from fibermelt.study.chain import CHAIN  # noqa: PLC0415  lazy, as in _watching
        from fibermelt.sweeps.runner import run_sweep  # noqa: PLC0415

        swept, study, folder = read()
        try:
            with ended_in_order(), _watching(as_json=as_json) as observer:
                summary = run_sweep(
                    swept,
                    study,
                    folder,
                    CHAIN,
                    workers=workers,
                    scheduler=scheduler,
                    retry_failed=retry_failed,
                    observer=observer,
                )
        except KeyboardInterrupt as ended:
            kept = f"finished cases are kept, fibermelt resume {_quoted(folder)} goes on"
            is_begun = (folder / "sweep.json").exists()
            complain(f"interrupted: {kept if is_begun else 'nothing was begun'}")
            raise typer.Exit(ended.code if isinstance(ended, Ended) else INTERRUPTED) from None
        # Told before the report is made: a report that cannot be written costs no numbers.
        say(json.dumps(summary, indent=1) if as_json else _in_words(summary, folder))
        from fibermelt.report.sweep.page import write_sweep_report  # noqa: PLC0415

        path, answer = write_sweep_report(folder)
        if not as_json:
            say(f"report          {_shown(path)}")
            _tell(answer)
        _end_by(summary)


def _end_by(found: Mapping[str, Any]) -> None:
    """End a command on a sweep of which not every case is done with an exit code that says so."""
    if found["done"] < found["cases"]:
        raise typer.Exit(INCOMPLETE)


def _tell(lines: Iterable[str]) -> None:
    """Print lines for a person that hold no path, none longer than the terminal is wide."""
    from fibermelt.engine.wrapping import wrapped  # noqa: PLC0415  lazy, as in _watching

    say(wrapped(lines, columns()))


def _in_words(summary: dict[str, Any], folder: Path) -> str:
    lines = [
        f"cases           {summary['done']} of {summary['cases']} done, {summary['failed']} failed",
        f"stages reused   {summary['reused_stages']}",
        f"time            {summary['wall_s']:.1f} s",
        f"results         {_shown(folder)}: fibermelt collect {_quoted(folder)}",
    ]
    if summary["failed"]:
        lines.append(f"                fibermelt status {_quoted(folder)} tells why some failed")
    return "\n".join(lines)


def status(directory: Folder, as_json: JsonOption = False) -> None:
    """Tell how far a sweep is, and why cases failed.

    The exit code is 0 if every case is done, 1 if some have no answer or are to do.
    """
    with told():
        from fibermelt.sweeps.status import sweep_status  # noqa: PLC0415  lazy, as above

        folder = given_folder(directory)
        found = sweep_status(folder)
        if as_json:
            say(json.dumps(found, indent=1))
            _end_by(found)
            return
        lines = [
            f"cases           {found['done']} of {found['cases']} done, {found['failed']} failed, "
            f"{found['pending']} to do",
            f"last run        {found['wall_s']:.1f} s, {found['reused_stages']} stages reused",
        ]
        lines += [
            f"{name:<16}{cost['stored']} of {cost['needed']} stored{_started(cost)}"
            for name, cost in found["stages"].items()
        ]
        lines += [f"{count:>6} failed: {reason}" for reason, count in found["reasons"].items()]
        _tell(lines)
        for path in found["damaged"]:
            say(f"damaged: {path}")
        if found["pending"] or found["damaged"]:
            say(f"go on with fibermelt resume {_quoted(folder)}")
        _end_by(found)


def _started(cost: Mapping[str, Any]) -> str:
    """Return how many results of a stage started from a neighbour, if any did."""
    count = cost["from_neighbour"]
    return f", {count} from a neighbour" if count else ""


def clean(
    directory: AnyFolder,
    yes: Annotated[bool, typer.Option("--yes", help="Remove it, rather than tell only.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Tell what a results folder no longer needs.

    That is what no run on show in it and no case of its sweep needs. With --yes, remove it.
    """
    with told():
        from fibermelt.study.chain import CHAIN  # noqa: PLC0415  lazy, as in _watching
        from fibermelt.sweeps.status import list_unneeded, remove_unneeded  # noqa: PLC0415

        folder = given_folder(directory)
        unneeded = list_unneeded(folder, CHAIN)
        size = sum(
            file.stat().st_size
            for path in unneeded
            for file in (path.rglob("*") if path.is_dir() else [path])
            if file.is_file()
        )
        names = [path.relative_to(folder).as_posix() for path in unneeded]
        if yes:
            remove_unneeded(unneeded)
        if as_json:
            say(json.dumps({"unneeded": names, "bytes": size, "removed": yes}, indent=1))
            return
        if not names:
            say("nothing to remove: a case or the run on show needs all that is there")
            return
        told_of = "removed" if yes else "not needed by any case or run on show"
        lines = [*names, f"{len(names)} {told_of}, {size / 1e6:.1f} MB"]
        if not yes:
            lines.append(f"fibermelt clean {_quoted(folder)} --yes removes them")
        say("\n".join(lines))


def collect(
    directory: Folder,
    to: Annotated[
        str | None,
        typer.Option(
            "--to", metavar="FILE", help="Where to: .nc or .csv; DIR/sweep.nc by default."
        ),
    ] = None,
    zarr: Annotated[
        bool, typer.Option("--zarr", help="Write Zarr, into DIR/sweep.zarr by default.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Collect the numbers of a sweep in one file.

    All numbers of all cases, as one dataset over what varies. The exit code is 0 if every case is
    done, 1 if the file was written but has cases without numbers.
    """
    with told():
        if to is not None and not to.strip():
            msg = '--to "": is no name of a file; write one, or leave --to away'
            raise ConfigError(msg)
        from fibermelt.sweeps.collect import (  # noqa: PLC0415  lazy, as in _watching
            SUFFIXES,
            collect_sweep,
            write_csv,
            write_netcdf,
            write_zarr,
        )

        folder = given_folder(directory)
        path = Path(to) if to else folder / ("sweep.zarr" if zarr else NETCDF)
        if path.is_dir() and not zarr:
            msg = f"--to {_shown(path)}: is a folder; name a file, such as {_quoted(path / NETCDF)}"
            raise ConfigError(msg)
        suffix = path.suffix.lower()
        if not zarr and suffix not in SUFFIXES:
            msg = (
                f"--to {_shown(path)}: must end in one of {', '.join(SUFFIXES)}; a Zarr folder "
                "takes --zarr"
            )
            raise ConfigError(msg)
        write = write_zarr if zarr else write_csv if suffix == ".csv" else write_netcdf
        dataset = collect_sweep(folder)
        write(dataset, path)
        statuses = dataset["status"].to_numpy().ravel().tolist()
        summary = {
            "cases": len(statuses),
            **{name: statuses.count(name) for name in ("done", "failed", "pending")},
            "file": str(path),
        }
        if as_json:
            say(json.dumps(summary, indent=1))
            _end_by(summary)
            return
        over = ", ".join(map(str, dataset.sizes))
        _tell(
            [
                f"cases           {summary['done']} of {summary['cases']} done, "
                f"{summary['failed']} failed, {summary['pending']} to do",
                f"variables       {len(dataset.data_vars)} over {over}",
            ]
        )
        say(f"file            {_shown(path)}")
        _end_by(summary)


def _quoted(path: Path) -> str:
    """Return a path as a shell takes it, in a command to copy."""
    return shlex.quote(_shown(path))


def _shown(path: Path) -> str:
    return legible(str(path), len(str(path)))
