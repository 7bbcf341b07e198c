"""The commands of the pages are run, in their order and on their own files, coarsely.

A page's first study is written as `mine.toml`, a card under the name that the page gives it; a
study or card that no command names is run as one would. What costs minutes is made coarse by
further `-s`, and sweeps are thinned, which changes numbers and no word of a command: `validate` and
`plan` see a study as it is shown. What starts processes is one itself; the rest runs in this one,
and a study without its figures and page, which are drawn once, of the paper's.
"""

from __future__ import annotations

import json
import re
import shlex
import textwrap
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

import pytest
import typer
from coarse_runs import COARSE, fibermelt, here

from fibermelt.cli import app

pytestmark = pytest.mark.end_to_end

ROOT = Path(__file__).parents[2]

PAGES = [
    ROOT / page
    for page in (
        "README.md",
        "docs/index.md",
        "docs/tutorial.md",
        "docs/sweeps.md",
        "docs/howto/melts.md",
        "docs/howto/printer.md",
        "docs/howto/voids.md",
    )
]
"""The pages that show what to type. Elsewhere commands are named, and `test_docs` parses them."""

COMPUTES = {"run", "sweep"}
"""Commands that take `-s` and time."""

SWEEPS = {"sweep", "resume"}
"""Commands that start workers."""

ELSEWHERE = {"--scheduler": "needs a cluster"}
"""What cannot be run here, and why."""

REFUSED = {"fibermelt validate paper -s flow.gap=3.5": "must be at most 1 m"}
"""Commands that a page shows for the answer that they are wrong."""

KEPT = 2
"""Values of what varies, and samples, that a thinned sweep keeps: fewer are no sweep."""


def coarse(but: Collection[str] = ()) -> list[str]:
    """Return the coarse study, of few parts, as overrides of what is not given already."""
    tables = tomllib.loads(COARSE.read_text(encoding="utf-8"))
    given = ['study.parts=["bead", "voids"]']
    for table in ("fiber", "streamlines", "numerics"):
        given += [f"{table}.{key}={value!r}" for key, value in tables[table].items()]
    already = {word.partition("=")[0] for word in but}
    return [
        word
        for one in given
        if one.partition("=")[0] not in already
        for word in ("-s", one.replace("'", '"'))
    ]


def thinned(study: str) -> str:
    """Return a study whose sweep has fewer values and samples; its table [sweep] comes last."""
    table = tomllib.loads(study).get("sweep")
    if table is None:
        return study

    def fewer(key: str, value: Any) -> str:
        if isinstance(value, dict):
            kept = value | ({"count": KEPT} if "count" in value else {})
            return "{ " + ", ".join(f"{k} = {json.dumps(v)}" for k, v in kept.items()) + " }"
        if isinstance(value, list):
            value = value[:KEPT]
        return json.dumps(KEPT if key == "samples" else value)

    head = study.partition("[sweep]")[0]
    lines = [f"{json.dumps(key)} = {fewer(key, value)}" for key, value in table.items()]
    return "\n".join([head, "[sweep]", *lines, ""])


def whole(command: str) -> bool:
    """Tell a command from the name of one: it has all that it must be given, no placeholder."""
    if re.search(r"\b(STUDY|DIR|KEY|FILE)\b|\[", command):
        return False
    _, name, *given = shlex.split(command)
    try:
        group: Any = typer.main.get_command(app)
        group.commands[name].make_context(name, list(given))
    except typer.Exit:  # --help
        return True
    except (typer.BadParameter.__base__, KeyError):  # a usage error
        return False
    return True


def page_commands(page: Path) -> list[str]:
    """Return the commands of a page: those in blocks, and those in text that are whole."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^(?: {4}|\$ )(fibermelt .*)$", text, re.M)
    named = re.findall(r"(?<!`)`(fibermelt [^`]*)`(?!`)", re.sub(r"\n(?=\S)", " ", text))
    return list(dict.fromkeys([*blocks, *filter(whole, named)]))


def page_files(page: Path) -> dict[str, str]:
    """Return the page's studies and cards by the names that its commands have for them."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```toml\n(.*?)^```", text, re.M | re.S)
    blocks += map(textwrap.dedent, re.findall(r"^ {4}preset.*\n(?:(?: {4}.*)?\n)*", text, re.M))
    cards = [one for one in blocks if "name" in tomllib.loads(one)]
    studies = [one for one in blocks if one not in cards]
    named = re.findall(r"--material (\S+\.toml)", text)
    files = dict(zip([*named, *(f"card-{k}.toml" for k in range(len(cards)))], cards, strict=False))
    for k, one in enumerate(studies):
        lent = "" if "preset" in tomllib.loads(one) else 'preset = "paper"\n'
        files["mine.toml" if k == 0 else f"study-{k}.toml"] = lent + one
    return files


def implied(files: dict[str, str], commands: list[str]) -> list[str]:
    """Return what one does with the files that no command of their page names."""
    found = []
    for name, text in files.items():
        if any(name in line for line in commands):
            continue
        tables = tomllib.loads(text)
        if "name" in tables:
            # a table of fibers in a melt that thins takes a minute; the mesh must be finer there
            how = (
                "-s 'study.parts=[\"orientation\"]' -s numerics.contact_edge=0.05 "
                "-s numerics.surface_edge=0.1"
            )
            found.append(f"fibermelt run paper -s melt.material={name} {how} --out results/own")
        else:
            verb = "sweep" if "sweep" in tables else "run"
            found += [f"fibermelt validate {name}", f"fibermelt {verb} {name}"]
    return found


@pytest.fixture(scope="module")
def done_before() -> set[tuple[str, ...]]:
    """Commands that another page shows as well, with the study that they were for."""
    return set()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the paper's study is finished, coarse; its stages serve all pages."""
    folder = tmp_path_factory.mktemp("pages")
    done = fibermelt("run", "paper", *coarse(), "--out", "results/paper", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder


def typed(line: str) -> list[str]:
    """Return the words of a command, coarse where it computes and with fewer values to vary."""
    _, name, *given = shlex.split(line, comments=True)
    for at, word in enumerate(given):
        if word == "--over":
            key, _, values = given[at + 1].partition("=")
            given[at + 1] = f"{key}={','.join(values.split(',')[:KEPT])}"
    return [name, *given, *(coarse(given) if name in COMPUTES else [])]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_of_a_page_run(
    page: Path,
    finished: Path,
    done_before: set[tuple[str, ...]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("fibermelt.report.page.draw", lambda results, folder: [])
    monkeypatch.setattr("fibermelt.report.page.render", lambda results, summary, drawn: b"")
    files, commands = page_files(page), page_commands(page)
    for line in [*commands, *implied(files, commands)]:
        if any(word in line for word in ELSEWHERE):
            continue
        words = typed(line)
        ask = (line, *(text for name, text in files.items() if name in line))
        if ask in done_before:
            continue
        done_before.add(ask)
        for name, text in files.items():
            shown = thinned(text) if words[0] in COMPUTES else text
            (finished / name).write_text(shown, encoding="utf-8")
        done = (fibermelt if words[0] in SWEEPS else here)(*words, folder=finished)
        if line in REFUSED:
            assert done.returncode == 2, line
            assert REFUSED[line] in done.stderr
        else:
            assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
            assert "Traceback" not in done.stderr
