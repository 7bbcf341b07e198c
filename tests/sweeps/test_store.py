"""The files of a sweep: whole or not there, without objects, locked while somebody is at them."""

import errno
import io
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.engine.files import digest
from fibermelt.errors import StoreError
from fibermelt.sweeps.collection import Batch, Kept, reduce_results, stack
from fibermelt.sweeps.store import CaseStore, Failure, open_case_store


def kept(values, dimensions=(), units="Pa"):
    return Kept(dimensions, np.asarray(values), units, "a number")


def batch(*keys, value=1.0):
    (made,) = stack(
        [(key, {"p": kept(value), "model": kept("ellipse", units="1")}) for key in keys]
    )
    return made


@pytest.fixture
def store(tmp_path):
    return open_case_store(tmp_path / "out")


def test_a_batch_comes_back_as_it_was(store):
    numbers = {
        "kind": kept(["min", "max"], ("kind",), "1"),
        "extreme": kept([1 / 3, np.nan], ("kind",)),
        "model": kept("ellipse", units="1"),
    }
    (made,) = stack([("a", numbers), ("b", numbers)])
    store.write_batch(made)
    assert store.refresh() == {"a", "b"}
    (read,) = store.batches()
    assert read.keys == ("a", "b")
    assert read.variables["extreme"].dimensions == ("case", "kind")
    for name, expected in made.variables.items():
        np.testing.assert_array_equal(read.variables[name].values, expected.values)
        assert read.variables[name].long_name == expected.long_name


def test_cases_with_other_labels_lie_in_another_batch():
    cases = [(str(n), {"zone": kept(np.arange(n), ("zone",), "1")}) for n in (2, 3, 2)]
    assert [made.keys for made in stack(cases)] == [("2", "2"), ("3",)]


@given(
    at=st.floats(0, 1, exclude_max=True),
    bit=st.integers(0, 7),
    cut=st.booleans(),
)
def test_every_damaged_batch_is_known(at, bit, cut, tmp_path_factory):
    store = open_case_store(tmp_path_factory.mktemp("out"))
    store.write_batch(batch("a", "b"))
    (path,) = store.folder.glob("batch-*")
    data = bytearray(path.read_bytes())
    place = int(at * len(data))
    data[place] ^= 1 << bit
    path.write_bytes(data[:place] if cut else data)
    assert store.refresh() == set()
    assert store.damaged == [path]
    assert store.discard_damaged() == [path]
    assert not path.exists()


def test_a_batch_that_cannot_be_read_is_not_taken_for_damaged(store, monkeypatch):
    """It would be removed as damaged, although a drive that is back has it whole."""
    store.write_batch(batch("a", "b"))
    (path,) = store.folder.glob("batch-*")

    def stale(_):
        raise OSError(errno.ESTALE, "Stale file handle")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "read_bytes", stale)
        with pytest.raises(StoreError, match=r"batch-.*npz: cannot be written or read: stale"):
            store.refresh()
    assert store.discard_damaged() == []
    assert path.exists()
    assert store.refresh() == {"a", "b"}


def test_a_batch_that_goes_while_it_is_read_is_not_there(store, monkeypatch):
    store.write_batch(batch("a", "b"))
    assert store.refresh() == {"a", "b"}
    refresh = CaseStore.refresh

    def then_gone(self):
        found = refresh(self)
        for path in self.folder.glob("batch-*"):
            path.unlink()
        return found

    monkeypatch.setattr(CaseStore, "refresh", then_gone)
    assert list(store.batches()) == []


class Explosive:
    """Unpickled, it would leave a file."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (Path.touch, (self.path,))


def forge(store, victim, objects):
    """Write a batch whose name is right, and one of whose arrays is of objects."""
    whole = zipfile.ZipFile(io.BytesIO(batch("a").to_bytes()))
    forged, array = io.BytesIO(), io.BytesIO()
    np.save(array, objects, allow_pickle=True)
    with zipfile.ZipFile(forged, "w") as file:
        for name in whole.namelist():
            file.writestr(name, array.getvalue() if name == victim else whole.read(name))
    data = forged.getvalue()
    path = store.folder / f"batch-{digest(data)[:20]}.npz"
    path.write_bytes(data)
    return path


def test_no_pickle_is_read(store, tmp_path):
    trace = tmp_path / "executed"
    objects = np.empty(1, dtype=object)
    objects[0] = Explosive(trace)
    path = forge(store, "key.npy", objects)
    assert store.refresh() == set()
    assert store.damaged == [path]
    store.discard_damaged()
    path = forge(store, "v_p.npy", objects)
    with pytest.raises(StoreError, match="no sweep wrote this"):
        list(store.batches())
    assert not trace.exists()
    pickle.loads(pickle.dumps(objects[0]))
    assert trace.exists(), "the trap itself does not work"


def test_what_is_new_is_seen_by_a_store_that_is_open(store):
    other = CaseStore(store.directory)
    assert other.refresh() == set()
    store.write_batch(batch("a"))
    assert other.refresh() == {"a"}


def failure(key, *, lasting):
    return Failure("flow", key * 64, "ConvergenceError", "no surface", {"flow.gap": 1e-3}, lasting)


def test_a_failure_that_lasts_is_kept_and_an_accident_is_not(store):
    for made in (failure("a", lasting=True), failure("b", lasting=False)):
        store.write_failure(made)
    assert store.failures()["a" * 64] == failure("a", lasting=True)
    store.forget_failures(lasting=False)
    assert set(store.failures()) == {"a" * 64}
    store.forget_failures(lasting=True)
    assert store.failures() == {}


def test_a_damaged_failure_counts_as_none_and_goes(store):
    store.write_failure(failure("a", lasting=True))
    (path,) = store.folder.glob("failed-*")
    path.write_bytes(path.read_bytes()[:-10])
    assert store.failures() == {}
    store.forget_failures(lasting=False)
    assert not path.exists()


def test_a_sweep_comes_back_and_a_damaged_one_is_named(store):
    content = {"name": "mine", "cases": [1, 2.5, None]}
    store.write_sweep(content)
    assert store.read_sweep() == {**content, "schema": 1}
    path = store.directory / "sweep.json"
    path.write_bytes(path.read_bytes().replace(b"2.5", b"3.5"))
    with pytest.raises(StoreError, match=r"sweep\.json: is damaged.*sweep STUDY --out"):
        store.read_sweep()
    path.unlink()
    with pytest.raises(StoreError, match=r"sweep\.json: is missing.*sweep STUDY --out"):
        store.read_sweep()
    with pytest.raises(StoreError, match="holds no sweep"):
        CaseStore(store.directory / "stages").read_sweep()


def test_somebody_elses_sweep_is_not_overwritten(tmp_path):
    (tmp_path / "sweep.json").write_text("mine")
    with pytest.raises(StoreError, match=r"holds sweep\.json.*not overwritten"):
        open_case_store(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.json"]


def test_what_is_kept_of_a_case():
    about = {"units": "Pa", "long_name": "pressure"}
    data = xr.Dataset(
        {
            "number": ((), 1.0, about),
            "extreme": (("streamline", "initial_angle"), [[1.0, 3.0, 2.0]], about),
            "path": (("streamline", "point"), np.ones((1, 9)), about),
            "initial_angle": (("initial_angle",), [0.0, 1.0, 2.0], {**about, "units": "rad"}),
            "speed": (("initial_angle", "streamline"), np.ones((3, 1)), {**about, "units": "m/s"}),
        }
    )
    found = reduce_results(data)
    assert set(found) == {"number", "extreme_min", "extreme_max", "extreme_mean"}
    assert found["extreme_min"].dimensions == ("streamline",)
    assert [found[f"extreme_{n}"].values.item() for n in ("min", "max", "mean")] == [1, 3, 2]
    assert found["extreme_max"].long_name == "pressure: largest of all initial angles"


def test_the_mean_angle_is_that_of_lines():
    """A fiber at 89 degrees and one at -89 lie at 90 degrees on the average, not at 0."""
    angles = np.radians([[89.0, -89.0]])
    about = {"units": "rad", "long_name": "angle"}
    data = xr.Dataset({"zone_angle": (("zone", "initial_angle"), angles, about)})
    mean = reduce_results(data)["zone_angle_mean"].values
    assert abs(np.cos(mean)) == pytest.approx(0, abs=1e-15)


def test_a_file_of_keys_without_numbers_is_no_batch():
    buffer = io.BytesIO()
    np.savez(buffer, key=np.array(["a"]))
    with pytest.raises(KeyError):
        Batch.from_bytes(buffer.getvalue())
