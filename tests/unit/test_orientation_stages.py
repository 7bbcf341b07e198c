"""From content to the cell, and tensors along streamlines: the stages do what direct calls do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from suspended_fibers import CELLS, interacting, oriented, parameters, quiet, stalled

from fibermelt.errors import ConfigError
from fibermelt.fiber.shape import jeffery_factor
from fibermelt.fiber.stall_data import StallCurve
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.evolve import follow_orientation
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.fokker_planck import follow_distribution, steady_distribution
from fibermelt.orientation.interaction import bay, paper_domain_size, paper_preferred_angle
from fibermelt.orientation.models import FolgarTucker
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import isotropic
from fibermelt.study.bead.fiber import cell_stage
from fibermelt.study.orientation.stages import (
    DISTRIBUTION,
    content_stage,
    folgar_tucker,
    orientation_stage,
    preferred_angle,
    stall_stage,
    stored_curve,
)
from fibermelt.study.stages import Parameters
from fibermelt.study.variables import labelled

XI = jeffery_factor(6.0)
C_I = bay(0.084, 6.0)

PAPER_DOMAIN, PAPER_WITHIN = 4.08, 0.1
"""The paper's ``M`` for its fiber content and how near it is asked to be."""

SAME = 1e-13
"""The same numbers by the same steps, in batches of another size: rounding."""

STATE = 1e-10
"""Steady states to a residual of 1e-12 from other starts, over the slowest rate of decay."""


def content(**changes: Any) -> xr.Dataset:
    return content_stage(parameters(**changes), {"stall": stalled()}, quiet)


def tiny(rate: float = 2.0) -> xr.Dataset:
    """Two lines of nine points: simple shear, and shear that turns into planar elongation."""
    time = np.broadcast_to(np.linspace(0.0, 3.0, 9), (2, 9))
    shear, planar = (FLOWS[name][:2, :2] for name in ("simple-shear", "planar"))
    part = np.linspace(0.0, 1.0, 9)[:, None, None]
    gradient = rate * np.stack([np.broadcast_to(shear, (9, 2, 2)), shear + part * planar])
    return labelled(
        {
            "streamline": np.array([3, 7]),
            "flux_fraction": np.array([0.4, 0.8]),
            "time": time,
            "gradient": gradient,
        }
    )


@pytest.mark.parametrize(("convention", "factor"), [("standard", 1.0), ("paper", np.sqrt(2.0))])
@pytest.mark.parametrize("start", ["isotropic", "inlet"])
def test_tensors_along_streamlines_are_those_of_direct_calls(
    start: str, convention: str, factor: float
) -> None:
    lines = tiny()
    found = orientation_stage(
        parameters(start=start, convention=convention), {"streamlines": lines}, quiet
    )
    time, gradient = lines["time"].to_numpy(), lines["gradient"].to_numpy()
    model, closure = FolgarTucker(XI, factor * C_I), CLOSURES["ORE"]
    first = [steady_state(model, L, closure).a for L in gradient[:, 0]]
    a0 = np.broadcast_to(isotropic(), (2, 3, 3)) if start == "isotropic" else np.stack(first)
    direct = follow_orientation(model, closure, (time, gradient), a0)
    np.testing.assert_allclose(found["orientation"].to_numpy(), direct.a, rtol=0, atol=STATE)
    assert np.array_equal(found["orientation"][:, 0].to_numpy(), a0) or start == "inlet"
    assert float(found["orientation_interaction"]) == pytest.approx(C_I, rel=SAME)
    assert found["orientation_closure"].item() == "ORE"
    assert found["orientation_convention"].item() == convention
    if start == "inlet":  # the first line's flow does not change: nor does its tensor
        np.testing.assert_allclose(found["orientation"][0], np.broadcast_to(first[0], (9, 3, 3)))


def test_the_closure_is_judged_along_the_papers_streamline() -> None:
    lines = tiny()
    found = orientation_stage(parameters(), {"streamlines": lines}, quiet)
    assert int(found["closure_streamline"]) == 3  # 0.4 is nearest to 9.5/22
    rate = 2.0  # of the simple shear, sqrt(2 D:D)
    shear = np.broadcast_to(rate * FLOWS["simple-shear"], (9, 3, 3))
    time = lines["time"][0].to_numpy()
    exact = follow_distribution(time, shear, XI, C_I * rate).distribution.second()
    np.testing.assert_allclose(found["closure_exact"].to_numpy(), exact, rtol=0, atol=SAME)
    error = np.abs(found["orientation"][0].to_numpy() - exact).max(axis=(1, 2))
    np.testing.assert_allclose(found["closure_error"].to_numpy(), error, rtol=0, atol=SAME)
    assert 1e-3 < error.max() < 0.05  # a closure is neither exact nor useless


def test_a_coefficient_stands_in_the_place_of_the_law() -> None:
    assert float(content(coefficient=0.02)["interaction_coefficient"]) == 0.02
    assert float(content(law="phan-thien")["interaction_coefficient"]) == pytest.approx(
        0.03 * -np.expm1(-0.224 * 0.504), rel=SAME
    )


def test_the_stored_curve_is_the_curve() -> None:
    stored = stored_curve(stalled())
    size, factor = np.array(CELLS).T
    curve = StallCurve(6.0, size, factor, 1e-3)
    at = np.linspace(2.2, 5.0, 7)
    assert np.array_equal(stored.stall_angle(at), curve.stall_angle(at))
    assert stored.largest_stalling_domain == curve.largest_stalling_domain
    assert (stored.fiber_aspect_ratio, stored.error) == (6.0, 1e-3)


def test_the_papers_content_gives_the_papers_cell_in_its_convention() -> None:
    paper, standard = (content(convention=name) for name in ("paper", "standard"))
    for found in (paper, standard):
        assert float(found["interaction_coefficient"]) == pytest.approx(C_I, rel=SAME)
        assert found["content_regime"].item() == "semi-dilute"
    size = float(paper["content_domain_size"])
    assert size == pytest.approx(PAPER_DOMAIN, abs=PAPER_WITHIN)
    assert float(paper["preferred_angle"]) == pytest.approx(0.1261, abs=1e-4)
    assert float(standard["preferred_angle"]) == pytest.approx(0.0967, abs=1e-4)
    assert float(standard["content_domain_size"]) > size + 0.3  # less interaction, a larger cell
    curve = stored_curve(stalled())
    assert float(curve.stall_angle(size)) == pytest.approx(float(paper["preferred_angle"]))


def test_the_distribution_needs_no_closure() -> None:
    model = folgar_tucker(6.0, 0.0128, "standard")
    a = steady_distribution(FLOWS["simple-shear"], XI, 0.0128).second()
    angle = 0.5 * np.arctan2(2 * a[0, 1], a[0, 0] - a[1, 1])
    assert preferred_angle(model, DISTRIBUTION) == pytest.approx(angle, rel=1e-10)


def test_a_cell_as_large_as_the_content_says() -> None:
    given = {
        "fiber.half_length": 42e-6,
        "fiber.aspect_ratio": 6.0,
        "fiber.model": "confined-ellipse",
        "fiber.domain_size": "from-content",
        "fiber.pressure_reference": "mean",
        "numerics.cell_mesh": "graded",
        "numerics.cell_order": 3,
    }
    found = content(convention="paper")
    cell = cell_stage(Parameters(given), {"content": found}, quiet)
    assert float(cell["domain_size"]) == float(found["content_domain_size"])
    # B of an independent cell: it stalls where the suspension lies, to the curve of few cells
    assert float(cell["stall_angle"]) == pytest.approx(float(found["preferred_angle"]), abs=2e-3)


def test_a_circle_stalls_nowhere() -> None:
    with pytest.raises(ConfigError, match=r"fiber.aspect_ratio = 1: must be above 1; a circle"):
        stall_stage(Parameters({"fiber.aspect_ratio": 1.0}), {}, quiet)


def test_content_that_no_cell_stalls() -> None:
    with pytest.raises(ConfigError, match=r"no cell stalls a fiber of r_e = 6 there.*up to 0\.26"):
        content(coefficient=0.2)


def test_curves_stand_beside_the_paper_s() -> None:
    found = interacting()
    interaction = found["interaction"].to_numpy()
    ore = found["interaction_angle"].sel(closure="ORE")
    model = FolgarTucker(XI, float(np.sqrt(2.0) * interaction[4]))
    direct = steady_state(model, FLOWS["simple-shear"], CLOSURES["ORE"]).angle
    assert float(ore.sel(convention="paper")[4]) == pytest.approx(direct, rel=STATE)
    apart = np.abs(ore.sel(convention="paper") - paper_preferred_angle(interaction)).max()
    assert float(found["interaction_angle_difference"].sel(convention="paper")) == apart
    sizes = found["interaction_domain_size"].sel(convention="standard").to_numpy()
    apart = np.nanmax(np.abs(sizes - paper_domain_size(interaction)))
    assert float(found["interaction_domain_size_difference"][0]) == apart
    # from across the flow, ever slower, to the stall angle
    angle, spin = (found[f"stalling_{name}"].to_numpy() for name in ("angle", "spin"))
    assert np.all(np.abs(angle[:, 0] - 0.5 * np.pi) < SAME)
    assert np.all(np.diff(angle, axis=1) < 0.0)
    rest = stored_curve(stalled()).stall_angle(found["stalling_domain_size"].to_numpy())
    assert angle[0, -1] == pytest.approx(rest[0], abs=1e-3)
    assert np.all(spin[0, -1] > -1e-3)


def test_isotropy_at_the_inlet_of_every_line() -> None:
    found = oriented(4, points=30)
    np.testing.assert_array_equal(
        found["orientation"][:, 0], np.broadcast_to(isotropic(), (4, 3, 3))
    )
