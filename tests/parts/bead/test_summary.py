import json
import math
from pathlib import Path

import numpy as np
import pytest
from drawn_bead import made_up
from stored_bead import stored_results

from fibermelt.engine.parts import in_words
from fibermelt.engine.quantities import labelled
from fibermelt.parts.bead.summary import bead_in_words, summarize_bead
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.study.quantities import QUANTITIES


def told(summary):
    return "\n".join(bead_in_words(summary))


def results(zone_angle=(0.1, 0.2, 0.3), stall_angle=0.129):
    """One streamline, three fibers: numbers that are easily followed through."""
    # (streamline, initial_angle, location, kind)
    extreme = np.array([-1.0, -2.0, -6.0])[None, :, None, None] * np.array([[1, -1], [2, -2]])
    flow = ("bead_height", "inlet_pressure", "contact_point", "heel", "mass_imbalance")
    return labelled(
        {
            **dict.fromkeys(flow, 1e-3),
            "kinematic_residual": 1e-9,
            **dict.fromkeys(("newton_steps", "unknowns", "elements"), 7),
            "streamline": [1],
            "time": [[0.0, 0.7]],
            "x": [[0.0, 1.0]],
            "y": [[0.0, 0.0]],
            "gradient": np.array([[[[0.0, 1.0], [0.0, 0.0]], [[0.0, 3.0], [0.0, 0.0]]]]),
            "path_end": ["outlet"],
            "path_consistency": [1e-3],
            "path_notes": [""],
            "shear_rate": [[1.0, 3.0]],
            "viscosity": [[817.0, 817.0]],
            "stream_function_drift": [1e-6],
            "near_singularity": np.array([1], dtype=np.int8),
            **dict.fromkeys(("aspect_ratio", "domain_size", "shape_factor", "tip_pressure"), 2.0),
            "stall_angle": stall_angle,
            "shape_factor_error": 1e-7,
            "tip_pressure_error": 1e-5,
            "cell_unknowns": 9,
            "location": [1, 2],
            "kind": ["min", "max"],
            "zone": [1, 2, 3],
            "quantile": [0.05, 0.5, 0.95],
            "extreme": extreme,
            "extreme_x": np.broadcast_to(
                np.array([1.0, 2.0, 3.0])[None, :, None, None], extreme.shape
            ),
            "extreme_y": np.ones(extreme.shape),
            "extreme_error": 0.1 * np.abs(extreme),
            "extreme_bounds": np.zeros((1, 2, 2, 2)),
            "extreme_quantiles": np.zeros((1, 2, 2, 3)),
            "zone_angle": np.array(zone_angle)[None, :, None] * np.ones((1, 3, 3)),
        },
        QUANTITIES,
    )


def test_statistics_run_over_the_initial_angles():
    summary = summarize_bead(results())
    below = next(e for e in summary["extremes"] if (e["location"], e["kind"]) == (2, "min"))
    assert (below["mean"], below["median"]) == (-6.0, -4.0)
    assert (below["lowest"], below["highest"]) == (-12.0, -2.0)
    assert (below["x"], below["y"]) == (2.0, 1.0)


def test_the_cost_of_streamlines_counts_as_flow():
    headings = {stage.name: stage.heading for stage in CHAIN.stages}
    assert headings["streamlines"] == headings["flow"] == "flow"
    assert headings["motion"] == "motion"


def test_the_summary_is_json():
    summary = summarize_bead(results())
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    assert summary["streamlines"][0]["near_singularity"] is True


def test_a_path_tells_how_far_it_can_be_trusted():
    (path,) = summarize_bead(results())["paths"]
    assert path == {
        "index": 1,
        "transit_time": 0.7,
        "gradient_error": None,
        "divergence": None,
        "consistency": 1e-3,
        "fiber_scale": pytest.approx(84e-6 * 2.0 / 3.0),  # |dL/dx| = 2 of at most 3
        "end": "outlet",
        "told": [],
    }


def test_a_long_fiber_is_told_where_no_corner_is():
    summary = paper_like([1.0, 1.0, 1.0], {1})
    for path, scale in zip(summary["paths"], (0.9, 0.25, 0.05), strict=True):
        path["fiber_scale"] = scale
    text = told(summary)
    assert "0.25 of that over which the gradient changes on streamline 2; above 0.1 on 2:" in text


def test_a_fiber_that_tumbles_has_no_stall_angle():
    summary = summarize_bead(results(stall_angle=math.nan))
    assert summary["cell"]["stall_angle"] is None


def test_orientation_of_angles_that_agree():
    found = summarize_bead(results())["orientation"][0]
    assert found["mean"] == pytest.approx(0.2, abs=1e-15)
    assert found["lowest"] == pytest.approx(0.1, abs=1e-15)
    assert found["highest"] == pytest.approx(0.3, abs=1e-15)


def test_a_fiber_has_no_head():
    """Fibers that lie across the stream, at 85, 90 and -85 degrees, are ten degrees apart."""
    across = [math.radians(angle) for angle in (85, 90, -85)]
    found = summarize_bead(results(zone_angle=across))["orientation"][0]
    assert math.degrees(found["highest"] - found["lowest"]) == pytest.approx(10, abs=1e-9)
    assert abs(math.degrees(found["mean"])) == pytest.approx(90, abs=1e-9)


def test_in_words_says_where_to_look(tmp_path):
    summary = {**summarize_bead(results()), "cost": {"flow": 12.0, "total": 20.0}}
    text = in_words(summary, CHAIN, load_study("paper", ['study.parts=["bead"]']), tmp_path)
    assert f"results         {tmp_path}" in text
    assert "cost            flow 12.0 s, this run 20.0 s" in text
    assert "bead height     1.000 mm" in text
    assert "stalls at 7.39 deg" in text
    assert "lowest in the swell" not in text
    assert "every streamline passes a sharp corner" in text


def paper_like(lowest, flagged, felt=None):
    """A summary of one streamline for each of some lowest pressures [MPa], some flagged."""
    summary = summarize_bead(results())
    line, extreme = summary["streamlines"][0], summary["extremes"]
    summary["streamlines"] = [
        {**line, "index": k, "near_singularity": k in flagged} for k in range(1, len(lowest) + 1)
    ]
    summary["left_out"] = {
        "streamlines": sorted(flagged),
        "share": len(flagged) / len(lowest),
        "felt_lowest": felt,
    }
    summary["paths"] = [{**summary["paths"][0], "index": k + 1} for k in range(len(lowest))]
    summary["extremes"] = [
        {**one, "streamline": k, "lowest": -1e6 * value}
        for k, value in enumerate(lowest, 1)
        for one in extreme
    ]
    return summary


def test_streamlines_past_a_singular_corner_do_not_count():
    text = told(paper_like([9.0, 2.0, 3.0, 8.0], {1, 4}))
    assert text.count("3.00 MPa below the melt's own pressure, on streamline 3") == 2
    assert "streamlines 1, 4, 50 % of the flux: they pass a sharp corner" in text
    assert "no fiber there" not in text


def test_what_is_left_out_is_told_with_its_share_and_what_is_felt_there():
    """The lowest that is felt on flagged streamlines; none of a flow without known corners."""
    bead = made_up(count=22)
    flagged = bead["near_singularity"].to_numpy() > 0
    found = summarize_bead(stored_results(count=22))["left_out"]
    assert found["streamlines"] == bead["streamline"].to_numpy()[flagged].tolist() == [1, 22]
    assert found["share"] == pytest.approx(2 / 22)
    assert found["felt_lowest"] == float(bead["felt_lowest"].to_numpy()[flagged].min())
    assert summarize_bead(stored_results(count=22).drop_vars("felt_lowest"))["left_out"] == {
        **found,
        "felt_lowest": None,
    }
    text = told(paper_like([9.0, 2.0, 3.0], {1}, felt=-1.5e6))
    assert "streamline 1, 33.3 % of the flux: it passes a sharp corner" in text
    assert "no fiber there comes more than 1.50 MPa below the melt's own" in text


def test_nothing_is_said_of_corners_that_none_passes():
    text = told(paper_like([9.0, 2.0], set()))
    assert text.count("9.00 MPa below") == 2
    assert "left out" not in text


def test_many_flagged_streamlines_fit_on_a_line():
    text = told(paper_like([1.0] * 500, set(range(2, 500))))
    assert "streamlines 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, ..., 99.6 % of the flux" in text
    assert "it passes a sharp corner" in told(paper_like([1.0, 1.0], {2}))


def test_the_results_folder_is_told_on_one_line():
    summary = {**paper_like([1.0], set()), "cost": {}}
    study = load_study("paper", ['study.parts=["bead"]'])
    assert r"results         a\nb" in in_words(summary, CHAIN, study, Path("a\nb"))


def test_a_circle_has_no_sign():
    """Its shape factor is zero but for a rounding of either sign."""
    summary = summarize_bead(results(stall_angle=math.nan))
    summary["cell"]["shape_factor"] = -6e-10
    assert "B = 0.0000: in simple shear it tumbles" in "\n".join(bead_in_words(summary))
