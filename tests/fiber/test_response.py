"""The response's checks, and the support function of curves that the ellipse never makes."""

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import Ellipse, FiberResponse, unbounded_ellipse
from fibermelt.fiber.curve import TrigonometricCurve
from fibermelt.fiber.support import FEWEST_KNOTS, SupportFunction

SAMPLES = 256
SURFACE = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
TABLE = 1e-8  # SUPPORT_TOLERANCE
BRUTE = 8000
MISSED = 30.0 * (np.pi / BRUTE) ** 2 / 8.0  # by brute force: a curvature of 30, spacing squared


def clover() -> np.ndarray:
    """A curve with inward dents: its extreme jumps from one leaf to the next."""
    radius = 1.0 + 0.45 * np.cos(6.0 * SURFACE)
    return np.stack([radius * np.cos(2.0 * SURFACE), 0.7 * radius * np.sin(2.0 * SURFACE)], axis=-1)


def brute_force(phase: np.ndarray) -> np.ndarray:
    s = np.linspace(0.0, np.pi, BRUTE + 1)
    radius = 1.0 + 0.45 * np.cos(6.0 * s)
    curve = np.stack([radius * np.cos(2.0 * s), 0.7 * radius * np.sin(2.0 * s)])
    return np.max(np.stack([np.cos(phase), np.sin(phase)], axis=-1) @ curve, axis=-1)


def test_support_of_a_dented_curve_has_corners_and_is_still_read_right() -> None:
    support = SupportFunction(TrigonometricCurve(clover()))
    phase = np.linspace(0.0, 2.0 * np.pi, 1001)
    error = support(phase) - brute_force(phase)
    assert np.all(error >= -TABLE)
    # at a corner two parabolas stand in, and are best half-way: twice there, and then some
    assert np.all(error <= MISSED + 10.0 * TABLE)
    assert support.largest == pytest.approx(1.45, rel=1e-12)


def test_smallest_support_at_a_corner() -> None:
    support = SupportFunction(TrigonometricCurve(clover()))
    coarse = np.linspace(0.0, 2.0 * np.pi, 1001)
    lowest = coarse[np.argmin(brute_force(coarse))]
    around = brute_force(lowest + np.linspace(-0.01, 0.01, 1001))
    # slopes of up to 1.45 meet there, read every 2e-5 rad
    assert support.smallest == pytest.approx(around.min(), abs=1.45 * 1e-5 + MISSED)


def test_where_names_the_point_that_makes_the_extreme() -> None:
    support = SupportFunction(TrigonometricCurve(clover()))
    phase = np.linspace(-7.0, 7.0, 501)
    point = support.curve.point(support.where_exact(phase))
    height = np.cos(phase) * point[:, 0] + np.sin(phase) * point[:, 1]
    assert height == pytest.approx(support(phase), abs=1e-4)  # parabolas at the corners
    assert np.median(np.abs(height - support(phase))) < TABLE


def test_curve_interpolates_its_harmonics() -> None:
    curve = TrigonometricCurve(clover())
    s = np.linspace(-4.0, 4.0, 333)
    radius = 1.0 + 0.45 * np.cos(6.0 * s)
    expected = np.stack([radius * np.cos(2.0 * s), 0.7 * radius * np.sin(2.0 * s)], axis=-1)
    assert curve.point(s) == pytest.approx(expected, abs=1e-13)


def test_a_circle_sees_the_same_extremes_at_every_angle() -> None:
    support = unbounded_ellipse(Ellipse(1.0, 1.0)).support
    low, high = support.both(np.linspace(0.0, 2.0 * np.pi, 100))
    assert high == pytest.approx(4.0, rel=1e-13)
    assert low == pytest.approx(-4.0, rel=1e-13)
    assert support.smallest == pytest.approx(support.largest, rel=1e-13)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"surface": SURFACE[:-1]}, "surface has shape"),
        ({"basis": clover()[:, :1]}, "basis has shape"),
        ({"surface": SURFACE + 0.1}, "surface must be the angles"),
        ({"shape_factor": np.nan}, "finite"),
        ({"aspect_ratio": 0.9}, "aspect_ratio = 0.9"),
        ({"basis": clover() * (1.0 + SURFACE[:, None])}, "between s and s \\+ pi"),
    ],
)
def test_no_response(change: dict[str, object], message: str) -> None:
    values = {"aspect_ratio": 6.0, "shape_factor": 1.0, "surface": SURFACE, "basis": clover()}
    with pytest.raises(ConfigError, match=message):
        FiberResponse(**(values | change))  # type: ignore[arg-type]  # one of them is wrong on purpose


def test_stall_angle() -> None:
    values = {"aspect_ratio": 6.0, "surface": SURFACE, "basis": clover()}
    stalled = FiberResponse(shape_factor=1.25, **values)
    assert stalled.stall_angle == pytest.approx(0.5 * np.arccos(0.8))
    assert FiberResponse(shape_factor=0.95, **values).stall_angle is None


def test_a_maximum_that_moves_fast_is_no_corner() -> None:
    """An ellipse whose angle hardly moves with ``s`` at one place: ``h`` knows nothing of that."""
    angle = 0.6 + 2.0 * SURFACE - 0.985 * np.sin(2.0 * SURFACE)
    outline = np.stack([1.5 * np.cos(angle), np.sin(angle)], axis=-1)
    support = SupportFunction(TrigonometricCurve(outline))
    assert support.knots == FEWEST_KNOTS
    phase = np.linspace(0.0, 2.0 * np.pi, 20_011)
    exact = np.hypot(1.5 * np.cos(phase), np.sin(phase))
    # The table is checked half-way between knots: elsewhere its error may be twice as large.
    assert np.max(np.abs(support(phase) - exact)) < 2.0 * TABLE


def test_a_response_stays_as_it_is() -> None:
    response = unbounded_ellipse(Ellipse(1.0, 6.0))
    with pytest.raises(ValueError, match="read-only"):
        response.basis[0] = 0.0
    basis = np.array(response.basis)
    mine = FiberResponse(6.0, 0.9, response.surface.tolist(), basis)
    largest = mine.tip_pressure
    basis *= 2.0
    assert mine.tip_pressure == largest == response.tip_pressure
