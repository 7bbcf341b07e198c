"""What killed sweeps left of temporary files: removed when nobody can use it any more."""

import fcntl
import os
import subprocess
import sys

import pytest

from fibermelt.engine.files import has_dead_maker, made_name
from fibermelt.errors import StoreError
from fibermelt.sweeps.scratch import PREFIX, scratch_folder


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Have temporary files in a folder of their own."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def left(place):
    """Return the folder that a dead process left."""
    ended = subprocess.Popen([sys.executable, "-S", "-c", ""])
    ended.wait()
    folder = place / made_name(PREFIX).replace(f"-{os.getpid()}-", f"-{ended.pid}-")
    (folder / "dask-scratch-space").mkdir(parents=True)
    (folder / "dask-scratch-space" / "worker.dirlock").touch()
    return folder


def test_a_scratch_folder_is_ours_alone_and_goes(place):
    with scratch_folder() as folder:
        assert (folder.parent, folder.stat().st_mode & 0o777) == (place, 0o700)
        assert has_dead_maker(folder.name, PREFIX) is False
        (folder / "file").touch()
        with scratch_folder() as another:
            assert another != folder
        assert folder.is_dir()
    assert list(place.iterdir()) == []


def test_what_the_dead_left_is_removed(place, left):
    with scratch_folder() as folder:
        assert list(place.iterdir()) == [folder]


def test_what_a_worker_still_uses_is_not(left):
    with (left / "dask-scratch-space" / "worker.dirlock").open("wb") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        with scratch_folder():
            assert left.is_dir()
    with scratch_folder():
        assert not left.exists()


def test_what_is_not_known_to_be_left_stays(place, left):
    """Folders of a living process, of another machine, of nobody, of somebody else, and links."""
    _, host, dead, token = left.name.split("-")
    stay = [
        place / f"{PREFIX}{host}-{os.getppid()}-{token}",
        place / f"{PREFIX}other_{host}-{dead}-{token}",
        place / f"{PREFIX}mine",
        place / f"{PREFIX}{host}-x-{token}",
    ]
    for folder in stay:
        folder.mkdir()
    link = place / f"{PREFIX}{host}-{dead}-{token}0"
    link.symlink_to(left.parent)
    with scratch_folder():
        assert not left.exists()
        assert all(folder.is_dir() for folder in stay)
        assert link.is_symlink()


def test_what_is_of_another_user_stays(left, monkeypatch):
    monkeypatch.setattr("os.getuid", lambda: left.stat().st_uid + 1)
    with scratch_folder():
        assert left.is_dir()


def test_no_place_for_temporary_files_is_one_line(place, monkeypatch):
    (place / "file").touch()
    monkeypatch.setattr("tempfile.tempdir", str(place / "file"))
    message = "no place for the temporary files of workers: not a directory; have TMPDIR name"
    with pytest.raises(StoreError, match=message), scratch_folder():
        pass
