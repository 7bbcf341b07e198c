"""The confined cell against a series solution, against itself and against what is known.

The series (`fibermelt.verify.series`) is a second path that shares nothing with the elements.
"""

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import CellNumerics, CellSolution, Ellipse, solve_cell
from fibermelt.verify.series import SeriesCell

pytestmark = pytest.mark.verification

SHAPE_FACTOR = 1e-6  # absolute, asked of the default settings
TIP_PRESSURE = 1e-4  # relative, asked of the default settings


@pytest.fixture(scope="module")
def papers_cell() -> CellSolution:
    return solve_cell(Ellipse(42e-6, 6.0), 4.0)


@pytest.mark.parametrize(("ratio", "domain"), [(6.0, 4.0), (6.0, 3.0), (2.0, 2.8), (10.0, 12.0)])
def test_default_settings_against_the_series(ratio: float, domain: float) -> None:
    series = SeriesCell(ratio, domain)
    assert series.misfit < 1e-8  # no slip on both walls, so the series is good to that
    cell = solve_cell(Ellipse(42e-6, ratio), domain)
    exact = series.basis(cell.response.surface)
    largest = np.max(np.hypot(*exact.T))
    error_b = abs(cell.shape_factor - series.shape_factor)
    error_p = np.max(np.abs(cell.response.basis - exact)) / largest
    error_tip = abs(cell.tip_pressure / (0.5 * largest) - 1.0)
    assert error_b < SHAPE_FACTOR
    assert error_tip < TIP_PRESSURE
    assert error_p < TIP_PRESSURE
    estimate = cell.error_estimate
    assert estimate is not None
    # an estimate by the next order sees all but the next order's own error, here a third at most;
    # below, it must not cry wolf; 1e-8 is what the series itself leaves open
    for error, guess in (
        (error_b, estimate.shape_factor),
        (error_p, estimate.surface_pressure),
        (error_tip, estimate.tip_pressure),
    ):
        assert error <= 1.5 * guess + 1e-8
        assert guess <= 1.5 * error + 1e-8


@pytest.mark.parametrize(("domain", "angle"), [(3.0, 0.200), (4.0, 0.129), (5.0, 0.054)])
def test_stall_angles_of_figure_14c(domain: float, angle: float) -> None:
    cell = solve_cell(Ellipse(42e-6, 6.0), domain, CellNumerics(estimate=False))
    assert cell.stall_angle == pytest.approx(angle, abs=5e-4)  # known to three decimals


def test_tip_pressure_of_figure_9(papers_cell: CellSolution) -> None:
    assert papers_cell.tip_pressure == pytest.approx(9.84, abs=0.005)  # known to two decimals
    assert 817.0 * papers_cell.tip_pressure == pytest.approx(8000.0, rel=0.01)  # "about 8 kPa"
    assert papers_cell.response.tip[0] == pytest.approx(-2.0 * papers_cell.tip_pressure)


def test_refinement_changes_nothing_that_matters(papers_cell: CellSolution) -> None:
    fine = solve_cell(
        Ellipse(42e-6, 6.0),
        4.0,
        CellNumerics(order=9, angular_spacing=0.5, radial_spacing=0.5, estimate=False),
    )
    assert papers_cell.shape_factor == pytest.approx(fine.shape_factor, abs=SHAPE_FACTOR)
    assert papers_cell.tip_pressure == pytest.approx(fine.tip_pressure, rel=TIP_PRESSURE)


def test_errors_fall_exponentially_with_the_order() -> None:
    """On one mesh: the pressure by 3 an order at least, the shape factor by its square."""
    series = SeriesCell(6.0, 4.0)
    errors = []
    for order in (3, 4, 5, 6, 7):
        cell = solve_cell(Ellipse(1.0, 6.0), 4.0, CellNumerics(order=order, estimate=False))
        exact = series.basis(cell.response.surface)
        errors.append(
            (
                abs(cell.shape_factor - series.shape_factor),
                np.abs(cell.response.basis - exact).max(),
            )
        )
    factor, pressure = np.array(errors).T
    assert (factor[0] / factor[-1]) ** 0.25 > 5.0
    assert (pressure[0] / pressure[-1]) ** 0.25 > 2.5
    # the torque is a virtual work: its error goes with the square of the fields'
    assert np.all(factor < 0.1 * (pressure / 20.0))


def test_circle_in_a_circle() -> None:
    """An elementary solution: ``f = A z^3 + B/z``, ``g = E z + C/z^3`` for the strain D_11 = 1.

    On ``|z| = r``: ``e^(3 i s)`` has ``A r^3 + B/r - C/r^3``, ``e^(-i s)`` has ``B/r - 3 A r^3 -
    E r``; both vanish at 1, and at R the second is R.
    """
    cell = solve_cell(Ellipse(1.0, 1.0), 4.0)
    rows = []
    for r in (1.0, 2.0):
        rows += [[r**3, 1.0 / r, 0.0, -(r**-3)], [-3.0 * r**3, 1.0 / r, -r, 0.0]]
    A, B, *_ = np.linalg.solve(rows, [0.0, 0.0, 0.0, 2.0])
    assert cell.response.tip[0] == pytest.approx(-4.0 * (3.0 * A - B), rel=TIP_PRESSURE)
    assert cell.shape_factor == pytest.approx(0.0, abs=SHAPE_FACTOR)
    assert cell.stall_angle is None
    _, high = cell.response.support.both(np.linspace(0.0, 2.0 * np.pi, 50))
    assert np.ptp(high) <= TIP_PRESSURE * high.max()  # nothing changes as it turns


def test_nearly_a_circle_is_nearly_a_circle() -> None:
    cell = solve_cell(Ellipse(1.0, 1.001), 4.0, CellNumerics(estimate=False))
    circle = solve_cell(Ellipse(1.0, 1.0), 4.0, CellNumerics(estimate=False))
    # both are smooth in r_e; the slopes at one are of the order of ten
    assert 0.0 < cell.shape_factor < 0.01
    assert cell.tip_pressure == pytest.approx(circle.tip_pressure, rel=0.01)


def test_far_node_reference(papers_cell: CellSolution) -> None:
    """The two levels differ by a constant, and only in the stretching mode."""
    node = solve_cell(
        Ellipse(42e-6, 6.0), 4.0, CellNumerics(pressure_reference="far-node", estimate=False)
    )
    shift = node.response.basis - papers_cell.response.basis
    rounding = 1e-9 * papers_cell.tip_pressure
    assert np.ptp(shift[:, 0]) < rounding
    assert np.max(np.abs(shift[:, 1])) < 1e-6 * papers_cell.tip_pressure  # mesh is symmetric
    far = np.argmin(np.hypot(node.points[:, 0] - 2.0, node.points[:, 1]))
    assert node.pressure[far] == pytest.approx(0.0, abs=rounding)
    assert node.shape_factor == pytest.approx(papers_cell.shape_factor, abs=1e-12)


def test_fields_for_drawing(papers_cell: CellSolution) -> None:
    cell = papers_cell
    x, y = cell.points.T
    radius = np.hypot(x, y)
    on_edge = np.abs(radius - 2.0) < 1e-6
    on_fiber = np.abs(np.hypot(x, 6.0 * y) - 1.0) < 1e-6
    assert on_edge.sum() == on_fiber.sum() == 7 * 20
    far = [np.stack([x, -y], axis=-1), np.stack([y, x], axis=-1)]
    turning = cell.shape_factor * np.stack([-y, x], axis=-1)
    geometry = 1e-6  # how well order 7 follows the walls
    for mode in range(2):
        wall = np.zeros_like(turning) if mode == 0 else turning
        assert cell.velocity[on_edge, mode] == pytest.approx(far[mode][on_edge], abs=geometry)
        assert cell.velocity[on_fiber, mode] == pytest.approx(wall[on_fiber], abs=geometry)
    a, b, c = (cell.points[cell.cells[:, k]] for k in range(3))
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert np.all(area > 0.0)
    # straight triangles against the ring between ellipse and circle: 140 chords
    assert area.sum() == pytest.approx(np.pi * (4.0 - 1.0 / 6.0), rel=2e-3)
    assert cell.element_edges.shape == (2 * 20 * 7 + 20, 8)


@pytest.mark.parametrize(("ratio", "domain"), [(6.0, 2.01), (50.0, 2.5), (1.5, 200.0)])
def test_extreme_cells_meet_the_same_accuracy(ratio: float, domain: float) -> None:
    estimate = solve_cell(Ellipse(1.0, ratio), domain).error_estimate
    assert estimate is not None
    assert estimate.shape_factor < SHAPE_FACTOR
    assert estimate.tip_pressure < TIP_PRESSURE
    assert estimate.surface_pressure < TIP_PRESSURE


@pytest.mark.parametrize("domain", [2.0, 1.0, -3.0, np.nan, np.inf])
def test_a_fiber_larger_than_its_cell(domain: float) -> None:
    with pytest.raises(ConfigError, match="domain_size"):
        solve_cell(Ellipse(42e-6, 6.0), domain)


@pytest.mark.parametrize(
    "change", [{"order": 1}, {"order": 40}, {"angular_spacing": 0.0}, {"radial_spacing": 9.0}]
)
def test_numerics_out_of_range(change: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match=next(iter(change))):
        CellNumerics(**change)  # type: ignore[arg-type]  # one value each
    with pytest.raises(ConfigError, match="mean"):
        CellNumerics(pressure_reference="nowhere")  # type: ignore[arg-type]  # wrong on purpose
