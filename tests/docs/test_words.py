"""What the tutorial and the how-to quote is what a person sees, number by number."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fibermelt.engine.parts import in_words
from fibermelt.engine.runner import run_study
from fibermelt.errors import ConfigError
from fibermelt.levers.publish import with_levers
from fibermelt.parts.voids.summary import voids_in_words
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study

pytestmark = [pytest.mark.end_to_end, pytest.mark.slow]

DOCS = Path(__file__).parents[2] / "docs"
QUOTED = re.compile(r"^```text\n(.*?)^```$", re.M | re.S)
ROWS = {
    "inlet pressure": "inlet pressure {} ",
    "contact point": "contact point {} from",
    "lowest before the capillary, below the melt's own": "lowest before the capillary {} below",
    "lowest in the swell": "lowest in the swell {} below",
}


def plain(text: str) -> str:
    return " ".join(text.split()) + " "


def quoted(page: str) -> list[str]:
    """Return the lines of a page's quotations, each with those that go on from it."""
    blocks = QUOTED.findall((DOCS / page).read_text(encoding="utf-8"))
    return [plain(line) for block in blocks for line in re.split(r"\n(?=\S)", block)]


def told(gap: str, folder: Path) -> str:
    """Return what `fibermelt run paper` says of the parts that are quoted."""
    parts = 'study.parts = ["bead", "voids"]'
    study = load_study("paper", [parts, f"flow.gap={gap}"])
    return plain(in_words(run_study(study, folder, CHAIN), CHAIN, study, folder))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("paper")


@pytest.fixture(scope="module")
def paper(folder: Path) -> str:
    return told("3 mm", folder)


def test_the_tutorial_quotes_the_run(paper: str) -> None:
    with pytest.raises(ConfigError) as refused:
        load_study("paper", ["flow.gap=3.5"])
    said = [
        f"error: {refused.value} ",
        "results results/paper ",
        "report results/paper/report.html ",
    ]
    lines = quoted("tutorial.md")
    assert len(lines) == 13
    for line in lines:
        assert line in said or line in paper


def test_the_tutorial_compares_both_gaps(
    paper: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    wider = told("3.5 mm", tmp_path_factory.mktemp("wider"))
    page = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    for row, words in ROWS.items():
        (values,) = re.findall(rf"^\| {row} \| (.*?) \| (.*?) \|$", page, re.M)
        for value, run in zip(values, (paper, wider), strict=True):
            assert words.format(value) in run


def test_the_how_to_quotes_the_answer(paper: str, folder: Path) -> None:
    """Of the same flow, dried; its levers are flows of their own."""
    dried = load_study("paper", ['study.parts = ["bead", "voids"]', "voids.moisture=0.009 %"])
    run_study(dried, folder, CHAIN)
    answer = plain("\n".join(voids_in_words({"voids": with_levers(folder)})))
    lines = quoted("howto/voids.md")
    assert len(lines) == 5
    for line in lines:
        assert line in answer
