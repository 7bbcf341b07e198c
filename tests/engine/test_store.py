"""The pieces that the store is made of: sealed files, atomic writes, locks, whose folder it is."""

import errno
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from patience import PATIENCE

from fibermelt.engine.files import (
    canonical,
    claimed,
    digest,
    partial,
    read_sealed,
    remove_leftovers,
    replace_file,
    storage_errors,
    write_sealed,
)
from fibermelt.engine.schema import refuse_foreign
from fibermelt.errors import StoreError

WORDS = st.text(max_size=4)
JSON = st.recursive(
    st.none() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | WORDS,
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=4,
)


@given(st.dictionaries(WORDS, JSON, max_size=4))
def test_canonical_json_does_not_depend_on_order(content):
    backwards = dict(reversed(list(content.items())))
    assert canonical(content) == canonical(backwards)


def test_canonical_json_keeps_every_digit():
    assert canonical({"b": 0.1 + 0.2, "a": (1,)}) == b'{"a":[1],"b":0.30000000000000004}'


def test_sealed_content_is_read_back(tmp_path):
    content = {"key": "abc", "cost": 0.1 + 0.2, "parameters": {"flow.gap": 0.003}}
    write_sealed(tmp_path / "record.json", content)
    assert read_sealed(tmp_path / "record.json") == content


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"content": {}, "sha256": "0"}', "\x00"])
def test_what_is_not_sealed_is_refused(tmp_path, text):
    (tmp_path / "record.json").write_text(text)
    with pytest.raises(ValueError, match="is not what was written"):
        read_sealed(tmp_path / "record.json")


def test_a_file_is_replaced_whole(tmp_path):
    replace_file(tmp_path / "file", b"old")
    replace_file(tmp_path / "file", b"new")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"file": b"new"}


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    replace_file(tmp_path / "file", b"old")

    def fail(handle):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(StoreError, match=r"file: cannot be written.*no space left"):
        replace_file(tmp_path / "file", b"new")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"file": b"old"}


@pytest.mark.parametrize(
    ("code", "remedy"),
    [(28, "free some space"), (27, "free some space"), (30, "--out"), (13, "--out"), (5, "fault")],
)
def test_what_the_system_says_comes_with_a_remedy(tmp_path, code, remedy):
    with pytest.raises(StoreError, match=remedy), storage_errors(tmp_path):
        raise OSError(code, os.strerror(code))


def test_what_this_process_writes_is_no_leftover(tmp_path):
    mine = partial(tmp_path)
    mine.mkdir()
    remove_leftovers(tmp_path)
    assert mine.exists()


def test_leftovers_of_another_machine_go_when_they_are_old(tmp_path):
    young, old = tmp_path / ".partial-elsewhere-1-aa", tmp_path / ".partial-elsewhere-1-bb"
    young.touch()
    old.touch()
    os.utime(old, (0, 0))
    remove_leftovers(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [young.name]


@pytest.mark.parametrize("name", [".partial-notes", ".partial-a-b-c", ".partial-a-1-b-c"])
def test_what_only_looks_like_a_leftover_stays(tmp_path, name):
    """It ended every run into the folder with a traceback."""
    (tmp_path / name).touch()
    os.utime(tmp_path / name, (0, 0))
    remove_leftovers(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.skipif(not hasattr(os, "waitid"), reason="no zombies here")
def test_what_a_dead_process_left_goes_although_nobody_waited_for_it(tmp_path):
    """Its number is still taken until its parent, or whoever adopts it, asks for its end."""
    child = subprocess.Popen([sys.executable, "-c", ""])
    os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
    host = partial(tmp_path).name.removeprefix(".partial-").split("-")[0]
    (tmp_path / f".partial-{host}-{child.pid}-aa").touch()
    remove_leftovers(tmp_path)
    left = list(tmp_path.iterdir())
    child.wait()
    assert left == [] or not Path("/proc/self/stat").exists()


def test_a_lock_is_held_by_one_at_a_time(tmp_path):
    seen = []

    def other():
        with claimed(tmp_path / "lock", wait=True):
            seen.append("other")

    with claimed(tmp_path / "lock", wait=True):
        thread = threading.Thread(target=other)
        thread.start()
        thread.join(timeout=0.05)
        seen.append("first")
    thread.join(timeout=PATIENCE)
    assert seen == ["first", "other"]


def test_who_does_not_wait_is_told_that_a_lock_is_taken(tmp_path):
    path = tmp_path / "lock"
    with claimed(path, wait=False) as first:
        assert first
        with claimed(path, wait=False) as second:
            assert not second
    assert not path.exists()


def test_where_there_are_no_locks_nobody_waits(tmp_path, monkeypatch):
    """A run on a network drive without locks ended with "choose another folder"."""
    fcntl = pytest.importorskip("fcntl")

    def none(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", none)
    with (
        claimed(tmp_path / "lock", wait=True) as ours,
        claimed(tmp_path / "lock", wait=False) as too,
    ):
        assert ours
        assert too


def test_a_lock_that_cannot_be_made_names_its_file(tmp_path):
    with (
        pytest.raises(StoreError, match=r"none/lock: cannot be written.*no such file"),
        claimed(tmp_path / "none/lock", wait=False),
    ):
        pass


def test_a_new_folder_is_free(tmp_path):
    refuse_foreign(tmp_path / "none", tmp_path / "none/stages/store.json")
    (tmp_path / "study.toml").write_text("")
    refuse_foreign(tmp_path, tmp_path / "stages/store.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (json.dumps({"schema": 2}), r"has schema 2, this fibermelt writes 1; choose.*--out"),
        ("not json", "holds summary.json, which no run of fibermelt keeps track of"),
        (json.dumps([1]), "holds summary.json"),
        (json.dumps({"schema": 1}), "holds summary.json"),
    ],
)
def test_a_summary_that_is_not_ours(tmp_path, text, message):
    (tmp_path / "summary.json").write_text(text)
    with pytest.raises(StoreError, match=message):
        refuse_foreign(tmp_path, tmp_path / "stages/store.json")


@pytest.mark.parametrize("text", ["", "{", "{}", '{"schema": null}', "[" * 100_000])
def test_a_marker_that_cannot_be_read(tmp_path, text):
    (tmp_path / "store.json").write_text(text)
    with pytest.raises(StoreError, match=r"store\.json: is damaged.*run --fresh.*move.*--out"):
        refuse_foreign(tmp_path, tmp_path / "store.json")
    refuse_foreign(tmp_path, tmp_path / "store.json", fresh=True)


def test_fresh_is_no_way_into_another_schema(tmp_path):
    (tmp_path / "store.json").write_text(json.dumps({"schema": 2}))
    with pytest.raises(StoreError, match="has schema 2"):
        refuse_foreign(tmp_path, tmp_path / "store.json", fresh=True)


def test_a_digest_is_sha256():
    assert digest(b"") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"
