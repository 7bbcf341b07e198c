"""The ellipsoid's constants against independent forms: elementary, Carlson's, planar, published."""

import numpy as np
import pytest
from scipy.special import elliprd

from fibermelt.fiber import (
    Ellipsoid,
    Spheroid,
    body_axes,
    ellipse_extremes,
    embed_planar,
    unbounded_ellipsoid,
    unbounded_spheroid,
)
from fibermelt.fiber.ellipsoid_integrals import ellipsoid_integrals
from fibermelt.verify.fiber_forms import TIP_PRESSURES, spheroid_integrals

pytestmark = pytest.mark.verification

EXACT = 1e-12
STRETCH = np.diag([1.0, -0.5, -0.5])
AXIS = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize(("ratio", "pressure"), [(1.0, -5.0), *TIP_PRESSURES.items()])
def test_tip_pressure_in_stretching(ratio: float, pressure: float) -> None:
    """Values from an independent evaluation of Jeffery's solution, to the digits given."""
    response = unbounded_spheroid(Spheroid(1.0, ratio))
    tip = float(response.tip(STRETCH, AXIS))
    assert tip == pytest.approx(pressure, abs=5e-4)
    assert float(response.extremes(STRETCH, AXIS).lowest) == pytest.approx(tip, rel=EXACT)
    if ratio == 1.0:
        assert tip == pytest.approx(-5.0, rel=EXACT)


def test_peak_of_a_tumbling_spheroid() -> None:
    """15.53 ``mu gamma_dot`` at aspect ratio 6, against 7 for the ellipse."""
    response = unbounded_spheroid(Spheroid(1.0, 6.0))
    low, high = response.bounds(embed_planar([[0.0, 1.0], [0.0, 0.0]]))
    assert float(high) == pytest.approx(15.53, abs=5e-3)
    assert float(low) == pytest.approx(-float(high), rel=EXACT)
    assert float(high) == pytest.approx(0.5 * 31.0674, rel=1e-5)


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.7, 1.5, 6.0, 40.0, 1000.0])
def test_spheroids_in_elementary_functions(ratio: float) -> None:
    along, mixed, double = spheroid_integrals(ratio)
    found = ellipsoid_integrals(np.array([ratio, 1.0, 1.0]), np.array(0.0))
    # the elementary forms cancel near the sphere, and the last one for a disc
    tolerance = 1e-15 * (ratio + 1.0 / ratio + 30.0)
    assert 0.5 * found.single[0] == pytest.approx(along, rel=tolerance)
    assert found.double[0, 1] == pytest.approx(mixed, rel=tolerance)
    assert found.double[1, 2] == pytest.approx(double, rel=10.0 * tolerance)
    assert found.double[1, 1] == pytest.approx(found.double[1, 2], rel=EXACT)  # both I_bb


@pytest.mark.parametrize("axes", [(3.0, 2.0, 1.0), (1.0, 20.0, 4.0), (0.1, 1.0, 7.0)])
@pytest.mark.parametrize("shift", [0.0, 0.4, 30.0])
def test_triaxial_integrals_by_carlson(axes: tuple[float, float, float], shift: float) -> None:
    """Divided differences of ``R_D``, for axes far enough apart."""
    a = np.array(axes)
    x = a * a + shift
    single = (
        2.0
        / 3.0
        * np.prod(a)
        * np.array([elliprd(x[(k + 1) % 3], x[(k + 2) % 3], x[k]) for k in range(3)])
    )
    found = ellipsoid_integrals(a, np.array(shift))
    assert found.single == pytest.approx(single, rel=EXACT)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        mixed = (single[i] - single[j]) / (x[j] - x[i])
        tolerance = EXACT * single[i] / abs(single[i] - single[j])
        assert found.double[i, j] == pytest.approx(mixed, rel=max(tolerance, EXACT))
        moment = single[j] - a[i] ** 2 * mixed
        assert found.moment[i, j] == pytest.approx(moment, rel=1e-9)
    # 3 I_i = sum_j x_j I_ij + 2 x_i I_ii: all positive, so it checks the diagonal as well
    diagonal = np.diag(found.double)
    assert found.double @ x + 2.0 * x * diagonal == pytest.approx(3.0 * single, rel=EXACT)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 6.0])
def test_a_long_elliptic_cylinder_is_the_ellipse(ratio: float) -> None:
    """The third axis at 200 and 400 times the fiber: the planar extremes, like ``(a/a_3)^2``."""
    rng = np.random.default_rng(2)
    gradient = rng.normal(size=(50, 2, 2))
    gradient[:, 1, 1] = -gradient[:, 0, 0]
    shear = 0.5 * (gradient[:, 0, 1] + gradient[:, 1, 0])
    planar = ellipse_extremes(ratio, gradient[:, 0, 0], shear)
    errors = []
    for length in (200.0, 400.0):
        response = unbounded_ellipsoid(Ellipsoid((1.0, 1.0 / ratio, length)))
        found = response.extremes(embed_planar(gradient))
        errors.append(
            max(np.max(np.abs(found.lowest - planar[0])), np.max(np.abs(found.highest - planar[1])))
        )
        spin = response.angular_velocity(embed_planar(gradient))[:, 2]
        xi = (ratio**2 - 1.0) / (ratio**2 + 1.0)
        assert spin == pytest.approx(
            0.5 * (gradient[:, 1, 0] - gradient[:, 0, 1]) + xi * shear, abs=EXACT
        )
    order = np.log2(errors[0] / errors[1])
    assert order == pytest.approx(2.0, abs=0.25)  # a logarithm goes with it
    assert errors[1] < 2e-3


def test_the_sphere_is_no_special_point() -> None:
    """Through ``r_e = 1 +- 1e-9`` the constants run on smoothly, with the slope of wider steps."""

    def constants(ratio: float) -> np.ndarray:
        r = unbounded_spheroid(Spheroid(1.0, ratio))
        return np.array([r.axial, r.shear, r.transverse, r.offset, r.shape_factor])

    middle = constants(1.0)
    assert middle == pytest.approx([5.0, 5.0, 5.0, 0.0, 0.0], abs=EXACT)
    slope = (constants(1.0 + 1e-4) - constants(1.0 - 1e-4)) / 2e-4
    for step in (1e-9, 1e-6):
        after, before = constants(1.0 + step), constants(1.0 - step)
        assert after - before == pytest.approx(2.0 * step * slope, abs=1e-13 + 1e-7 * step)
        assert after + before == pytest.approx(2.0 * middle, abs=1e-13 + 10.0 * step**2)


def test_ellipsoid_to_spheroid_to_sphere() -> None:
    """Two axes drawn together reach the spheroid in proportion to their difference."""
    rng = np.random.default_rng(4)
    gradient = rng.normal(size=(3, 3))
    gradient -= np.trace(gradient) / 3.0 * np.eye(3)
    spheroid = unbounded_spheroid(Spheroid(1.0, 4.0)).surface_stress(gradient, AXIS)
    differences = []
    for gap in (1e-3, 1e-5, 1e-7):
        triaxial = unbounded_ellipsoid(Ellipsoid((1.0, 0.25, 0.25 * (1.0 + gap))))
        differences.append(np.max(np.abs(triaxial.surface_stress(gradient) - spheroid)) / gap)
    assert np.array(differences[1:]) == pytest.approx(differences[0], rel=1e-2)
    sphere = unbounded_ellipsoid(Ellipsoid((1.0, 1.0, 1.0))).surface_stress(gradient)
    assert sphere == pytest.approx(2.5 * (gradient + gradient.T), rel=EXACT, abs=EXACT)


@pytest.mark.parametrize("ratio", [0.05, 0.8, 1.0, 6.0, 50.0])
def test_the_spheroid_is_the_ellipsoid_s_special_case(ratio: float) -> None:
    rng = np.random.default_rng(6)
    fiber = Spheroid(42e-6, ratio)
    spheroid, ellipsoid = unbounded_spheroid(fiber), unbounded_ellipsoid(fiber.as_ellipsoid())
    for _ in range(5):
        gradient = rng.normal(size=(3, 3))
        gradient -= np.trace(gradient) / 3.0 * np.eye(3)
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        axes = body_axes(direction)
        own = axes.T @ gradient @ axes
        stress = axes @ ellipsoid.surface_stress(own) @ axes.T
        scale = EXACT * np.max(np.abs(stress))
        assert spheroid.surface_stress(gradient, direction) == pytest.approx(stress, abs=scale)
        turn = axes @ ellipsoid.angular_velocity(own)
        assert spheroid.angular_velocity(gradient, direction) == pytest.approx(turn, abs=EXACT)
        one, other = spheroid.extremes(gradient, direction), ellipsoid.extremes(own)
        assert float(one.lowest) == pytest.approx(float(other.lowest), abs=scale)
        assert float(one.highest) == pytest.approx(float(other.highest), abs=scale)
        for name in ("where_lowest", "where_highest"):
            here, there = getattr(one, name), axes @ getattr(other, name)
            # on the equator both ends of a diameter qualify
            assert abs(float(here @ there)) == pytest.approx(1.0, abs=EXACT) or ratio == 1.0
