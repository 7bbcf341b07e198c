"""Directors in three dimensions against an independent integration of Jeffery's equation."""

import numpy as np
import pytest

from fibermelt.fiber import equal_area_directions, follow_directors
from fibermelt.verify.fiber_motion import reference_directors, spatial_path

pytestmark = pytest.mark.verification

STARTS = equal_area_directions(5)


@pytest.mark.parametrize("factor", [0.9459, -0.8, 1.0344])
def test_fourth_order_in_the_spacing_of_the_history(factor: float) -> None:
    exact = reference_directors(factor, STARTS)
    errors = []
    for points in (129, 257, 513):
        motion = follow_directors(spatial_path(points), factor, STARTS)
        errors.append(np.max(np.abs(motion.direction[:, -1] - exact)))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx(4.0, abs=0.25)
    # at 2049 points the interpolant is good to some 1e-9, and the integration must not be worse
    fine = follow_directors(spatial_path(2049), factor, STARTS)
    assert fine.direction[:, -1] == pytest.approx(exact, abs=1e-8)
    assert np.sum(fine.direction**2, axis=-1) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_the_tolerance_is_kept(tolerance: float) -> None:
    exact = follow_directors(spatial_path(65), 0.9459, STARTS, 1e-12)
    motion = follow_directors(spatial_path(65), 0.9459, STARTS, tolerance)
    assert np.max(np.abs(motion.direction - exact.direction)) <= tolerance
    assert motion.substeps <= exact.substeps
