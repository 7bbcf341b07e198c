"""The commands of the pages are run, in their order and on their own files, coarsely.

A page's study is written as `mine.toml`, its card under the name that the page gives it. What
costs minutes is made coarse by further `-s`, which change numbers and no word of a command.
"""

from __future__ import annotations

import re
import shlex
import textwrap
import tomllib
from pathlib import Path

import pytest
from coarse_runs import COARSE, fibermelt

ROOT = Path(__file__).parents[2]


COMPUTES = {"run", "sweep", "plan"}
"""Commands that take `-s` and time."""

ELSEWHERE = {"--scheduler": "needs a cluster", "docs/reference": "usage, with placeholders"}
"""What cannot be run here, and why."""

REFUSED = {"fibermelt validate paper -s flow.gap=3.5": "must be at most 1 m"}
"""Commands that a page shows for the answer that they are wrong."""


def coarse() -> list[str]:
    """Return the coarse study as overrides."""
    tables = tomllib.loads(COARSE.read_text(encoding="utf-8"))
    given = ['study.parts=["bead", "voids"]']
    for table in ("fiber", "streamlines", "numerics"):
        given += [f"{table}.{key}={value!r}" for key, value in tables[table].items()]
    return [word for one in given for word in ("-s", one.replace("'", '"'))]


def page_commands(page: Path) -> list[str]:
    """Return the whole commands of a page, and those of README's table without placeholders."""
    text = page.read_text(encoding="utf-8")
    whole = re.findall(r"^(?: {4}|\$ )(fibermelt .*)$", text, re.M)
    table = re.findall(r"^\| `(fibermelt [^`]*)` \|", text, re.M)
    return [*whole, *(one for one in table if not re.search(r"\b[A-Z]{3,}\b", one))]


def page_files(page: Path, folder: Path) -> None:
    """Write the page's first study, and its card, where its commands look for them."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```toml\n(.*?)^```", text, re.M | re.S)
    blocks += map(textwrap.dedent, re.findall(r"^ {4}preset.*\n(?:(?: {4}.*)?\n)*", text, re.M))
    cards = [one for one in blocks if "name" in tomllib.loads(one)]
    studies = [one for one in blocks if one not in cards]
    for name in re.findall(r"--material (\S+\.toml)", text):
        (folder / name).write_text(cards[0], encoding="utf-8")
    if studies:
        lent = "" if "preset" in tomllib.loads(studies[0]) else 'preset = "paper"\n'
        (folder / "mine.toml").write_text(lent + studies[0], encoding="utf-8")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the paper's study is finished, coarse."""
    folder = tmp_path_factory.mktemp("pages")
    done = fibermelt("run", "paper", *coarse(), "--out", "results/paper", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder


WITH_COMMANDS = [ROOT / "docs" / "howto" / "voids.md", ROOT / "docs" / "index.md"]
"""Pages whose commands take seconds; those that sweep are held to be commands by `test_docs`."""


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_COMMANDS, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_of_a_page_run(page: Path, finished: Path) -> None:
    page_files(page, finished)
    for line in dict.fromkeys(page_commands(page)):
        if any(word in line or word in str(page) for word in ELSEWHERE):
            continue
        _, name, *given = shlex.split(line, comments=True)
        words = [*given, *coarse()] if name in COMPUTES else given
        done = fibermelt(name, *words, folder=finished)
        if line in REFUSED:
            assert done.returncode == 2, line
            assert REFUSED[line] in done.stderr
        else:
            assert done.returncode == 0, f"{line}\n{done.stdout}\n{done.stderr}"
            assert "Traceback" not in done.stderr
