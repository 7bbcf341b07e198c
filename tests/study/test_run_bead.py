"""A study of a bead in space: refusals, and the chain from the solved bead to page and files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from coarse_runs import Computed, computed
from round_bead import BEAD_COARSE, BEAD_PROBLEM, DIAMETER

from fibermelt.engine.stages import Parameters
from fibermelt.errors import ConfigError
from fibermelt.parts.bead.figures.strand import skin_of
from fibermelt.parts.flow.stages import write_fields
from fibermelt.parts.plane.stages import slot_of
from fibermelt.study.loading import load_study, resolve

if TYPE_CHECKING:
    from fibermelt.flow.space.bead import BeadSolution

SPACE = {"source": "deposition-3d"}
FIBER = {"model": "spheroid", "directions": "equal-area"}

NOZZLE = BEAD_PROBLEM.nozzle
STUDY = f"""
study.parts = ["bead", "voids", "plane"]
melt.material = "paper"
melt.viscosity = "817 Pa s"

[flow]
source = "deposition-3d"
inlet_width = "{NOZZLE.inlet_width!r} m"
inlet_length = "{NOZZLE.inlet_length!r} m"
taper_length = "{NOZZLE.taper_length!r} m"
capillary_width = "{NOZZLE.capillary_width!r} m"
capillary_length = "{NOZZLE.capillary_length!r} m"
gap = "{NOZZLE.gap!r} m"
outlet = "{NOZZLE.outlet!r} m"
inlet_speed = "95 mm/s"
bed_speed = "100 mm/s"

[strand]
{"".join(f"{name} = {value}" + chr(10) for name, value in BEAD_COARSE.items())}
[streamlines]
count = 12
points = 200

[fiber]
model = "spheroid"
directions = "equal-area"
direction_count = 10

[numerics]
isotropic_angles = 20
flow_order = 3
lip_edge = 0.05
contact_edge = 0.1
corner_edge = 0.2
surface_edge = 0.15
bulk_edge = 0.3
"""


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"flow": SPACE}, r'fiber\.model = "confined-ellipse".* the flow is in space'),
        (
            {"flow": SPACE, "fiber": FIBER, "process": {"nozzle_diameter": "3 mm"}},
            r"process\.nozzle_diameter: lends \[flow\] a slot .* say flow\.capillary_width",
        ),
        (
            {"flow": SPACE, "fiber": FIBER, "paths": {"count": 5}},
            r'paths\.count: is not read with flow\.source = "deposition-3d"',
        ),
        (
            {"study": {"parts": ["bead", "plane"]}},
            r'"plane" sets a slot beside a bead in space.* flow\.source = "deposition-3d"',
        ),
        (
            {"flow": SPACE, "fiber": FIBER, "study": {"parts": ["bead", "thinning"]}},
            r'study\.parts: "thinning" is about the deposition flow',
        ),
        ({"strand": {"film": 0.2}}, r"strand\.film"),
    ],
)
def test_what_has_no_answer_in_space_is_refused(tables: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        resolve(tables)


def test_the_shipped_study_is_the_papers_in_a_round_nozzle() -> None:
    bead, paper = (load_study(name).config.values() for name in ("bead", "paper"))
    for key in ("flow.bed_speed", "flow.capillary_width", "fiber.half_length", "melt.material"):
        assert bead[key] == paper[key]
    # the mean speed at the exit of the paper's capillary
    at_exit = paper["flow.inlet_speed"] * paper["flow.inlet_width"] / paper["flow.capillary_width"]
    assert bead["flow.inlet_speed"] == pytest.approx(at_exit)


def test_the_slot_has_the_speed_and_the_wall_rate_of_the_pipe() -> None:
    values = load_study("bead").config.values()
    slot = slot_of(Parameters(values))
    width, speed = slot["flow.capillary_width"], slot["flow.inlet_speed"]
    assert speed == values["flow.inlet_speed"]
    pipe = 8.0 * speed / values["flow.capillary_width"]
    assert 6.0 * speed / width == pytest.approx(pipe)
    assert slot["flow.source"] == "deposition"
    # a tapered one: the speed at the exit is what is kept
    tapered = slot_of(Parameters({**values, "flow.inlet_width": 2 * values["flow.inlet_width"]}))
    at_exit = tapered["flow.inlet_speed"] * tapered["flow.inlet_width"] / width
    assert at_exit == pytest.approx(4.0 * values["flow.inlet_speed"])


@pytest.fixture(scope="module")
def run(coarse_bead: BeadSolution, tmp_path_factory: pytest.TempPathFactory) -> Computed:
    folder = tmp_path_factory.mktemp("bead")
    (folder / "round.toml").write_text(STUDY)

    def solved(problem: object, numerics: object, progress: object = None) -> BeadSolution:
        assert problem == coarse_bead.problem
        return coarse_bead

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fibermelt.flow.space.bead.solve_bead", solved)
        return computed(folder / "round.toml", folder / "out")


@pytest.mark.slow
@pytest.mark.end_to_end
def test_the_summary_has_the_bead(run: Computed, coarse_bead: BeadSolution) -> None:
    flow = run.summary["flow"]
    for name in ("bead_height", "bead_width", "widest", "heel", "front", "wet_width", "film"):
        assert flow[name] == getattr(coarse_bead, name)
    for name in ("bead_height", "section_area", "inlet_pressure", "front", "wet_width"):
        assert flow["error_estimate"][name] == getattr(coarse_bead.error, name)
    assert "contact_point" not in flow
    assert [path["end"] for path in run.summary["paths"]] == ["outlet"] * 12
    assert run.results["zone"].to_numpy().tolist() == [2, 3]
    # where a path began and where it ended
    radius = run.results["start_radius"].to_numpy()
    x, z = (run.results[name].to_numpy()[:, 0] for name in "xz")
    assert radius == pytest.approx(2.0 * np.hypot(x, z) / DIAMETER)
    assert np.all(run.results["x"].to_numpy()[:, -1] > 0.999 * NOZZLE.outlet)


@pytest.mark.slow
@pytest.mark.end_to_end
def test_the_plane_has_two_thirds_of_the_pressure_in_the_nozzle(run: Computed) -> None:
    """At equal wall stress: ``2 tau/W`` against ``4 tau/d``; the gap takes a part of either."""
    told = run.summary["plane"]
    assert told["slot"] == pytest.approx(0.75 * DIAMETER)
    assert told["inlet_pressure"]["ratio"] == pytest.approx(2.0 / 3.0, abs=0.06)
    assert told["bead_height"]["plane"] == pytest.approx(0.95 * told["slot"], rel=1e-4)
    for name in ("lowest_pressure", "exponent"):
        assert told[name]["ratio"] == pytest.approx(1.0, abs=0.6), name


@pytest.mark.slow
@pytest.mark.end_to_end
def test_what_is_drawn_and_written(run: Computed, tmp_path: Path) -> None:
    drawn = run.drawn()
    assert {"strand", "cross-section", "paths"} <= drawn
    assert not {"domain", "flow", "streamlines"} & drawn  # of the plane
    write_fields(run.results, tmp_path)
    text = (tmp_path / "flow.vtu").read_text()
    assert f'NumberOfCells="{run.results.sizes["strand_cell"]}"' in text
    # the skin is closed but for nothing: half of its faces are each other's mirror images
    skin = skin_of(run.results)
    corner = skin.points[skin.faces]
    area = 0.5 * np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    assert np.abs(area @ skin.normal) == pytest.approx(0.0, abs=1e-9 * area.sum())
    volume = float(np.einsum("m,mi,mi->", area, skin.normal, corner.mean(axis=1)) / 3.0)
    cells = 1e3 * run.results["field_points"].to_numpy()[run.results["field_cells"].to_numpy()]
    whole = 2.0 * np.abs(np.linalg.det(cells[:, 1:] - cells[:, :1])).sum() / 6.0
    assert volume == pytest.approx(whole, rel=1e-9)
