"""A sweep collected as Zarr: what the netCDF file holds, and nothing else in its place."""

import importlib.util

import fake_sweeps
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from fibermelt.cli import app

pytestmark = pytest.mark.end_to_end

SMALL = """preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = ["2 mm", "3 mm"]
"fiber.aspect_ratio" = [4, 6, 8]
"""
"""The first gap has no answer: there are missing numbers, and texts that tell why."""


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("swept")
    fake_sweeps.sweep(fake_sweeps.study_file(folder, SMALL), folder / "out")
    return folder / "out"


def collect(*arguments):
    return CliRunner().invoke(app, ["collect", *map(str, arguments)])


@pytest.fixture
def installed():
    pytest.importorskip("zarr", reason='needs zarr: pip install "fibermelt[zarr]"')


@pytest.mark.usefixtures("installed")
def test_zarr_holds_what_netcdf_does(out):
    assert collect(out).exit_code == 1
    for _ in range(2):  # the second takes the place of the first
        done = collect(out, "--zarr")
        assert (done.exit_code, done.stderr) == (1, "")
    with (
        xr.open_dataset(out / "sweep.nc", engine="h5netcdf") as expected,
        xr.open_zarr(out / "sweep.zarr", chunks=None) as found,
    ):
        assert found.attrs == expected.attrs
        assert found.sizes == expected.sizes
        assert set(found.coords) == set(expected.coords)
        assert set(found.data_vars) == set(expected.data_vars)
        for name, variable in expected.variables.items():
            assert found[name].dims == variable.dims
            assert found[name].attrs == variable.attrs
            # To the last bit, with NaN where a case has no answer.
            np.testing.assert_array_equal(found[name].values, variable.values)
        assert "no steady surface" in str(found["reason"].values[0, 0])
    assert not list(out.glob(".partial-*"))


@pytest.mark.usefixtures("installed")
def test_a_folder_that_is_no_zarr_stays(out, tmp_path):
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("mine")
    done = collect(out, "--zarr", "--to", tmp_path / "thesis")
    assert done.exit_code == 2
    assert "thesis: is there and no Zarr; it is not overwritten" in done.stderr
    assert (tmp_path / "thesis" / "chapter.tex").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["thesis"]
    done = collect(out, "--zarr", "--to", tmp_path / "nowhere" / "mine.zarr")
    assert (done.exit_code, "there is no folder" in done.stderr) == (2, True)


def test_without_zarr_the_way_out_is_told(out, monkeypatch):
    real = importlib.util.find_spec
    monkeypatch.setattr(
        "fibermelt.sweeps.collect.find_spec",
        lambda name: None if name == "zarr" else real(name),
    )
    done = collect(out, "--zarr")
    assert done.exit_code == 2
    assert 'pip install "fibermelt[zarr]", or leave it away for netCDF' in done.stderr
