"""The three-dimensional cell of a spheroid against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.fiber.cell.spheroid import SpheroidCell, SpheroidGrid
from fibermelt.fiber.spheroid import Spheroid, unbounded_spheroid


@pytest.mark.parametrize("aspect_ratio", [1.0, 3.0])
def test_newtonian_melt_has_the_closed_form(aspect_ratio: float) -> None:
    """Coarse P3: the outer surface and the curve leave 3e-3 in the spin, 3 % in the pressure."""
    phi = np.pi / 4.0
    D = 0.5 * np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 0.0]]) / np.sqrt(2.0)
    exact = unbounded_spheroid(Spheroid(1.0, aspect_ratio))
    ends = exact.extremes(D, [1.0, 0.0, 0.0])
    cell = SpheroidCell(aspect_ratio, SpheroidGrid(4, 3, 4, 3))
    flow = cell.solve(lambda squared: 1.0 + 0.0 * squared, phi)
    assert flow.spin == pytest.approx(exact.shape_factor * np.sin(phi), abs=3e-3)
    assert flow.pressure.min() == pytest.approx(float(ends.lowest), rel=0.03)
