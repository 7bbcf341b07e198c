"""The cubic between the points of a path."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline

from fibermelt.interpolation import PathInterpolant

ROUNDING = 1e-12  # a few operations on numbers of order one, over spacings of 0.05 and more


def uneven(seed: int, points: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).uniform(0.05, 1.0, points))


@given(st.integers(0, 99), st.integers(2, 7), st.floats(0.0, 1.0))
def test_quadratics_are_exact_at_any_spacing(seed: int, points: int, fraction: float) -> None:
    time = uneven(seed, points)
    degree = min(points - 1, 2)  # two points make a line
    powers = np.random.default_rng(seed).normal(size=degree + 1)
    path = PathInterpolant(time, np.polyval(powers, time)[:, None])
    for k in range(points - 1):
        at = time[k] + fraction * (time[k + 1] - time[k])
        exact = np.polyval(powers, at)
        assert path((k,), fraction)[0] == pytest.approx(exact, abs=ROUNDING * (1.0 + time[-1] ** 2))


def test_slopes_are_those_of_the_parabolas() -> None:
    time = uneven(4, 9)
    values = np.random.default_rng(5).normal(size=(9, 3))
    slopes = np.gradient(values, time, axis=0, edge_order=2)  # by the same parabolas
    spline, path = CubicHermiteSpline(time, values, slopes), PathInterpolant(time, values)
    for k in range(8):
        for fraction in (0.0, 0.3, 1.0):
            at = time[k] + fraction * (time[k + 1] - time[k])
            assert path((k,), fraction) == pytest.approx(spline(at), abs=1e-10)  # slopes reach 1e2


@given(st.integers(0, 99))
def test_no_change_exceeds_its_bound(seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(2, 6, 3))
    time = np.stack([uneven(seed, 6), uneven(seed + 1, 6)])
    path = PathInterpolant(time, values)
    u = np.linspace(0.0, 1.0, 101)[:, None]
    bound = path.largest_change()
    assert bound.shape == (2, 5)
    for line in range(2):
        for k in range(5):
            size = np.linalg.norm(path((line, k), u), axis=-1).max()
            assert size * np.diff(time[line])[k] <= bound[line, k]
