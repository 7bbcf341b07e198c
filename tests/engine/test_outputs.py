"""What is on show in a results folder: of one run, whole, and replaced without being lost."""

import pytest

from fibermelt.engine import outputs
from fibermelt.engine.files import remove
from fibermelt.engine.outputs import (
    has_run,
    is_published,
    publish,
    read_outputs,
    replace_output,
)
from fibermelt.engine.store import Store
from fibermelt.errors import DamagedError, StoreError

PAGE = "report.html"


def shown(**files):
    """Return what writes some files."""

    def write(folder):
        for name, text in files.items():
            (folder / f"{name}.html").write_text(text)

    return write


@pytest.fixture
def folder(tmp_path):
    store = Store.open(tmp_path / "out")
    publish(store.directory, "first", shown(report="old", other="other"))
    return store.directory


def test_a_page_that_is_made_again_does_not_count_as_changed(folder):
    """After `fibermelt report` of another version the next run ended with "was changed"."""
    replace_output(folder, PAGE, b"new", "first")
    assert (folder / PAGE).read_bytes() == b"new"
    assert is_published(folder, "first")
    assert sorted(read_outputs(folder).files) == ["other.html", "report.html"]
    assert not is_published(folder, "second")


def test_a_page_that_the_run_did_not_write_is_not_its_own(folder):
    replace_output(folder, "mine.html", b"mine", "first")
    assert sorted(read_outputs(folder).files) == ["other.html", "report.html"]
    assert is_published(folder, "first")


def test_a_page_of_a_run_that_another_has_replaced_is_refused(folder):
    """It would stand beside the numbers of the other run, and count as its page."""
    publish(folder, "second", shown(report="newer"))
    with pytest.raises(StoreError, match=r"another run was put on show.*make it again"):
        replace_output(folder, PAGE, b"new", "first")
    assert (folder / PAGE).read_text() == "newer"


@pytest.mark.parametrize("step", ["page", "list"])
def test_who_is_killed_while_a_page_is_replaced_leaves_none_that_counts_as_changed(
    folder, monkeypatch, step
):
    class KilledError(Exception):
        pass

    write_list, done = outputs._write, []

    def killed(*_):
        raise KilledError

    def write_once(*content):
        if done:
            raise KilledError
        done.append(content)
        write_list(*content)

    if step == "page":
        monkeypatch.setattr(outputs, "replace_file", killed)
    else:
        monkeypatch.setattr(outputs, "_write", write_once)
    with pytest.raises(KilledError):
        replace_output(folder, PAGE, b"new", "first")
    monkeypatch.undo()
    assert is_published(folder, "first")
    assert (folder / PAGE).read_bytes() == (b"old" if step == "page" else b"new")


def test_a_changed_file_is_named(folder):
    (folder / PAGE).write_text("edited")
    with pytest.raises(DamagedError, match=r"report\.html: is damaged, or was changed"):
        is_published(folder, "first")
    remove(folder / PAGE)
    assert not is_published(folder, "first")


def test_a_run_that_cannot_be_put_on_show_leaves_the_one_before(folder):
    def fails(into):
        (into / PAGE).write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(StoreError, match="no space left on device"):
        publish(folder, "second", fails)
    assert has_run(folder)
    assert is_published(folder, "first")
    assert not list(folder.glob(".partial*"))
