"""What a deposition problem refuses, and what follows from its numbers."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from square import square_field

from fibermelt.errors import ConfigError
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.spacing import graded_spacing, resample
from fibermelt.flow.vtu import write_vtu
from fibermelt.melt import Newtonian


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gap": 0.0}, "flow.gap = 0 m: must be above 0 m"),
        ({"gap": float("nan")}, "flow.gap = nan"),
        ({"inlet_width": 3e-3}, "flow.inlet_width = 0.003 m is narrower than"),
        ({"outlet": 1e-3}, "flow.outlet = 0.001 m is too close"),
    ],
)
def test_nozzles_that_cannot_be_built(change: dict[str, float], words: str) -> None:
    with pytest.raises(ConfigError, match=words.replace(".", r"\.")):
        Nozzle(**change)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"flow_order": 1}, "numerics.flow_order = 1: must be at least 2"),
        ({"lip_edge": 2.0}, "numerics.lip_edge = 2: must be at most 0.5"),
        ({"edge_growth": 0.0}, "numerics.edge_growth = 0: must be at least 0.05"),
        ({"flow_tolerance": 1.0}, "numerics.flow_tolerance = 1: must be at most 0.001"),
    ],
)
def test_numerics_that_no_mesh_can_follow(change: dict[str, float], words: str) -> None:
    with pytest.raises(ConfigError, match=words.replace(".", r"\.")):
        FlowNumerics(**change)


def test_mass_balance_makes_the_bead_three_millimetres_high() -> None:
    problem = Deposition(Nozzle(), Newtonian(817.0))
    assert problem.mass_balance_height == pytest.approx(3.0e-3, rel=1e-15)


def test_coarsening_keeps_everything_but_the_edges() -> None:
    fine = FlowNumerics(flow_order=4, edge_growth=0.2)
    coarse = fine.coarsened(2.0)
    kept = coarse.flow_order, coarse.edge_growth, coarse.flow_tolerance
    assert kept == (4, 0.2, fine.flow_tolerance)
    assert coarse.lip_edge == 2 * fine.lip_edge
    assert fine.coarsened(1e3).surface_edge == 0.5
    # the mesher's second try shortens all edges, also those that are as short as they may be
    assert replace(fine, lip_edge=1e-6).coarsened(0.65).lip_edge == 1e-6


def test_spacing_keeps_its_ends_and_its_growth() -> None:
    nodes = graded_spacing(10.0, 1.0, 0.3, start=0.01, end=0.1)
    steps = np.diff(nodes)
    assert nodes[0] == 0
    assert nodes[-1] == pytest.approx(10.0)
    # all steps are stretched by less than one step to end exactly at the end
    assert 0.005 < steps[0] <= 0.012
    assert steps.max() <= 1.0
    assert np.max(steps[1:] / steps[:-1]) < 1.4


def test_resampling_stays_on_the_curve() -> None:
    angle = np.linspace(0, np.pi / 2, 60)
    arc = np.column_stack([np.cos(angle), np.sin(angle)])
    points = resample(arc, 0.1, 0.3, 0.01, 0.02)
    np.testing.assert_array_equal(points[[0, -1]], arc[[0, -1]])
    # a cubic spline through 60 points of a quarter circle misses it by h^4
    np.testing.assert_allclose(np.hypot(*points.T), 1.0, atol=1e-6)


def test_vtu_gives_back_what_was_written(tmp_path: Path) -> None:
    field = square_field(3)
    path = tmp_path / "flow.vtu"
    write_vtu(field, path)
    root = ET.parse(path).getroot()
    piece = root.find("UnstructuredGrid/Piece")
    assert piece is not None
    assert int(piece.get("NumberOfPoints", 0)) == len(field.points)
    arrays = {a.get("Name"): a for a in root.iter("DataArray")}

    def read(name: str, kind: type) -> np.ndarray:
        import base64  # noqa: PLC0415  the format's own inverse, spelled out here

        raw = base64.b64decode(arrays[name].text or "")
        assert int(np.frombuffer(raw[:8], np.uint64)[0]) == len(raw) - 8
        return np.frombuffer(raw[8:], kind)

    np.testing.assert_array_equal(read("pressure", np.float64), field.pressure)
    np.testing.assert_array_equal(
        read("velocity", np.float64).reshape(-1, 3)[:, :2], field.velocity
    )
    gradient = read("velocity_gradient", np.float64).reshape(-1, 3, 3)
    np.testing.assert_array_equal(gradient[:, :2, :2], field.gradient)
    assert gradient[0, 0, 1] == 1.0  # du/dy of a simple shear: fails if transposed
    np.testing.assert_array_equal(read("connectivity", np.int64), field.cells.reshape(-1))
    assert set(read("types", np.uint8)) == {69}


@pytest.mark.parametrize("guess", [math.nan, math.inf])
def test_a_contact_that_is_no_place(guess: float) -> None:
    with pytest.raises(ConfigError, match=r"numerics\.contact_guess = (nan|inf) m: must be finite"):
        FlowNumerics(contact_guess=guess)
