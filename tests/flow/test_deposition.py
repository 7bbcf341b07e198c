"""The deposition flow: balances, exact parts, independence of how it was found, failures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fibermelt.errors import ConvergenceError
from fibermelt.flow.deposition import FlowSolution, solve_deposition
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.streamlines import NEAR_SINGULARITY, Streamline
from fibermelt.melt import Newtonian
from fibermelt.verify.flow import line_flux

pytestmark = pytest.mark.verification

COARSE = FlowNumerics().coarsened(4.0)


def test_flux_is_the_same_at_every_station(paper_flow: FlowSolution) -> None:
    nozzle, flux = paper_flow.problem.nozzle, paper_flow.problem.flux
    half_inlet, half = nozzle.inlet_width / 2, nozzle.capillary_width / 2
    stations = [
        line_flux(paper_flow, (half, y), (-half, y))
        for y in np.linspace(nozzle.gap * 1.02, nozzle.capillary_entrance * 0.999, 8)
    ]
    for part in np.linspace(0.02, 0.98, 6):
        y = nozzle.capillary_entrance + part * nozzle.taper_length
        x = half + part * (half_inlet - half)
        stations.append(line_flux(paper_flow, (x, y), (-x, y)))
    top = paper_flow.downstream_surface
    for x in np.linspace(3e-3, 19.9e-3, 8):
        height = np.interp(x, top[:, 0], top[:, 1])
        stations.append(line_flux(paper_flow, (x, 0.0), (x, height * (1 - 1e-6))))
    np.testing.assert_allclose(np.abs(stations), flux, rtol=1e-4)


def test_bead_height_is_what_mass_balance_demands(paper_flow: FlowSolution) -> None:
    height = paper_flow.problem.mass_balance_height
    assert paper_flow.bead_height == pytest.approx(height, rel=2e-4)
    assert paper_flow.mass_imbalance < 1e-6


def test_capillary_pressure_drop(paper_flow: FlowSolution) -> None:
    """Far from both ends of the capillary ``dp/dy = 12 mu Q / W^3`` (plane Poiseuille)."""
    problem, field = paper_flow.problem, paper_flow.field
    nozzle = problem.nozzle
    y = nozzle.gap + nozzle.capillary_length * np.array([0.45, 0.6])
    p = field.evaluate(field.pressure, field.locate(np.column_stack([np.full(2, 0.3e-3), y])))
    exact = 12 * problem.melt.viscosity * problem.flux / nozzle.capillary_width**3
    # entrance and exit are felt as exp(-4.2 y/W): 3e-2 of their own size at 0.85 widths
    assert (p[1] - p[0]) / (y[1] - y[0]) == pytest.approx(exact, rel=1e-3)


def test_capillary_flow_is_a_parabola(paper_flow: FlowSolution) -> None:
    problem, field = paper_flow.problem, paper_flow.field
    nozzle = problem.nozzle
    x = np.linspace(-0.49, 0.49, 41) * nozzle.capillary_width
    y = nozzle.gap + 0.52 * nozzle.capillary_length
    place = field.locate(np.column_stack([x, np.full(41, y)]))
    mean = problem.flux / nozzle.capillary_width
    parabola = -1.5 * mean * (1 - (2 * x / nozzle.capillary_width) ** 2)
    v = field.evaluate(field.velocity, place)
    # at 0.9 widths from both ends their disturbance, exp(-4.2 y/W), is at 2 % of its size
    assert np.abs(v[:, 1] - parabola).max() < 5e-3 * mean
    gradient = field.evaluate(field.gradient, place)
    shear = 12 * mean * x / nozzle.capillary_width**2
    # dv/dx is L[1, 0]: fails if transposed
    assert np.abs(gradient[:, 1, 0] - shear).max() < 1e-2 * np.abs(shear).max()
    assert np.abs(gradient[:, 0, 1]).max() < 1e-2 * np.abs(shear).max()


def test_bead_moves_as_a_plug_far_downstream(paper_flow: FlowSolution) -> None:
    field, speed = paper_flow.field, paper_flow.problem.bed_speed
    xy = np.column_stack([np.full(20, 18e-3), np.linspace(0.1e-3, 2.9e-3, 20)])
    place = field.locate(xy)
    # five bead heights behind the nozzle the last of the turn is still felt at 2e-4
    np.testing.assert_allclose(
        field.evaluate(field.velocity, place), np.tile([speed, 0.0], (20, 1)), atol=5e-4 * speed
    )
    scale = paper_flow.problem.melt.viscosity * speed / paper_flow.problem.nozzle.gap
    assert np.abs(field.evaluate(field.pressure, place)).max() < 2e-3 * scale


def test_surfaces_carry_no_flow(paper_flow: FlowSolution) -> None:
    assert paper_flow.kinematic_residual < 1e-4
    psi, flux = paper_flow.field.stream_function, paper_flow.problem.flux
    assert psi.min() == pytest.approx(0.0, abs=1e-5 * flux)
    assert psi.max() == pytest.approx(flux, rel=1e-5)


def test_streamlines_keep_their_stream_function(paper_lines: tuple[Streamline, ...]) -> None:
    assert np.median([line.drift for line in paper_lines]) < 1e-5


def test_streamlines_are_ordered_and_slow_at_the_edges(
    paper_lines: tuple[Streamline, ...],
) -> None:
    transit = np.array([line.history.time[-1] for line in paper_lines])
    middle = int(np.argmin(transit))
    assert 8 <= middle <= 13
    assert np.all(np.diff(transit[: middle + 1]) < 0)
    assert np.all(np.diff(transit[middle:]) > 0)
    assert paper_lines[0].near_singularity
    assert not paper_lines[9].near_singularity
    for line in paper_lines:
        assert np.all(np.diff(line.zone_time) > 0)


def test_distances_from_lips_entrance_corners_and_contact(
    paper_flow: FlowSolution, paper_lines: tuple[Streamline, ...]
) -> None:
    nozzle, contact = paper_flow.problem.nozzle, np.array([paper_flow.contact_point, 0.0])
    right = np.array([[0.5 * nozzle.capillary_width, y] for y in (3e-3, 9e-3)])
    corners = [*right, *(right * [-1, 1]), contact]
    for line in paper_lines:
        place = line.history.position[:, :2]
        away = np.min([np.linalg.norm(place - corner, axis=1) for corner in corners], axis=0)
        assert line.corner_distance == pytest.approx(away, rel=1e-12)
        assert line.near_singularity == (away.min() < NEAR_SINGULARITY * nozzle.capillary_width)
    # The first line comes nearer to the contact than to any part of the nozzle.
    nearest = paper_lines[0].history.position[np.argmin(paper_lines[0].corner_distance), :2]
    assert np.linalg.norm(nearest - contact) < 1e-4


def test_gradient_error_is_stated_where_it_is_large(paper_lines: tuple[Streamline, ...]) -> None:
    """Half a per cent of the largest gradient on most lines, the most near a singular corner."""
    share = np.array(
        [
            line.gradient_error.max() / np.linalg.norm(line.history.gradient, axis=(1, 2)).max()
            for line in paper_lines
        ]
    )
    assert np.median(share) < 1e-2
    flagged = np.array([line.near_singularity for line in paper_lines])
    assert share[flagged].max() == share.max()


def test_path_is_the_integral_of_its_velocity(paper_lines: tuple[Streamline, ...]) -> None:
    history = paper_lines[9].history
    step = np.diff(history.time)[:, None]
    moved = np.cumsum(0.5 * step * (history.velocity[1:] + history.velocity[:-1]), axis=0)
    # the trapezoid's own error on 1500 points
    np.testing.assert_allclose(history.position[1:], history.position[0] + moved, atol=1e-7)


def test_mesh_and_error_estimate(paper_flow: FlowSolution, coarse_flow: FlowSolution) -> None:
    for flow in (paper_flow, coarse_flow):
        assert 0 < flow.error.contact_point < 1e-5
    for name in ("contact_point", "heel", "inlet_pressure"):
        change = abs(getattr(coarse_flow, name) - getattr(paper_flow, name))
        assert change < 5 * getattr(coarse_flow.error, name), name


@pytest.mark.parametrize("change", [{"lip_edge": 1e-4}, {"surface_edge": 0.04}, {"flow_order": 4}])
def test_error_estimate_is_honest(
    paper_flow: FlowSolution, paper_problem: Deposition, change: dict[str, float]
) -> None:
    """Finer in one way at a time, the answer moves by no more than twice the stated error."""
    finer = solve_deposition(paper_problem, replace(FlowNumerics(), **change))
    for name in ("contact_point", "heel", "inlet_pressure"):
        moved = abs(getattr(finer, name) - getattr(paper_flow, name))
        assert moved < 2 * getattr(paper_flow.error, name), name


@pytest.mark.parametrize("guess", [-1e-3, 3e-3, 8e-3])
def test_first_guess_does_not_matter(
    coarse_flow: FlowSolution, paper_problem: Deposition, guess: float
) -> None:
    flow = solve_deposition(paper_problem, replace(COARSE, contact_guess=guess))
    # another way to the answer means another mesh: equal to the mesh's error
    assert abs(flow.contact_point - coarse_flow.contact_point) < coarse_flow.error.contact_point * 2


@pytest.mark.parametrize("outlet", [15e-3, 30e-3])
def test_outlet_length_does_not_matter(coarse_flow: FlowSolution, outlet: float) -> None:
    problem = Deposition(Nozzle(outlet=outlet), Newtonian(817.0))
    flow = solve_deposition(problem, COARSE)
    assert abs(flow.contact_point - coarse_flow.contact_point) < coarse_flow.error.contact_point * 2
    change = abs(flow.inlet_pressure - coarse_flow.inlet_pressure)
    assert change < 2 * coarse_flow.error.inlet_pressure


def test_viscosity_scales_the_pressure_only(coarse_flow: FlowSolution) -> None:
    thick = solve_deposition(Deposition(Nozzle(), Newtonian(8170.0)), COARSE)
    np.testing.assert_array_equal(thick.field.points, coarse_flow.field.points)
    np.testing.assert_array_equal(thick.field.velocity, coarse_flow.field.velocity)
    np.testing.assert_allclose(thick.field.pressure, 10 * coarse_flow.field.pressure, rtol=1e-14)


def test_joint_scaling_of_both_speeds_leaves_the_shape_alone(coarse_flow: FlowSolution) -> None:
    fast = solve_deposition(
        Deposition(Nozzle(), Newtonian(817.0), inlet_speed=48e-3, bed_speed=203.2e-3), COARSE
    )
    np.testing.assert_array_equal(fast.upstream_surface, coarse_flow.upstream_surface)
    np.testing.assert_allclose(fast.field.velocity, 2 * coarse_flow.field.velocity, rtol=1e-14)


@pytest.mark.parametrize(
    ("gap", "words"),
    [
        (2.0e-3, "no steady free surface found for flow.gap = 0.002 m"),
        (2.4e-3, "would wet the nozzle's outer face"),
        (9.0e-3, "lower flow.gap to 0.0081 m or less, lower flow.bed_speed"),
    ],
)
def test_gaps_without_a_bead_are_refused(gap: float, words: str) -> None:
    with pytest.raises(ConvergenceError, match=words.replace(".", r"\.")):
        solve_deposition(Deposition(Nozzle(gap=gap), Newtonian(817.0)), COARSE)


def test_a_melt_drawn_down_too_far_is_refused_with_the_right_advice() -> None:
    problem = Deposition(Nozzle(), Newtonian(817.0), bed_speed=1.0)
    with pytest.raises(ConvergenceError, match=r"9\.84 bead heights.*lower flow\.gap"):
        solve_deposition(problem, COARSE)


def test_a_faster_bed_carries_the_contact_along() -> None:
    contact = [
        solve_deposition(
            Deposition(Nozzle(), Newtonian(817.0), bed_speed=speed), COARSE
        ).contact_point
        for speed in (0.15, 0.18, 0.185)
    ]
    assert np.all(np.diff(contact) > 0)


@pytest.mark.parametrize("gap", [2.55e-3, 2.6e-3, 4.0e-3, 6.0e-3])
def test_other_gaps_converge(gap: float) -> None:
    flow = solve_deposition(Deposition(Nozzle(gap=gap), Newtonian(817.0)), COARSE)
    assert flow.mass_imbalance < 1e-6
    assert flow.kinematic_residual < 1e-3
