"""`fibermelt export`: what it writes, what it prints, and what it refuses."""

from __future__ import annotations

import json

import pytest

# The made-up results are the unit tests' own; nothing but this file needs them here.
from stored_bead import store
from typer.testing import CliRunner

from fibermelt.cli import app

pytestmark = pytest.mark.end_to_end


def export(*arguments):
    return CliRunner().invoke(app, ["export", *map(str, arguments)])


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return store(tmp_path_factory.mktemp("stored") / "out", drawn=False)


def test_it_writes_a_folder_and_says_where(finished, tmp_path):
    done = export(finished)
    assert (done.exit_code, done.stderr) == (0, "")
    assert "tables and streamlines.vtp" in done.stdout
    assert f"folder          {finished / 'export'}" in done.stdout
    told = json.loads(export(finished, "--to", tmp_path / "mine", "--json").stdout)
    assert told["folder"] == str(tmp_path / "mine")
    assert {path.name for path in (tmp_path / "mine").iterdir()} == {*told["files"], "export.json"}
    assert (tmp_path / "mine/numbers.csv").read_bytes() == (
        finished / "export/numbers.csv"
    ).read_bytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none"], "no such folder; name a folder that `fibermelt run` wrote"),
        (["{out}", "--to", ""], '--to "": is no name of a folder'),
        (["{out}", "--to", "{out}/figures"], "which no fibermelt export wrote"),
        (["{out}", "--to", "{out}/none/export"], "there is no folder"),
    ],
)
def test_a_mistake_is_one_line(finished, arguments, words):
    done = export(*(one.format(out=finished) for one in arguments))
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert words in done.stderr
