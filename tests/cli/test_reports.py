"""`fibermelt report`: what it writes, what it prints, and what it refuses."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

import pytest

# The made-up results are the unit tests' own; nothing but this file needs them here.
from stored_bead import store
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.files import digest, read_sealed, write_sealed
from fibermelt.engine.outputs import is_published
from fibermelt.errors import DamagedError

pytestmark = pytest.mark.end_to_end


def report(*arguments):
    return CliRunner().invoke(app, ["report", *map(str, arguments)])


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    return store(tmp_path_factory.mktemp("stored") / "out")


@pytest.fixture
def folder(finished, tmp_path):
    return Path(shutil.copytree(finished, tmp_path / "out"))


def refused(done, *words):
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr
    return True


def test_it_writes_one_file_and_says_where(folder):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    done = report(folder)
    page = folder / "report.html"
    assert (done.exit_code, done.stdout, done.stderr) == (0, f"{page}\n", "")
    first = page.read_bytes()
    told = json.loads(report(folder, "--json").stdout)
    assert told == {"report": str(page), "bytes": len(first)}
    assert page.read_bytes() == first
    page.unlink()
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_figures_that_are_gone_or_changed_are_drawn_again(folder):
    report(folder)
    first = (folder / "report.html").read_bytes()
    (folder / "figures/overview.svg").write_text("<svg/>")
    (folder / "figures/cell.png").unlink()
    assert report(folder).exit_code == 0
    assert (folder / "report.html").read_bytes() == first


def test_no_results_folder(tmp_path):
    assert refused(report(tmp_path / "none"), "no such folder", "fibermelt run")
    (tmp_path / "file").write_text("")
    assert refused(report(tmp_path / "file"), "is a file, not a results folder", "fibermelt run")
    assert refused(report(tmp_path), "is no results folder of fibermelt", "fibermelt run")


def test_no_finished_run(folder):
    (folder / "stages/outputs.json").unlink()
    assert refused(report(folder), "holds no finished run", "fibermelt run STUDY --out")


@pytest.mark.parametrize("name", ["results.nc", "summary.json", "stages/outputs.json"])
def test_changed_results(folder, name):
    path = folder / name
    path.write_bytes(path.read_bytes()[:-40] + b"x" * 40)
    assert refused(report(folder), name, "is damaged", "--fresh")


@pytest.mark.parametrize("name", ["results.nc", "summary.json"])
def test_missing_results(folder, name):
    (folder / name).unlink()
    assert refused(report(folder), name, "is missing", "run the study again")


def test_another_schema(folder):
    (folder / "stages/store.json").write_text('{"schema": 99}')
    assert refused(report(folder), "schema 99", "reads 1")
    (folder / "stages/store.json").write_text("{")
    assert refused(report(folder), "store.json", "is damaged", "move it away and run the study")
    (folder / "stages/store.json").unlink()
    assert refused(report(folder), "store.json: is missing", "fibermelt run STUDY --out")


def test_a_report_that_cannot_be_written_leaves_the_old_one(folder, monkeypatch):
    report(folder)
    first = (folder / "report.html").read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    assert refused(report(folder), "report.html: cannot be written: no space left", "report on a")
    assert (folder / "report.html").read_bytes() == first
    assert not [*folder.glob(".partial*")]


def test_a_new_page_is_not_taken_for_a_changed_one(folder):
    """Another version writes another page; a run into the folder must still know it as its own."""
    manifest = folder / "stages/outputs.json"
    listed = read_sealed(manifest)
    older = {**listed["files"], "report.html": digest(b"the page of an older version")}
    write_sealed(manifest, {**listed, "files": older})
    (folder / "report.html").write_bytes(b"the page of an older version")
    assert report(folder).exit_code == 0
    page = (folder / "report.html").read_bytes()
    assert read_sealed(manifest)["files"] == {**older, "report.html": digest(page)}
    assert is_published(folder, listed["run"])
    (folder / "report.html").write_bytes(b"changed by hand")
    with pytest.raises(DamagedError, match=r"report\.html: is damaged, or was changed"):
        is_published(folder, listed["run"])
