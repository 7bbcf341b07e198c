"""Files of labelled arrays: what is read is what was written, by us and by other readers."""

import io

import numpy as np
import pytest
import xarray as xr

from fibermelt.engine.netcdf import from_bytes, to_bytes
from fibermelt.errors import StoreError


def told(meaning):
    return {"units": "1", "long_name": meaning}


def every_kind():
    """Return a dataset of all that results have: its dimensions have a variable, or none."""
    count = {**told("counts"), "range": [1.0, 2.0]}
    return xr.Dataset(
        {
            "empty": ("none", np.zeros(0), told("an empty one")),
            "one": ((), 0.1 + 0.2, told("a number")),
            "word": ((), "", told("an empty text")),
            "gap": ("line", [1.0, np.nan], told("with one that is not known")),
            "square": (("line", "other"), [[1.0, 2.0], [3.0, 4.0]], told("of two dimensions")),
            "flag": (("line", "other"), [[True, False], [False, True]], told("yes or no")),
            "count": ("line", np.array([1, 2], dtype=np.int32), count),
        },
        coords={
            "line": ("line", [3, 1], told("of a dimension")),
            "name": ("line", ["a", "Pa·s"], told("beside a dimension")),
        },
        attrs={"title": "every kind", "schema": 1, "version": 1.5},
    )


def h5netcdf(data):
    with xr.open_dataset(io.BytesIO(data), engine="h5netcdf") as dataset:
        return dataset.load()


@pytest.mark.parametrize("reader", [from_bytes, h5netcdf])
def test_what_is_read_is_what_was_written(reader):
    written = every_kind()
    read = reader(to_bytes(written))
    xr.testing.assert_identical(read, written)
    assert list(read.data_vars) == list(written.data_vars)
    assert {name: read[name].dtype.kind for name in read} == {
        name: written[name].dtype.kind for name in written
    }


def test_the_same_dataset_gives_the_same_bytes():
    assert to_bytes(every_kind()) == to_bytes(every_kind())


def test_what_another_library_wrote_is_read():
    """A store holds what was written before by xarray's own library."""
    stream = io.BytesIO()
    every_kind().to_netcdf(stream, engine="h5netcdf")
    xr.testing.assert_identical(from_bytes(stream.getvalue()), every_kind())


def test_netcdfs_own_library_reads_it(tmp_path):
    """That in VTK: it takes the dimensions for what they are, and the values to the last bit."""
    vtk = pytest.importorskip("vtkmodules.vtkIONetCDF")
    (tmp_path / "all.nc").write_bytes(to_bytes(every_kind()[["square"]].drop_vars("line")))
    reader = vtk.vtkNetCDFReader()
    reader.SetFileName(str(tmp_path / "all.nc"))
    reader.UpdateMetaData()
    names = reader.GetAllVariableArrayNames()
    assert "square" in [names.GetValue(k) for k in range(names.GetNumberOfValues())]
    reader.SetDimensions("(line, other)")
    reader.Update()
    found = reader.GetOutput().GetPointData().GetArray(
        "square"
    ) or reader.GetOutput().GetCellData().GetArray("square")
    assert [found.GetValue(k) for k in range(4)] == [1.0, 2.0, 3.0, 4.0]


def test_a_variable_says_what_it_is():
    with pytest.raises(StoreError, match=r"^results: variable bare has no units and no long_name"):
        to_bytes(xr.Dataset({"bare": ("x", [1.0])}))
