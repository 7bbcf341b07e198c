"""A study of another solver's flow in space: a pipe, whose paths and bounds are known."""

import numpy as np
import pytest
from coarse_runs import computed, here
from dialects import sample, vtu
from exact_flows import PIPE

from fibermelt.fiber import Spheroid, unbounded_spheroid

pytestmark = pytest.mark.end_to_end

STUDY = """
study.parts = ["bead"]
melt.viscosity = "800 Pa s"

[flow]
source = "field"

[field]
file = "export.vtu"

[paths]
count = 4
from = ["0 m", "-1.1 m", "-1.1 m"]
to = ["0 m", "1.1 m", "1.1 m"]

[streamlines]
points = 200

[fiber]
model = "spheroid"
directions = "equal-area"
direction_count = 10

[numerics]
isotropic_angles = 20
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("space")
    vtu(folder, sample(PIPE, 8))
    (folder / "pipe.toml").write_text(STUDY)
    return folder


def test_paths_and_fibers_of_a_pipe(folder, monkeypatch):
    monkeypatch.chdir(folder)  # the study names the field by its name alone
    run = computed("pipe.toml", folder / "out")
    summary, found = run.summary, run.results
    assert run.drawn()
    assert [path["end"] for path in summary["paths"]] == ["outlet"] * 4
    y, z = found["y"].to_numpy()[:, 0], found["z"].to_numpy()[:, 0]
    # the centres of flux of the quarters, of 8 cells to the radius
    at = 16 / (15 * np.pi)
    assert np.abs([y, z]) == pytest.approx(at, abs=5e-3)
    speed = 2.0 * (1.0 - y**2 - z**2)
    assert [path["transit_time"] for path in summary["paths"]] == pytest.approx(
        1.0 / speed, rel=1e-4
    )
    # the worst direction of a shear at 4 r, in closed form
    rate = 4.0 * np.hypot(y, z)
    shear = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    worst = 800.0 * unbounded_spheroid(Spheroid(1.0, 6.0)).bounds(shear)[0]
    lowest = found["bound_lowest"].to_numpy().min(axis=1)
    assert lowest == pytest.approx(rate * worst, rel=1e-2)  # of the recovered gradient
    assert np.all(found["extreme"].to_numpy()[..., 0] >= lowest[:, None, None] * (1 + 1e-9))
    flat = ("fiber.model=ellipsoid", "fiber.thickness_ratio=24")
    thin = computed("pipe.toml", folder / "out", *flat).results
    assert float(thin["thickness_ratio"]) == 24.0
    assert np.all(thin["bound_lowest"].to_numpy() < 1.05 * found["bound_lowest"].to_numpy())


def test_fibers_that_are_known_in_a_plane_are_refused(folder):
    done = here(
        "run",
        "pipe.toml",
        "--out",
        "refused",
        "-s",
        "fiber.model=ellipse",
        "-s",
        "fiber.directions=in-plane",
        folder=folder,
    )
    assert done.returncode != 0
    assert 'say fiber.model = "spheroid" or "ellipsoid"' in " ".join(done.stderr.split())
    # as soon as the field is known, before a path is traced
    stored = (folder / "refused/stages").glob("*-*")
    assert [entry.name.partition("-")[0] for entry in stored] == ["field"]
