"""A flow of another melt, or with both speeds faster by one factor, is not solved again."""

import numpy as np
import pytest
import xarray as xr
from coarse_runs import COARSE, fibermelt

from fibermelt.engine.store import Store

pytestmark = pytest.mark.end_to_end

SPEEDS = ("-s", "flow.inlet_speed=12 mm/s", "-s", "flow.bed_speed=50.8 mm/s")
THINNER = ("-s", "melt.viscosity=400 Pa s", *SPEEDS)


def run(folder, *options):
    done = fibermelt("run", COARSE, *options, folder=folder)
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scaled")
    run(folder, "--out", "out")
    return folder


def test_the_same_flow_with_another_scale_is_scaled(once, tmp_path):
    told = run(once, "--out", "out", *THINNER).stderr
    assert "flow: the same flow of another melt, or faster: scaled" in told
    assert "Newton step" not in told
    assert "Newton step" in run(tmp_path, "--out", "fresh", *THINNER).stderr
    flows = {
        len(record.neighbour) > 0
        for record, _ in Store(once / "out", ()).records()
        if record.stage == "flow"
    }
    assert flows == {False, True}
    ours = xr.load_dataset(once / "out/results.nc", engine="h5netcdf")
    theirs = xr.load_dataset(tmp_path / "fresh/results.nc", engine="h5netcdf")
    assert set(ours) == set(theirs)
    for name in ("contact_point", "inlet_pressure", "pressure", "extreme", "quantile_lowest"):
        one, other = ours[name].to_numpy(), theirs[name].to_numpy()
        # Rounding of the ratio of speeds, carried through a Newton's method and a tracing.
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def test_another_ratio_of_speeds_is_solved(once):
    told = run(once, "--out", "out", "-s", "flow.bed_speed=100 mm/s").stderr
    assert "Newton step" in told


def test_fresh_is_fresh(once):
    assert "Newton step" in run(once, "--out", "out", "--fresh", *THINNER).stderr
