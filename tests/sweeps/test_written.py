"""Collected sweeps on the disk: whole or not there, and nothing lost of what was there before."""

from pathlib import Path

import pytest
import xarray as xr

from fibermelt.errors import StoreError
from fibermelt.sweeps.collect import write_netcdf, write_zarr


class Written:
    """Stands for a dataset: leaves what Zarr does, without the time to load it."""

    def to_zarr(self, folder, **_):
        folder.mkdir()
        (folder / "zarr.json").write_text("new")


@pytest.mark.parametrize("fails", [False, True])
def test_the_zarr_of_before_stays_until_the_new_one_has_its_name(tmp_path, monkeypatch, fails):
    """Moved away first, it was removed although the new one never came to its place."""
    pytest.importorskip("zarr")
    path = tmp_path / "sweep.zarr"
    path.mkdir()
    (path / "zarr.json").write_text("old")
    rename = Path.rename

    def refused(self, target):
        if fails and target == path and (self / "zarr.json").read_text() == "new":
            raise OSError(13, "Permission denied")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refused)
    if fails:
        with pytest.raises(StoreError, match="permission denied"):
            write_zarr(Written(), path)
    else:
        write_zarr(Written(), path)
    assert (path / "zarr.json").read_text() == ("old" if fails else "new")
    assert [entry.name for entry in tmp_path.iterdir()] == ["sweep.zarr"]


@pytest.mark.parametrize("mine", ["", "notes of mine"])
def test_a_file_that_is_no_dataset_is_not_overwritten(tmp_path, mine):
    path = tmp_path / "sweep.nc"
    path.write_text(mine)
    with pytest.raises(StoreError, match="no dataset; it is not overwritten"):
        write_netcdf(xr.Dataset(), path)
    assert path.read_text() == mine
