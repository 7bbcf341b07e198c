"""Studies of flows from elsewhere, in the plane: our own bead, read back from others' files.

Direct and read back the same fibers meet the same pressures, within the error that is stated.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from coarse_runs import COARSE, computed, fibermelt, here
from dialects import Sample, fluent, sectionwise
from exact_flows import Mesh

from fibermelt.parts.bead.stages import stored_path
from fibermelt.report.kit.scene import read_scene

pytestmark = pytest.mark.end_to_end

WITHIN = 0.04
"""Part of an extreme by which it may differ away from singular corners: 0.024 on the coarse mesh,
whose triangles are three times the default's; 0.006 on that (docs/verification.md)."""

STUDY = """
study.parts = ["bead"]
fiber.initial_angles = ["-60 deg", "0 deg", "45 deg", "90 deg"]

[flow]
source = "field"

[field]
file = "{file}"

[paths]
from = ["-6.35 mm", "22 mm"]
to = ["6.35 mm", "22 mm"]
count = 4

[streamlines]
points = 200

[numerics]
cell_order = 5
isotropic_angles = 20
"""


def read(folder: Path) -> xr.Dataset:
    with xr.open_dataset(folder / "results.nc", engine="h5netcdf") as results:
        return results.load()


@pytest.fixture(scope="module")
def direct(tmp_path_factory):
    out = tmp_path_factory.mktemp("direct") / "out"
    computed(COARSE, out)
    return out


def of_nodes(found: xr.Dataset) -> Sample:
    """Return the flow on the small triangles between its nodes."""
    cells = read_scene(found).triangles
    points = np.stack([found["node_x"], found["node_y"]], axis=-1)
    return Sample(
        Mesh(points, cells), found["node_velocity"].to_numpy(), found["node_pressure"].to_numpy()
    )


@pytest.mark.parametrize("dialect", ["vtu", "comsol", "fluent"])
def test_our_own_bead_read_back(direct, tmp_path, dialect):
    known = read(direct)
    writers = {"comsol": sectionwise, "fluent": fluent}
    written = dialect != "vtu"
    file = writers[dialect](tmp_path, of_nodes(known)) if written else direct / "flow.vtu"
    (tmp_path / "study.toml").write_text(STUDY.format(file=file))
    run = computed(tmp_path / "study.toml", tmp_path / "out")
    summary, found = run.summary, run.results
    assert [path["end"] for path in summary["paths"]] == ["outlet"] * 4
    assert "bead_height" not in summary["flow"]
    assert "zone_time" not in found
    regular = known["near_singularity"].to_numpy() == 0
    assert regular.any()
    for kind in ("min", "max"):
        there = known["extreme"].sel(kind=kind, location=0)
        one = there.transpose("streamline", "initial_angle").to_numpy()[regular]
        other, error = (
            found[name].sel(kind=kind, location=0).transpose("streamline", "initial_angle")
            for name in ("extreme", "extreme_error")
        )
        miss = np.abs(other.to_numpy()[regular] - one)
        assert np.all(miss < WITHIN * np.abs(one))
        assert np.all(miss < error.to_numpy()[regular])
    assert "paths" in run.drawn()


TURNED = 0.01
"""Angle [rad] by which a fiber may lie otherwise at a zone: 0.005 on the coarse mesh."""

STATIONS = """entrance = "y = 9 mm"
exit = "y = 3 mm"
end_of_swell = "x = 10 mm"
"""


def at_end_of_swell(known: xr.Dataset) -> np.ndarray:
    """Return the angles to the streamline where a bead's own streamlines pass x = 10 mm."""
    path = stored_path(known)
    when = path.time_across(0, 0.01)
    away = known["angle"].transpose("streamline", "initial_angle", "point").to_numpy()
    away = away - path.direction[:, None, :]
    return np.array(
        [
            [np.interp(at, time, one) for one in lines]
            for at, time, lines in zip(when, path.time, away, strict=True)
        ]
    )


def apart(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the angles between directions without a head [rad]."""
    return np.abs(np.angle(np.exp(2j * (one - other)))) / 2


def test_stations_give_what_those_of_the_bead_do(direct, tmp_path):
    """Zones and locations of our own bead read back, its stations named as planes."""
    known = read(direct)
    study = STUDY.replace("count = 4\n", f"count = 4\n{STATIONS}")
    (tmp_path / "study.toml").write_text(study.format(file=direct / "flow.vtu"))
    done = fibermelt("run", "study.toml", "--out", "out", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    found = read(tmp_path / "out")
    assert found["zone"].to_numpy().tolist() == [1, 2, 3]
    assert found["location"].to_numpy().tolist() == [0, 1, 2]
    regular = known["near_singularity"].to_numpy() == 0
    one, other = (each["zone_time"].to_numpy()[regular][:, :2] for each in (found, known))
    assert one == pytest.approx(other, rel=1e-3)
    dims = ("streamline", "initial_angle", "zone")
    one, other = (each["zone_angle"].transpose(*dims).to_numpy() for each in (found, known))
    other = np.dstack([other[..., :2], at_end_of_swell(known)])
    miss = apart(one, other)[regular]
    assert miss[..., :2].max() < TURNED
    assert np.median(miss[..., 2]) < TURNED  # one that is turning there is off by its motion
    for kind in ("min", "max"):
        dims = ("streamline", "initial_angle", "location")
        one, other, error = (
            each.sel(kind=kind).transpose(*dims).to_numpy()[regular]
            for each in (found["extreme"], known["extreme"], found["extreme_error"])
        )
        assert np.all(np.abs(one - other) < WITHIN * np.abs(other))
        assert np.all(np.abs(one - other) < error)
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    told = [(one["streamline"], one["zone"]) for one in summary["orientation"]]
    assert told == [(line, zone) for line in (1, 2, 3, 4) for zone in (1, 2, 3)]
    page = (tmp_path / "out/report.html").read_text()
    assert "another solver" in page
    assert 'id="figure-paths"' in page or "The paths" in page
    assert "Orientation at the zones" in page


def table(found: xr.Dataset, rows: list[int]) -> str:
    lines = ["path, time [s], x [mm], y [mm], u [mm/s], v [mm/s], pressure, L_xx, L_xy, L_yx, L_yy"]
    for row in rows:
        one = found.isel(streamline=row)
        columns = [one["time"], *(1e3 * one[name] for name in "xyuv"), one["pressure"]]
        values = np.column_stack([*columns, one["gradient"].to_numpy().reshape(-1, 4)])
        lines += [", ".join(f"{value:.17g}" for value in (row, *line)) for line in values]
    return "\n".join(lines)


def test_a_table_of_paths_is_a_study(direct, tmp_path, monkeypatch):
    """The very numbers of the bead's own streamlines lead to the very extremes."""
    known = read(direct)
    (tmp_path / "paths.csv").write_text(table(known, [1, 2]))
    study = STUDY.partition("[field]")[0].replace('"field"', '"histories"')
    study = study.replace('["bead"]', '["bead", "orientation", "voids"]')
    (tmp_path / "study.toml").write_text(
        f'{study}[paths]\nfile = "paths.csv"\n{STATIONS}'
        "[numerics]\ncell_order = 5\nisotropic_angles = 20\n"
    )
    done = fibermelt("run", "study.toml", "--out", "out", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "2 as they were given" in done.stdout
    found = read(tmp_path / "out")
    for name in ("extreme", "zone_time", "zone_angle"):
        one, other = (each.isel(zone=[0, 1])[name] for each in (known, found))
        one = one.isel(streamline=[1, 2]).transpose(*other.dims)
        assert other.to_numpy() == pytest.approx(one.to_numpy(), rel=1e-9), name
    assert not [name for name in found if "void_layer" in name or name == "void_height"]
    page = (tmp_path / "out/report.html").read_text()
    assert "Orientation along the paths" in page
    assert "Orientation in the bead" not in page

    (tmp_path / "paths.csv").write_text(table(known, [1]))
    monkeypatch.chdir(tmp_path)
    again = computed("study.toml", tmp_path / "out")
    assert again.results.sizes["streamline"] == 1  # a file that changed is read again

    swept = tmp_path / "swept.toml"
    swept.write_text(
        (tmp_path / "study.toml").read_text() + '[sweep]\n"fiber.aspect_ratio" = [5, 6]\n'
    )
    done = fibermelt("sweep", swept, "--out", "swept", "--workers", "1", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "2 of 2 done, 0 failed" in done.stdout


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["flow.source=field"], "field.file: missing"),
        (["flow.source=histories"], "paths.file: missing"),
        (["paths.file=nothing.csv"], "nothing.csv: cannot be read"),
        (['flow.source="field"', "field.file=here", 'study.parts=["bead", "claims"]'], "claims"),
        (["paths.count=7"], "paths.count: is not read with flow.source"),
        (
            ["flow.source=histories", "paths.file=here", "streamlines.points=300"],
            "streamlines.points = 300: is not read with flow.source",
        ),
        (['paths.exit="y = 3 mm"'], "paths.exit: is not read with flow.source"),
        (['paths.exit="y + 3 mm"'], 'must be "x", "y" or "z", or such as "y = 2 mm"'),
        (['paths.seeds="points"'], "without paths.points"),
        (['paths.seeds="line"'], "without paths.from"),
        (['paths.from=["1 mm"]'], "give x, y"),
    ],
)
def test_what_is_no_flow_from_elsewhere(tmp_path, overrides, said):
    (tmp_path / "here").write_text("a file")
    sets = [part for override in overrides for part in ("-s", override)]
    done = here("validate", "paper", "-s", 'study.parts=["bead"]', *sets, folder=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
