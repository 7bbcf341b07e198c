"""The cell's grid: where its columns lie."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fibermelt.fiber.cell_grid import CellGrid


def rays(grid: CellGrid) -> np.ndarray:
    """Return the eccentric angles [rad] of the columns' first rays, over a quarter turn."""
    column = np.arange(grid.columns_per_quarter + 1)
    return np.asarray(grid.eccentric_angle(0.0, column / grid.columns_per_quarter))


@pytest.mark.parametrize("even_from", [math.inf, 0.5])
def test_columns_are_found_again(even_from: float) -> None:
    grid = CellGrid(1.0 / 6.0, 2.0, 0.4, 1.0, sharpening=10.0, even_from=even_from)
    column = np.linspace(0.0, grid.columns, 201)[:-1]
    tip = grid.nearest_tip(np.floor(column).astype(np.intp))
    angle = np.mod(grid.eccentric_angle(tip, column / grid.columns_per_quarter), 2.0 * np.pi)
    gap = np.abs(grid.column_coordinate(angle) - column)
    assert np.max(np.minimum(gap, grid.columns - gap)) < 1e-10  # rounding, turn by turn
    assert rays(grid)[[0, -1]] == pytest.approx([0.0, 0.5 * np.pi], abs=1e-12)


def test_columns_grow_up_to_a_width() -> None:
    even_from, spacing = 0.5, 0.4
    grid = CellGrid(1.0 / 6.0, 2.0, spacing, 1.0, sharpening=10.0, even_from=even_from)
    width = np.diff(rays(grid))
    assert np.all(np.diff(width) > 0.0)
    assert width[-1] < spacing * even_from
    graded = np.diff(rays(CellGrid(1.0 / 6.0, 2.0, spacing, 1.0, sharpening=10.0)))
    # at the tip as fine as without
    assert width[0] == pytest.approx(graded[0], rel=0.1)
    assert graded[-1] > 2.0 * width[-1]
