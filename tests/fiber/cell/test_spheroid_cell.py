"""A spheroid in a thinning melt in three dimensions: closed forms, orders, another code."""

from __future__ import annotations

import csv
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.fiber import (
    Spheroid,
    SpheroidNumerics,
    ThinningSpheroid,
    solve_thinning_spheroid,
    unbounded_ellipsoid,
    unbounded_thinning_spheroid,
)
from fibermelt.fiber.cell import spheroid_table
from fibermelt.fiber.cell.spheroid import SpheroidCell
from fibermelt.melt import CarreauYasuda, Cross, Newtonian, PowerLaw, ViscosityLaw

pytestmark = pytest.mark.verification

COARSE = SpheroidNumerics(layers=4, meridian=5)


def newtonian_gap(found: ThinningSpheroid) -> tuple[float, float]:
    """Return by how much spin and surface pressure miss the closed form, rms over the largest."""
    c, s = np.cos(found.phase), np.sin(found.phase)
    strain = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 0.0]])
    fiber = Spheroid(1.0, found.aspect_ratio)
    exact = unbounded_ellipsoid(fiber.as_ellipsoid()).surface_pressure(strain, found.places)
    gap = np.sqrt(np.mean((found.pressure - exact) ** 2)) / np.max(np.abs(exact))
    return abs(found.spin - fiber.jeffery_factor * s), float(gap)


@pytest.mark.parametrize("phase", [0.0, 0.7, 0.5 * np.pi])
@pytest.mark.parametrize("aspect_ratio", [1.0, 6.0])
def test_newtonian_melt_has_the_closed_form(aspect_ratio: float, phase: float) -> None:
    fiber = Spheroid(1.0, aspect_ratio)
    spin, pressure = newtonian_gap(solve_thinning_spheroid(fiber, Newtonian(817.0), 30.0, phase))
    # the outer surface at ten half-lengths leaves a thousandth, four elements around the rest
    assert spin < 5e-4
    assert pressure < 1e-2


def test_the_order_of_the_elements() -> None:
    # equal elements, so that all are halved; the outer surface so far that its 1e-5 does not show
    fiber, melt = Spheroid(1.0, 1.5), Newtonian(1.0)
    grids = [
        SpheroidNumerics(6 * k, 2 * k, 2 * k, 2, 40.0, first_layer=1.0, first_angle=1.0)
        for k in (1, 2, 3)
    ]
    gaps = np.array(
        [newtonian_gap(solve_thinning_spheroid(fiber, melt, 2.0, 0.7, g)) for g in grids]
    )
    order = np.log(gaps[:-1] / gaps[1:]) / np.log([[2.0, 2.0], [1.5, 1.5]])
    # spin, a functional, twice the order of the velocity; linear pressure 2 from below
    assert np.all((order[:, 0] > 3.5) & (order[:, 0] < 4.8))
    assert np.all((order[:, 1] > 1.4) & (order[:, 1] < 2.5))
    assert order[1, 1] > order[0, 1]


@pytest.mark.parametrize(
    "law",
    [PowerLaw(8213.0, 0.5), CarreauYasuda(10390.0, 0.35, 0.5)],
    ids=lambda law: type(law).__name__,
)
def test_along_the_stretch_the_spin_is_the_melts(law: ViscosityLaw) -> None:
    # in simple shear: at 45 degrees a fiber turns at half the rate
    found = solve_thinning_spheroid(Spheroid(1.0, 3.0), law, 20.0, 0.0, COARSE)
    assert abs(found.spin) < 1e-8


def test_a_sphere_sees_no_direction() -> None:
    fiber, law = Spheroid(1.0, 1.0), PowerLaw(1.0, 0.5, 1e-3)
    found = [solve_thinning_spheroid(fiber, law, 1.0, phase, COARSE) for phase in (0.0, 1.1)]
    ends = [end for one in found for end in (-one.lowest, one.highest)]
    assert abs(found[1].spin) < 1e-3
    # turned against the elements (4.00 to 4.09 on the table's)
    assert np.ptp(ends) < 0.04 * np.mean(ends)


def chain(aspect_ratio: float, phase: float, *indices: float) -> list[ThinningSpheroid]:
    """Return the answers in power-law melts, each from the one before."""
    found, before = [], None
    for index in indices:
        law = PowerLaw(1.0, index, 1e-3)
        cell = SpheroidCell(Spheroid(1.0, aspect_ratio), law, SpheroidNumerics())
        if before is not None:
            cell.start_from(before)
        found.append(cell.solved(1.0, phase))
        before = cell
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("aspect_ratio", "phase", "lowest"),
    [
        (3.0, 0.0, (-6.71, -5.69, -4.38, -3.62)),
        (6.0, 0.0, (-15.55, -12.11, -8.02, -5.97)),
        (6.0, 0.25 * np.pi, (-11.16, -9.02, -6.39, -5.02)),
        (10.0, 0.0, (-31.6, -22.5, -12.96, -8.73)),
    ],
)
def test_lowest_pressure(aspect_ratio: float, phase: float, lowest: tuple[float, ...]) -> None:
    # another code's, over K gamma_dot^n
    found = chain(aspect_ratio, phase, 1.0, 0.8, 0.5, 0.3)
    assert [0.5 * one.lowest for one in found] == pytest.approx(lowest, rel=0.02)
    if phase == 0.0:
        # on a ring off the tip, where nothing deforms and the melt is stiff
        angle, pressure = found[-1].meridian()
        assert found[-1].tip > 0.93 * found[-1].lowest
        assert 0.1 < aspect_ratio * abs(angle[np.argmin(pressure)]) < 0.6


@pytest.mark.slow
def test_the_spin_across_the_stretch() -> None:
    found = chain(6.0, 0.5 * np.pi, 1.0, 0.8, 0.5, 0.3)
    assert [one.spin for one in found] == pytest.approx([0.946, 0.954, 0.967, 0.977], abs=2e-3)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"azimuth": 3}, "azimuth = 3: must be even"),
        ({"order": 1}, "order"),
        ({"outer": 1.5}, "outer = 1.5"),
        ({"first_angle": 0.0}, "first_angle = 0"),
    ],
)
def test_elements_that_are_none_are_refused(change: dict[str, float], match: str) -> None:
    with pytest.raises(ConfigError, match=match):
        SpheroidNumerics(**change)  # type: ignore[arg-type]


@pytest.mark.parametrize("aspect_ratio", [0.5, 60.0])
def test_a_fiber_out_of_range_is_refused(aspect_ratio: float) -> None:
    with pytest.raises(ConfigError, match=f"aspect_ratio = {aspect_ratio:g}: .* 1 .* to 50"):
        solve_thinning_spheroid(Spheroid(1.0, aspect_ratio), Newtonian(1.0), 1.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "aspect_ratio", "rate", "degrees"),
    [
        (PowerLaw(1.0, 0.42), 3.0, 1.0, 38.0),
        (CarreauYasuda(10390.0, 0.35, 0.5), 6.0, 2.0, 0.0),
        (CarreauYasuda(10390.0, 0.35, 0.5), 4.5, 0.7, 52.0),
        (Cross(4628.0, 0.2694, 30820.0), 6.0, 20.0, 60.0),
    ],
)
def test_the_table_against_direct_solves(
    law: ViscosityLaw, aspect_ratio: float, rate: float, degrees: float
) -> None:
    # between the points of the table; the slope of the Carreau law alone is off by 0.3
    fiber, phase = Spheroid(1.0, aspect_ratio), float(np.radians(degrees))
    table = unbounded_thinning_spheroid(fiber, law, (0.1 * rate, 10.0 * rate))
    found = solve_thinning_spheroid(fiber, law, rate, phase)
    bound = table.pressure_error * float(np.max(table.largest))
    assert abs(table.omega(rate, phase) - found.spin) < table.spin_error
    assert abs(table.lowest_at(rate, phase) - found.lowest) < bound
    assert abs(-table.lowest_at(rate, phase + np.pi) - found.highest) < bound


@pytest.mark.slow
def test_the_shipped_table_is_what_its_script_makes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, values in (("ASPECT_RATIOS", (2.5,)), ("PHASES", (30.0,)), ("INDICES", (1.0, 0.75))):
        monkeypatch.setattr(spheroid_table, name, values)
    path = tmp_path / "table.csv"
    spheroid_table.make_table(path)
    made = path.read_text(encoding="utf-8")
    shipped = files("fibermelt.data").joinpath("thinning_spheroid.csv").read_text(encoding="utf-8")
    for row in csv.DictReader(made.splitlines()):
        key = f"{row['aspect_ratio']},{row['phase']},{row['index']},"
        (line,) = (line for line in shipped.splitlines() if line.startswith(key))
        numbers = [float(value) for value in line.split(",")]
        # the places of extremes are those of points that the surface is read at
        assert [float(value) for value in row.values()] == pytest.approx(
            numbers, rel=1e-5, abs=1e-5
        )
    # what is there already is not solved for again
    monkeypatch.setattr(spheroid_table, "_chain", lambda *_: pytest.fail("solved again"))
    spheroid_table.make_table(path)
    assert path.read_text(encoding="utf-8") == made
