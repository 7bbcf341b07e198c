"""The chain by the paper's own algorithm, beside superposition over the same streamlines."""

import re

import numpy as np
import pytest
from coarse_runs import COARSE, computed, here

pytestmark = pytest.mark.end_to_end

SMALL = [
    "streamlines.count=2",
    "streamlines.points=120",
    'fiber.initial_angles=["-60 deg", "20 deg"]',
    "numerics.cell_order=3",
]
PATHS = ("superposition", "newton")

RUNGE_KUTTA = 2e-4
"""Angle [rad] that 119 Runge-Kutta steps may lose on a streamline of the coarse flow, the sharp
turns at the nozzle's exit among them: three times what they do lose."""

NODES = 5e-3
"""The surface points miss an extreme by the tip's curvature times their spacing squared; share."""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What both paths come to, through one results folder."""
    out = tmp_path_factory.mktemp("newton") / "out"
    return {path: computed(COARSE, out, *SMALL, f"fiber.path={path}") for path in PATHS}


@pytest.mark.parametrize("path", PATHS)
def test_figures_can_be_drawn(found, path):
    assert len(found[path].drawn()) >= 8


def test_only_the_motion_is_computed_again(found):
    reused = [line.split(":")[0] for line in found["newton"].told if ": reused" in line]
    assert reused == ["flow", "streamlines", "cell"]


def test_both_paths_have_the_same_variables(found):
    ours, papers = (found[path].results for path in PATHS)
    assert list(papers) == list(ours)
    for name in ours:
        assert papers[name].dims == ours[name].dims
        assert papers[name].shape == ours[name].shape
        assert papers[name].dtype == ours[name].dtype
        assert papers[name].attrs == ours[name].attrs


def test_both_paths_have_the_same_summary_keys(found):
    ours, papers = (found[path].summary for path in PATHS)
    assert list(papers) == list(ours)
    for part in ("streamlines", "extremes", "orientation"):
        assert [list(item) for item in papers[part]] == [list(item) for item in ours[part]]
    assert papers["cell"] == ours["cell"]


def test_the_trajectories_agree_to_the_error_of_runge_kutta(found):
    ours, papers = (found[path].results["angle"].to_numpy() for path in PATHS)
    assert np.array_equal(papers[..., 0], ours[..., 0])
    worst = np.abs(papers - ours).max()
    # not the same numbers: they come by another way
    assert 1e-12 < worst < RUNGE_KUTTA


def test_the_pressure_at_the_same_state_is_the_same(found):
    """From the angles of the paper's path, over its own surface points, by superposition."""
    results = found["newton"].results
    L = results["gradient"].to_numpy()[:, None]
    stretch, shear = L[..., 0, 0], (L[..., 0, 1] + L[..., 1, 0]) / 2
    double = 2 * results["angle"].to_numpy()
    along = stretch * np.cos(double) + shear * np.sin(double)
    across = shear * np.cos(double) - stretch * np.sin(double)
    modes = np.stack([along, across], axis=-1)
    mu = 817.0
    surface = mu * modes @ results["surface_basis"].to_numpy().T
    size = mu * np.hypot(stretch, shear)
    # solver precision: both are the same linear algebra on the same elements
    for name, exact in (("lowest", surface.min(axis=-1)), ("highest", surface.max(axis=-1))):
        assert np.max(np.abs(results[name].to_numpy() - exact) / size) < 1e-8


def test_extremes_agree(found):
    ours, papers = (found[path].results for path in PATHS)
    scale = np.abs(ours["extreme"]).max(dim=("initial_angle",))
    assert float((np.abs(papers["extreme"] - ours["extreme"]) / scale).max()) < NODES
    assert float(np.abs(papers["zone_angle"] - ours["zone_angle"]).max()) < RUNGE_KUTTA


def test_what_is_over_every_orientation_is_the_same(found):
    ours, papers = (found[path].results for path in PATHS)
    for name in ("bound_lowest", "bound_highest", "quantile_lowest", "extreme_quantiles"):
        assert np.array_equal(papers[name], ours[name])


def test_it_says_what_it_costs_and_how_far_it_is(found):
    lines = [x for x in found["newton"].told if x.startswith("motion: ")][1:]
    # 8 solves a step, 2 angles, 2 streamlines of 120 points
    cost = r"motion: the paper's algorithm, 2 angles on 2 streamlines: up to 3840 solves of \d+ "
    assert re.match(cost + r'unknowns, .*; fiber.path = "superposition" takes seconds', lines[0])
    assert re.fullmatch(r"motion: streamline 1 of 2 done, .+ to go", lines[1])
    assert lines[2] == "motion: streamline 2 of 2 done"


@pytest.mark.parametrize("model", ["ellipse", "spheroid"])
def test_without_a_cell_it_is_refused(tmp_path, model):
    sets = ["-s", "fiber.path=newton", "-s", f"fiber.model={model}"]
    done = here("validate", COARSE, *sets, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        'error: fiber.path = "newton": the paper\'s algorithm works on a cell, which fiber.model '
        f'= "{model}" has not: take fiber.model = "confined-ellipse", or fiber.path = '
        '"superposition"\n'
    )


def test_out_of_the_plane_it_is_refused(tmp_path):
    sets = ["-s", "fiber.path=newton", "-s", "fiber.directions=equal-area"]
    done = here("validate", COARSE, *sets, folder=tmp_path)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert 'fiber.directions = "equal-area"' in done.stderr
