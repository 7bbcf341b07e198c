"""Where the nodes of the paper's mesh lie, and what it refuses."""

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import CellNumerics
from fibermelt.fiber.cell_paper import PaperGrid

ROUNDING = 1e-12
GRID = PaperGrid(1.0 / 6.0, 2.0)


def test_sixty_by_sixty_unit_cells_make_1800_triangles() -> None:
    assert GRID.nodes().shape == (60, 61, 2)
    assert 2 * GRID.columns * GRID.rows == 1800


def test_each_radial_interval_is_a_tenth_longer_than_the_one_before() -> None:
    along_the_tip = GRID.nodes()[0]
    lengths = np.linalg.norm(np.diff(along_the_tip, axis=0), axis=1)
    assert lengths[1:] / lengths[:-1] == pytest.approx(1.1, rel=1e-9)
    assert lengths.sum() == pytest.approx(1.0, rel=ROUNDING)  # R - a
    assert lengths[0] == pytest.approx(0.1 / (1.1**60 - 1.0), rel=1e-9)


def test_first_and_last_nodes_lie_on_the_walls() -> None:
    nodes = GRID.nodes()
    assert np.hypot(nodes[:, 0, 0], 6.0 * nodes[:, 0, 1]) == pytest.approx(1.0, rel=ROUNDING)
    assert np.hypot(*nodes[:, -1].T) == pytest.approx(2.0, rel=ROUNDING)
    eccentric = np.arctan2(6.0 * nodes[::2, 0, 1], nodes[::2, 0, 0]) % (2.0 * np.pi)
    assert eccentric == pytest.approx(GRID.surface_angles(), abs=ROUNDING)


def test_the_same_after_half_a_turn_and_in_a_mirror() -> None:
    nodes = GRID.nodes()
    assert nodes[30:] == pytest.approx(-nodes[:30], abs=ROUNDING)
    assert nodes[1:] == pytest.approx(nodes[:0:-1] * [1.0, -1.0], abs=ROUNDING)


def test_the_papers_order_is_its_own() -> None:
    assert CellNumerics(mesh="paper").velocity_order == 2
    assert CellNumerics(mesh="paper", order=2).velocity_order == 2
    assert CellNumerics(order=5).velocity_order == 5


@pytest.mark.parametrize(
    "change", [{"order": 3}, {"angular_spacing": 0.3}, {"radial_spacing": 0.3}]
)
def test_what_the_papers_mesh_fixes_is_not_swallowed(change: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match=f"{next(iter(change))} = .* has no effect"):
        CellNumerics(mesh="paper", **change)  # type: ignore[arg-type]  # one value each


def test_a_mesh_of_another_name() -> None:
    with pytest.raises(ConfigError, match='mesh = "fine": must be "graded" or "paper"'):
        CellNumerics(mesh="fine")  # type: ignore[arg-type]  # wrong on purpose
