"""The bead in space: what is refused before it is solved, balances, exact scalings, limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from round_bead import BEAD_COARSE, BEAD_PROBLEM, DIAMETER

from fibermelt.errors import ConfigError, ConvergenceError
from fibermelt.flow.problem import BeadDeposition, BeadNumerics
from fibermelt.flow.space.bead import BeadSolution, solve_bead
from fibermelt.melt import CarreauYasuda, Newtonian

D, NOZZLE, STANDARD = DIAMETER, BEAD_PROBLEM.nozzle, BEAD_PROBLEM
COARSE = BeadNumerics(**BEAD_COARSE)


@pytest.mark.parametrize(
    ("problem", "said"),
    [
        (
            replace(STANDARD, nozzle=replace(NOZZLE, gap=0.6 * D)),
            r"flow\.gap = 0\.001905 m is 0\.6 diameters: below 0\.75 .* outer face.* raise "
            r"flow\.gap to 0\.002381 m or more",
        ),
        (
            replace(STANDARD, inlet_speed=0.06),
            r"flow\.bed_speed = 0\.1 m/s: .* at 0\.6 of it; .* lower flow\.bed_speed to 0\.075 m/s",
        ),
        (
            replace(STANDARD, nozzle=replace(NOZZLE, outlet=2 * D)),
            r"flow\.outlet = 0\.00635 m is 2 diameters .* raise it to 0\.007938 m or more",
        ),
    ],
)
def test_what_no_formulation_holds_is_refused_before_it_is_solved(
    problem: BeadDeposition, said: str
) -> None:
    with pytest.raises(ConfigError, match=said):
        solve_bead(problem)


def test_numerics_without_a_mesh_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"numerics\.sectors = 10: must be a multiple of four"):
        BeadNumerics(sectors=10)
    with pytest.raises(ConfigError, match=r"numerics\.film = 0\.2: must be at most 0\.05"):
        BeadNumerics(film=0.2)


def test_speed_ratio_is_that_of_the_exit() -> None:
    tapered = replace(NOZZLE, inlet_width=2 * D)
    problem = BeadDeposition(tapered, Newtonian(817.0), inlet_speed=0.02, bed_speed=0.1)
    assert problem.speed_ratio == pytest.approx(0.8)
    assert problem.mass_balance_area == pytest.approx(0.8 * np.pi / 4 * D**2)


@pytest.mark.slow
@pytest.mark.verification
def test_balances(coarse_bead: BeadSolution) -> None:
    assert coarse_bead.mass_imbalance < 3e-3  # 5e-3 of eight sectors, 6e-4 of sixteen
    problem, field = coarse_bead.problem, coarse_bead.field
    # nothing flows through the plane of symmetry, nor the nozzle's wall
    on_plane = np.abs(field.points[:, 2]) < 1e-9
    assert np.abs(field.velocity[on_plane, 2]).max() < 1e-12
    above = field.points[:, 1] > problem.nozzle.gap + 1e-9
    r = np.hypot(field.points[:, 0], field.points[:, 2])
    on_wall = above & (r > 0.4999 * D)
    assert on_wall.any()
    # the inlet's rim is a circle to 1e-5, and the parabola there zero to 1e-4
    assert np.abs(field.velocity[on_wall]).max() < 2e-4 * problem.inlet_speed
    trace = np.trace(field.gradient, axis1=1, axis2=2)
    assert np.abs(trace).max() < 1e-9 * problem.rate_scale
    np.testing.assert_allclose(field.viscosity, 817.0)


@pytest.mark.slow
@pytest.mark.verification
def test_numbers_bracket_those_of_finer_meshes(coarse_bead: BeadSolution) -> None:
    """An independent code's, with its own meshes: +- 0.003 of height and width, 0.01 of others."""
    stress = STANDARD.stress_scale
    for name, unit, value, known in (
        ("bead_height", D, 0.767, 0.003),
        ("bead_width", D, 1.149, 0.003),
        ("widest", D, 1.28, 0.01),
        ("heel", D, -0.510, 0.005),
        ("front", D, 0.03, 0.03),
        ("section_area", D**2, 0.74613, 1e-5),
        ("inlet_pressure", stress, 29.0, 0.1),
    ):
        off = abs(getattr(coarse_bead, name) / unit - value)
        error = getattr(coarse_bead.error, name) / unit
        assert off < error + known, name
        assert error < 0.1 * abs(value) or name == "front", name  # an error that says something


@pytest.mark.slow
@pytest.mark.verification
def test_the_nozzle_has_the_flow_of_a_pipe(coarse_bead: BeadSolution) -> None:
    problem, field = coarse_bead.problem, coarse_bead.field
    top = problem.nozzle.inlet_height
    on_axis = (np.hypot(field.points[:, 0], field.points[:, 2]) < 1e-9) & (
        field.points[:, 1] > top - 0.3 * D
    )
    y, p = field.points[on_axis, 1], field.pressure[on_axis]
    slope = np.polyfit(y, p, 1)[0]
    # the exit is felt as exp(-8.9 y/D), here 1 per cent of it; the mesh is coarse
    assert slope == pytest.approx(32 * 817.0 * problem.inlet_speed / D**2, rel=3e-2)
    at_inlet = on_axis & (field.points[:, 1] > top - 1e-9)
    np.testing.assert_allclose(
        field.velocity[at_inlet], [[0.0, -2 * problem.inlet_speed, 0.0]], atol=1e-3
    )


@pytest.mark.slow
@pytest.mark.verification
def test_a_melt_that_thins(coarse_bead: BeadSolution) -> None:
    law = CarreauYasuda(817.0, 0.5, 0.1)
    thinning = solve_bead(replace(STANDARD, melt=law), replace(COARSE, sectors=8))
    assert thinning.mass_imbalance < 7e-3  # 5.6e-3 of eight sectors
    assert thinning.inlet_pressure < 0.7 * coarse_bead.inlet_pressure
    rate = np.linalg.norm(
        thinning.field.gradient + thinning.field.gradient.transpose(0, 2, 1), axis=(1, 2)
    ) / np.sqrt(2)
    np.testing.assert_allclose(thinning.field.viscosity, law.viscosity_at(rate), rtol=1e-9)


@pytest.mark.slow
@pytest.mark.verification
def test_a_strand_that_leaves_the_bed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton converges to one that peels off; without the first refusal the second sees it."""
    monkeypatch.setattr("fibermelt.flow.space.bead.SLOWEST_EXIT", 0.0)
    with pytest.raises(ConvergenceError, match=r"it has left the bed|rises to y|no steady strand"):
        solve_bead(replace(STANDARD, inlet_speed=0.06), COARSE)
