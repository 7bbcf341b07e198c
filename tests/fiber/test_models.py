"""What answers for a fiber: three models, one interface, and what a third dimension changes."""

from __future__ import annotations

import numpy as np
import pytest
from examples_drawn import examples
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Ellipse,
    Spheroid,
    embed_planar,
    equal_area_directions,
    extremes,
    follow,
    follow_directors,
    orbit,
    planar_directions,
    pressure_bounds,
    surface_pressure,
    unbounded_spheroid,
)
from fibermelt.fiber.models import confined_model, unbounded_model
from fibermelt.fiber.section import planar_section
from fibermelt.fiber.spatial import follow_spatial, half_sphere, spatial_pressure
from fibermelt.fiber.surroundings import surroundings
from fibermelt.history import FlowHistory

FEW = examples(20)
ROUNDING = 1e-12
INTERPOLATED = 1e-10  # a trigonometric interpolant's roundings, over the largest pressure
TABLE = 1e-8  # what the support function's table promises, over the largest pressure
FOLLOWED = 2e-8  # two ways through the same path, each to 1e-8 rad

EXTENSION = np.diag([1.0, -1.0])
VISCOSITY = 817.0
ZONES = (0.6, 0.8, 1.2)


def winding(scale: float = 1.0) -> FlowHistory:
    """A path through shear, extension and turning, as melt meets on its way to the bed."""
    time = np.linspace(0.0, 1.5, 161)
    gradient = np.empty((161, 2, 2))
    gradient[:, 0, 0] = 4.0 * np.sin(3.0 * time)
    gradient[:, 1, 1] = -gradient[:, 0, 0]
    gradient[:, 0, 1] = 9.0 * np.cos(2.0 * time)
    gradient[:, 1, 0] = 2.0 - 5.0 * time
    position = np.stack([time, time**2], axis=-1)
    velocity = np.stack([np.ones_like(time), 2.0 * time], axis=-1)
    return FlowHistory(time, position, velocity, scale * gradient, 1e5 * time)


def spheroid(ratio: float = 6.0):
    return unbounded_spheroid(Spheroid(1.0, ratio))


@pytest.mark.parametrize("ratio", [1.0, 1.02, 1.5, 3.0, 6.0, 20.0, 50.0])
def test_the_section_sees_the_extremes_of_the_whole_surface(ratio: float) -> None:
    whole = spheroid(ratio)
    section = planar_section(whole)
    assert section.shape_factor == whole.shape_factor
    angle = np.linspace(-2.0, 2.0, 301)
    exact = whole.extremes(embed_planar(EXTENSION), planar_directions(angle))
    low, high = section.support.both(-2.0 * angle)
    largest = section.support.largest
    assert low == pytest.approx(exact.lowest, abs=TABLE * largest)
    assert high == pytest.approx(exact.highest, abs=TABLE * largest)
    # and no direction in space leaves the bounds of the plane
    low, high = whole.bounds(embed_planar(EXTENSION))
    assert largest == pytest.approx(high, rel=ROUNDING)
    assert -largest == pytest.approx(low, rel=ROUNDING)
    found = whole.extremes(embed_planar(EXTENSION), equal_area_directions(20000))
    mildest = section.support.smallest * (1.0 - TABLE)
    assert found.highest.min() >= mildest
    assert -found.lowest.max() >= mildest


@FEW
@given(st.floats(1.0, 50.0), st.floats(-4.0, 4.0), st.floats(-np.pi, np.pi))
def test_the_section_is_the_pressure_on_the_spheroid(
    ratio: float, phase: float, place: float
) -> None:
    strain = np.array([np.cos(phase), np.sin(phase)])
    gradient = embed_planar([[strain[0], strain[1]], [strain[1], -strain[0]]])
    whole = spheroid(ratio)
    section = planar_section(whole)
    normal = np.array([np.cos(place), ratio * np.sin(place), 0.0])
    normal /= np.linalg.norm(normal)
    exact = -normal @ whole.surface_stress(gradient, [1.0, 0.0, 0.0]) @ normal
    found = section.curve.point(np.array([place]))[0] @ strain
    assert found == pytest.approx(exact, abs=INTERPOLATED * section.tip_pressure)


def test_the_known_numbers_of_six() -> None:
    ellipse, section = (
        unbounded_model(name, Ellipse(1.0, 6.0)) for name in ("ellipse", "spheroid")
    )
    assert ellipse.response.tip_pressure == pytest.approx(7.0, rel=ROUNDING)
    assert section.response.tip_pressure == pytest.approx(15.53, abs=0.005)  # printed digits
    found = orbit(section.response, 1.0, VISCOSITY)
    assert found.tip_max == pytest.approx(found.max_pressure, rel=ROUNDING)
    assert found.period == pytest.approx(2.0 * np.pi * (6.0 + 1.0 / 6.0), rel=1e-8)


def test_a_sphere_is_five_halves() -> None:
    """Exactly -5 mu at unit axial extension (Jeffery's limit), so 5/2 in a shear's extension."""
    sphere = unbounded_model("spheroid", Ellipse(1.0, 1.0)).response
    assert sphere.tip_pressure == pytest.approx(2.5, rel=ROUNDING)
    assert sphere.support.smallest == pytest.approx(sphere.support.largest, rel=ROUNDING)


def test_in_the_plane_a_spheroid_turns_like_an_ellipse() -> None:
    path, angles = winding(), np.linspace(-1.5, 1.5, 7)
    response = unbounded_model("ellipse", Ellipse(1.0, 6.0)).response
    planar = follow(path, response.shape_factor, angles)
    spatial = follow_spatial(path, spheroid().shape_factor, planar_directions(angles))
    assert np.array_equal(spatial.angle, planar.angle)
    assert np.array_equal(spatial.spin, planar.spin)
    assert not spatial.elevation.any()
    section = planar_section(spheroid())
    one = surface_pressure(path, section, VISCOSITY, planar)
    two = spatial_pressure(path, spheroid(), VISCOSITY, spatial)
    scale = pressure_bounds(path, section, VISCOSITY).highest
    assert np.all(np.abs(one.lowest - two.lowest) <= TABLE * scale)
    assert np.all(np.abs(one.highest - two.highest) <= TABLE * scale)
    first, second = extremes(path, one, planar, ZONES), extremes(path, two, spatial, ZONES)
    assert np.array_equal(first.index, second.index)
    # the two ends of the range are one place
    assert np.sin(first.where - second.where) == pytest.approx(0.0, abs=1e-7)


def test_in_space_it_is_what_the_directors_do() -> None:
    path, start = winding(), equal_area_directions(30)
    spatial = follow_spatial(path, spheroid().shape_factor, start)
    directors = follow_directors(path, spheroid().shape_factor, start)
    assert spatial.direction == pytest.approx(directors.direction, abs=FOLLOWED)
    assert np.all(spatial.elevation > 0.0)


def test_extremes_in_space_lie_within_the_bounds() -> None:
    path = FlowHistory.stack([winding(), winding(0.5)])
    section = planar_section(spheroid())
    motion = follow_spatial(path, section.shape_factor, half_sphere(40))
    pressure = spatial_pressure(path, spheroid(), VISCOSITY, motion)
    bounds = pressure_bounds(path, section, VISCOSITY)
    slack = 1.0 + TABLE
    for values, worst, mildest in (
        (-pressure.lowest, -bounds.lowest, -bounds.mildest_lowest),
        (pressure.highest, bounds.highest, bounds.mildest_highest),
    ):
        assert np.all(values <= slack * worst[:, None])
        assert np.all(slack * values >= mildest[:, None])
    found = extremes(path, pressure, motion, [ZONES, ZONES])
    assert found.value.shape == (2, 40, 3, 2)
    assert np.all(np.abs(found.where) <= 0.5 * np.pi)


def test_pressures_are_linear_in_viscosity() -> None:
    path, angles = winding(), np.linspace(-1.5, 1.5, 5)
    whole, section = spheroid(), planar_section(spheroid())
    planar = follow(path, section.shape_factor, angles)
    spatial = follow_spatial(path, section.shape_factor, half_sphere(5))
    for one, two in (
        [surface_pressure(path, section, viscosity, planar) for viscosity in (1.0, VISCOSITY)],
        [spatial_pressure(path, whole, viscosity, spatial) for viscosity in (1.0, VISCOSITY)],
    ):
        assert two.lowest == pytest.approx(VISCOSITY * one.lowest, rel=ROUNDING)
        assert two.highest == pytest.approx(VISCOSITY * one.highest, rel=ROUNDING)


@pytest.mark.parametrize("name", ["ellipse", "spheroid"])
def test_isotropic_quantiles_are_linear_in_viscosity_and_ordered(name: str) -> None:
    model, path = unbounded_model(name, Ellipse(1.0, 6.0)), FlowHistory.stack([winding()])
    one, two = (model.isotropic_pressure(path, viscosity, [ZONES], 30) for viscosity in (1.0, 2.0))
    assert one.lowest.shape == (1, 161, 3)
    assert one.extremes.shape == (1, 3, 2, 3)
    for field in ("lowest", "highest", "extremes"):
        assert getattr(two, field) == pytest.approx(2.0 * getattr(one, field), rel=ROUNDING)
        assert np.all(np.diff(getattr(one, field), axis=-1) >= 0.0)


def test_isotropic_spheroids_are_those_that_are_followed() -> None:
    """The quantiles take no angles and places; what they leave are the same pressures."""
    path, whole, start = winding(), spheroid(), equal_area_directions(50)
    motion = follow_spatial(path, whole.shape_factor, start)
    pressure = spatial_pressure(path, whole, VISCOSITY, motion)
    value = extremes(path, pressure, motion, ZONES).value
    model = unbounded_model("spheroid", Ellipse(1.0, 6.0))
    found = model.isotropic_pressure(path, VISCOSITY, ZONES, 50, (0.1, 0.9))
    scale = INTERPOLATED * pressure.highest.max()
    for one, values in (
        (found.lowest, pressure.lowest),
        (found.highest, pressure.highest),
        (found.extremes, value),
    ):
        followed = np.moveaxis(np.quantile(values, (0.1, 0.9), axis=0), 0, -1)
        assert one == pytest.approx(followed, abs=scale)


def test_isotropic_in_space_is_milder_than_in_the_plane() -> None:
    """Fibers out of the plane see less of it: the median of the lowest pressure is less deep."""
    path = FlowHistory.stack([winding()])
    model = unbounded_model("spheroid", Ellipse(1.0, 6.0))
    space = model.isotropic_pressure(path, 1.0, [ZONES], 200)
    plane = confined_model(model.response).isotropic_pressure(path, 1.0, [ZONES], 200)
    assert np.all(space.extremes[0, :, 0, 1] > plane.extremes[0, :, 0, 1])


def test_the_half_sphere_is_even_and_ordered() -> None:
    p = half_sphere(500)
    angle = np.arctan2(p[:, 1], p[:, 0])
    assert np.all(np.diff(angle) >= 0.0)
    assert np.all(np.abs(angle) <= 0.5 * np.pi)
    assert np.all(p[:, 2] > 0.0)
    # the second moment of the even distribution is a third of the identity
    assert np.diag(p.T @ p) / 500 == pytest.approx(1.0 / 3.0, abs=5e-3)


@pytest.mark.parametrize("name", ["ellipse", "spheroid"])
@pytest.mark.parametrize("ratio", [1.0, 6.0, 30.0])
def test_the_surroundings_meet_the_fiber(name: str, ratio: float) -> None:
    model = unbounded_model(name, Ellipse(1.0, ratio))
    found = surroundings(model)
    x, y = found.points.T
    surface = np.isclose(x**2 + (ratio * y) ** 2, 1.0, rtol=0.0, atol=1e-10)
    assert surface.sum() >= 64
    at = np.arctan2(ratio * y[surface], x[surface])
    assert found.pressure[surface] == pytest.approx(
        model.response.curve.point(at), abs=1e-10 * model.response.tip_pressure
    )
    # no slip: at rest in the first flow, turning at B in the second
    turning = model.response.shape_factor * np.stack([-y, x], axis=-1)[surface]
    assert found.velocity[surface, 0] == pytest.approx(0.0, abs=1e-10)
    assert found.velocity[surface, 1] == pytest.approx(turning, abs=1e-10)
    assert np.hypot(x, y).max() == pytest.approx(2.0)
    first, second, third = (found.points[found.cells[:, k]] for k in range(3))
    assert np.all(np.linalg.det(np.stack([second - first, third - first], axis=-1)) > 0.0)
    assert found.lines.max() < len(x)


def test_what_is_refused() -> None:
    with pytest.raises(ConfigError, match=r'fiber\.model = "confined-ellipse": must be "ellipse"'):
        unbounded_model("confined-ellipse", Ellipse(1.0, 6.0))
    with pytest.raises(ConfigError, match=r"aspect_ratio = 0\.5: the section of a disc"):
        planar_section(spheroid(0.5))
    with pytest.raises(ConfigError, match="none along z"):
        follow_spatial(winding(), 0.9, np.array([[0.0, 0.0, 1.0]]))
    with pytest.raises(ConfigError, match="unit vector"):
        follow_spatial(winding(), 0.9, np.array([[1.0, 1.0, 0.0]]))
    model = unbounded_model("spheroid", Ellipse(1.0, 6.0))
    with pytest.raises(ConfigError, match="quantile levels"):
        model.isotropic_pressure(winding(), 1.0, ZONES, 10, (0.5, 1.5))
    motion = follow_spatial(winding(), 0.9, half_sphere(3))
    with pytest.raises(ConfigError, match=r"melt\.viscosity = -1 Pa s"):
        spatial_pressure(winding(), spheroid(), -1.0, motion)


@pytest.mark.parametrize("name", ["ellipse", "spheroid"])
def test_zones_of_all_paths_at_once(name: str) -> None:
    model = unbounded_model(name, Ellipse(1.0, 6.0))
    paths = FlowHistory.stack([winding(), winding()])
    one = model.isotropic_pressure(paths, VISCOSITY, ZONES, 10)
    each = model.isotropic_pressure(paths, VISCOSITY, [ZONES, ZONES], 10)
    assert np.array_equal(one.extremes, each.extremes)


def test_zones_of_other_paths() -> None:
    model = unbounded_model("spheroid", Ellipse(1.0, 6.0))
    paths = FlowHistory.stack([winding(), winding()])
    with pytest.raises(ConfigError, match=r"zone_time has shape \(3, 3\): .* \(2, 3\)"):
        model.isotropic_pressure(paths, VISCOSITY, [ZONES] * 3)
