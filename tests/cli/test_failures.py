"""Folders that cannot be used: each a clear error, and nothing half-written."""

import errno
import json
import os
import resource
import subprocess
import sys
from pathlib import Path

import fakes
import pytest

from fibermelt.engine import files
from fibermelt.errors import ConvergenceError, DamagedError, StoreError

pytestmark = pytest.mark.end_to_end


def tree(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


def flip_byte(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)


def cut_short(path):
    path.write_bytes(path.read_bytes()[:-1])


@pytest.mark.parametrize(
    "name",
    ["stages/outputs.json", "results.nc", "summary.json", "flow.vtu", "config.toml", "figures/b*"],
)
def test_a_flipped_byte_on_show_is_named_and_two_ways_mend_it(tmp_path, name):
    fakes.run(tmp_path / "out")
    (victim,) = (tmp_path / "out").glob(name)
    flip_byte(victim)
    with pytest.raises(DamagedError, match=r"is damaged.*move it away.*--fresh") as raised:
        fakes.run(tmp_path / "out")
    assert str(victim) in str(raised.value)
    victim.unlink()
    assert fakes.run(tmp_path / "out").reused() == ["flow", "cell", "motion"]
    flip_byte(victim)
    assert fakes.run(tmp_path / "out", fresh=True).reused() == []
    assert len(fakes.run(tmp_path / "out").lines) == 1


@pytest.mark.parametrize("file", ["data.nc", "record.json"])
@pytest.mark.parametrize("how", [flip_byte, cut_short, Path.unlink])
@pytest.mark.parametrize("stage", ["flow", "cell", "motion"])
def test_a_damaged_stage_is_said_so_and_it_alone_is_computed_anew(tmp_path, stage, file, how):
    fakes.run(tmp_path / "out")
    (victim,) = (tmp_path / "out").glob(f"stages/{stage}-*/{file}")
    whole = victim.read_bytes()
    how(victim)
    notes = fakes.run(tmp_path / "out")
    assert f"store: {victim.parent.name} is damaged: it is computed anew" in notes.lines
    assert notes.reused() == [name for name in ("flow", "cell", "motion") if name != stage]
    assert len(fakes.run(tmp_path / "out").lines) == 1
    if file == "data.nc":
        assert victim.read_bytes() == whole


def test_a_stage_that_cannot_be_read_is_not_taken_for_a_damaged_one(tmp_path, monkeypatch):
    fakes.run(tmp_path / "out")
    read = Path.read_bytes

    def refusing(path):
        if path.name == "record.json":
            raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return read(path)

    monkeypatch.setattr(Path, "read_bytes", refusing)
    with pytest.raises(StoreError, match=r"record\.json: cannot be .*permission denied"):
        fakes.run(tmp_path / "out")


@pytest.mark.parametrize("text", ['{"sch', None])
def test_a_lost_marker_is_written_anew_where_anything_is_whole(tmp_path, text):
    fakes.run(tmp_path / "out")
    marker = tmp_path / "out/stages/store.json"
    whole = marker.read_bytes()
    marker.unlink() if text is None else marker.write_text(text)
    notes = fakes.run(tmp_path / "out").lines
    assert notes == [
        "store: stages/store.json was missing or damaged: written anew",
        "study: nothing has changed: all results are up to date",
    ]
    assert marker.read_bytes() == whole


def test_a_damaged_marker_is_named_and_fresh_mends_it(tmp_path):
    fakes.run(tmp_path / "out")
    for path in (tmp_path / "out/stages").glob("**/*.json"):
        path.write_text('{"sch')
    with pytest.raises(StoreError, match=r"store\.json: is damaged.*--fresh"):
        fakes.run(tmp_path / "out")
    fakes.run(tmp_path / "out", fresh=True)
    assert len(fakes.run(tmp_path / "out").lines) == 1


def test_every_flipped_byte_of_a_record_is_noticed(tmp_path):
    """Also the last of 17 digits, which need not change the number, and blanks."""
    victim = tmp_path / "record.json"
    files.write_sealed(victim, {"cost": 0.30000000000000004, "stage": "cell", "inputs": {}})
    whole = victim.read_bytes()
    assert json.loads(whole.replace(b"004,", b"005,")) == json.loads(whole)
    for at in range(len(whole)):
        victim.write_bytes(whole[:at] + bytes([whole[at] ^ 0x01]) + whole[at + 1 :])
        with pytest.raises(ValueError, match="is not what was written"):
            files.read_sealed(victim)


@pytest.mark.parametrize("name", ["summary.json", "stages/store.json"])
def test_a_folder_of_another_schema_is_left_alone(tmp_path, name):
    fakes.run(tmp_path / "out")
    path = tmp_path / "out" / name
    path.write_text(json.dumps({**json.loads(path.read_text()), "schema": 99}))
    before = tree(tmp_path)
    with pytest.raises(StoreError, match=r"schema 99.*writes 1.*--out"):
        fakes.run(tmp_path / "out", fresh=True)
    assert tree(tmp_path) == before


def test_files_of_somebody_else_are_not_overwritten(tmp_path):
    (tmp_path / "config.toml").write_text("mine")
    with pytest.raises(StoreError, match=r"config\.toml.*not overwritten.*--out"):
        fakes.run(tmp_path)
    assert tree(tmp_path) == ["config.toml"]


def test_a_folder_below_a_file_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StoreError, match=r"file/deep/out.*--out"):
        fakes.run(tmp_path / "file/deep/out")
    assert tree(tmp_path) == ["file"]


def refuse_to_write(monkeypatch, code, after=0):
    """Let the operating system refuse every write after some that it allowed."""
    allowed = [after]
    write = files.write_through

    def refusing(path, data):
        if allowed[0] == 0:
            path.write_bytes(data[: len(data) // 2])
            raise OSError(code, os.strerror(code), str(path))
        allowed[0] -= 1
        write(path, data)

    for module in ("files", "store", "runner"):
        monkeypatch.setattr(f"fibermelt.engine.{module}.write_through", refusing)


@pytest.mark.parametrize("code", [errno.EROFS, errno.EACCES])
def test_a_read_only_folder_is_met_before_anything_is_computed(tmp_path, monkeypatch, code):
    (tmp_path / "out").mkdir()
    refuse_to_write(monkeypatch, code)
    notes = []
    monkeypatch.setattr(fakes.Notes, "step", lambda self, *line: notes.append(line))
    with pytest.raises(StoreError, match=r"out.*cannot be written.*--out"):
        fakes.run(tmp_path / "out")
    assert notes == []
    assert tree(tmp_path) == ["out"]


@pytest.mark.parametrize("after", range(14))
def test_a_disk_that_fills_up_leaves_nothing_half_written(tmp_path, monkeypatch, after):
    """Fourteen writes make this study: fail at each, then go on with room on the disk."""
    with monkeypatch.context() as patch:
        refuse_to_write(patch, errno.ENOSPC, after)
        with pytest.raises(StoreError, match="no space left on device; free some space"):
            fakes.run(tmp_path / "out")
    assert not (tmp_path / "out/stages/outputs.json").exists()
    assert not list(tmp_path.rglob(".partial-*"))
    assert len(fakes.run(tmp_path / "out").reused()) == min(3, max(0, (after - 1) // 3))
    assert len(fakes.run(tmp_path / "out").lines) == 1


def test_a_real_limit_on_the_size_of_files(tmp_path):
    """The operating system itself refuses to write more: what it says arrives as one line."""
    script = (
        "import sys; sys.path.insert(0, sys.argv[2]); import fakes, pathlib\n"
        "from fibermelt.errors import StoreError\n"
        "try: fakes.run(pathlib.Path(sys.argv[1]))\n"
        "except StoreError as error: sys.exit(str(error))\n"
    )
    small = 2000  # bytes: the folder's marker fits, a netCDF file does not
    done = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "out", Path(fakes.__file__).parent],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (small, small)),
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "file too large; free some space" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_flow_without_an_answer_leaves_nothing(tmp_path):
    with pytest.raises(ConvergenceError, match="no steady surface"):
        fakes.run(tmp_path / "deep/out", "flow.gap=2 mm")
    assert tree(tmp_path) == []


def test_a_failure_leaves_earlier_results_as_they_were(tmp_path):
    fakes.run(tmp_path / "out")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(ConvergenceError):
        fakes.run(tmp_path / "out", "flow.gap=2 mm")
    after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert after == before
