"""What a sweep comes to before it runs: `fibermelt plan`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fibermelt.cli.common import (
    ColdOption,
    JsonOption,
    OutOption,
    OverOption,
    SetOption,
    StudyArgument,
    columns,
    read_study,
    results_folder,
    say,
    told,
)
from fibermelt.errors import legible

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Declaration

__all__ = ["plan"]

LISTED = 40
"""Cases that a plan lists for a person; --json has all of them."""


def plan(
    study: StudyArgument,
    out: OutOption = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            metavar="N",
            help="How many are to work at once; as many as this machine has cores by default.",
        ),
    ] = None,
    sets: SetOption = None,
    over: OverOption = None,
    cold: ColdOption = False,
    as_json: JsonOption = False,
) -> None:
    """Show the cases of a sweep, and run none.

    Tells what they share, what is done in the results folder, and what the rest will cost.
    """
    with told():
        from fibermelt.study.chain import CHAIN  # noqa: PLC0415  lazy: help needs none of it
        from fibermelt.sweeps.design import read_sweep  # noqa: PLC0415
        from fibermelt.sweeps.pools import cores, refuse_workers  # noqa: PLC0415
        from fibermelt.sweeps.status import list_plan  # noqa: PLC0415

        refuse_workers(workers, None)
        swept = read_study(study, sets, over)
        folder = results_folder(out, swept.name)
        count = cores() if workers is None else max(workers, 1)
        listed = list_plan(read_sweep(swept, cold=cold), swept, CHAIN, folder, count)
        say(json.dumps(listed, indent=1) if as_json else _in_words(listed))


def _in_words(listed: Mapping[str, Any]) -> str:
    from fibermelt.engine.parameters import declarations  # noqa: PLC0415
    from fibermelt.engine.wrapping import hanging, unbroken, wrapped  # noqa: PLC0415
    from fibermelt.study.config import Config  # noqa: PLC0415  lazy, as in plan

    known = {item.key: item for item in declarations(Config)}
    width = columns()
    shape = " x ".join(map(str, listed["shape"]))
    lines = [
        f"cases           {listed['cases']} ({shape}): {listed['done']} done, "
        f"{listed['failed']} failed, {listed['pending']} to do"
    ]
    lines += [f"{'':<16}{key}: {told}" for key, told in listed["sampled"].items()]
    for name, count in listed["stages"].items():
        kept = f", {count['stored']} of {count['kept']} stored" if count["kept"] else ", not stored"
        lines.append(f"{name:<16}{count['results']} for all cases{kept}")
        if "warm" in count:
            cold = count["kept"] - count["warm"]
            lines.append(f"{'':<16}{cold} from cold, {count['warm']} from a neighbour")
    if listed["pending"]:
        lines.append(f"to do           {_cost(listed['estimate'])}")
    lines += [f"note            {note}" for note in listed["notes"]]
    cases = []
    for case in listed["each"][:LISTED]:
        point = ", ".join(
            unbroken(f"{key} = {_number(value, known[key])}")
            for key, value in case["point"].items()
        )
        cases.append(hanging(f"{case['case']:>6}  {case['status']:<8}  ", point, width))
    if (more := len(listed["each"]) - LISTED) > 0:
        cases.append(f"        and {more} more: --json lists them all")
    return "\n".join([wrapped(lines, width), *cases])


def _cost(estimate: Mapping[str, Any]) -> str:
    """Return what the rest of a sweep will cost, as far as what is stored tells."""
    from fibermelt.engine.progress import duration  # noqa: PLC0415  lazy, as in plan

    missing = ", ".join(estimate["unknown"])
    if not estimate["work"]:
        return f"how long it takes is told once the folder has some of its {missing}"
    workers = f"{estimate['workers']} worker{'' if estimate['workers'] == 1 else 's'}"
    words = (
        f"about {duration(estimate['wall'])} on {workers}, {_size(estimate['size'])}, "
        "as what is stored took"
    )
    return f"{words}; not counted, as none is there yet: {missing}" if missing else words


def _size(size: float) -> str:
    """Return a size [bytes] in words."""
    return f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"


def _number(value: object, about: Declaration) -> str:
    """Return a value as a person writes it: in the unit of its default."""
    from fibermelt.sweeps.table import DIGITS, written_in  # noqa: PLC0415  lazy, as in plan

    if isinstance(value, bool) or not isinstance(value, int | float):
        return legible(str(value))
    scale = written_in(about)
    return f"{(value - scale.zero) / scale.size:.{DIGITS}g} {scale.unit}".rstrip()
