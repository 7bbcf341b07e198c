"""The sensitivity studies' stages and their share of summary.json, on coarse cells."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr
from turned_fibers import PARAMETERS, compared, declared, turned

from fibermelt.engine.stages import Parameters
from fibermelt.paper.claims.printed import printed_period, printed_periods
from fibermelt.paper.dimensions.stages import feature_rows
from fibermelt.paper.dimensions.summary import dimensions_in_words, summarize_dimensions
from fibermelt.paper.orbits.part import PART
from fibermelt.paper.orbits.stages import orbit_cases
from fibermelt.paper.orbits.summary import orbits_in_words, summarize_orbits

ROUNDING = 1e-12

MU, RATE = PARAMETERS["law.viscosity"], PARAMETERS["sensitivity.shear_rate"]


@pytest.fixture(scope="module")
def orbits() -> xr.Dataset:
    return turned()


@pytest.fixture(scope="module")
def dimensions() -> xr.Dataset:
    return compared()


@pytest.fixture(scope="module")
def orbit_numbers(orbits: xr.Dataset) -> dict[str, Any]:
    return summarize_orbits(orbits)["orbits"]


@pytest.fixture(scope="module")
def dimension_numbers(dimensions: xr.Dataset) -> dict[str, Any]:
    return summarize_dimensions(dimensions)["dimensions"]


def _cases(numbers: dict[str, Any], sweep: str) -> list[dict[str, Any]]:
    return [case for case in numbers["cases"] if case["sweep"] == sweep]


def test_cases_are_the_base_and_each_value_once() -> None:
    cases = orbit_cases(declared(PART.brings[0].parameters))
    assert [case.sweep for case in cases] == [
        "base",
        *(3 * ["aspect_ratio"]),
        *(3 * ["shear_rate"]),
        *(2 * ["viscosity"]),
    ]
    assert cases[0] == ("base", 6.0, RATE, MU)
    assert cases[3] == ("aspect_ratio", 10.0, RATE, MU)
    assert cases[4] == ("shear_rate", 6.0, 0.5, MU)
    assert cases[7] == ("viscosity", 6.0, RATE, 400.0)


def test_unbounded_fibers_are_jefferys(orbit_numbers: dict[str, Any]) -> None:
    for case in orbit_numbers["cases"]:
        ratio, rate = case["aspect_ratio"], case["shear_rate"]
        jeffery, peak = case["ellipse"], case["viscosity"] * rate * (1.0 + ratio)
        assert jeffery["period"] == pytest.approx(2 * np.pi * (ratio + 1 / ratio) / rate, rel=1e-12)
        assert jeffery["min_pressure"] == pytest.approx(-peak, rel=ROUNDING)
        assert jeffery["max_pressure"] == pytest.approx(peak, rel=ROUNDING)
        assert jeffery["tip_min"] == pytest.approx(-peak, rel=ROUNDING)


def test_rate_and_viscosity_scale_the_confined_fiber(orbit_numbers: dict[str, Any]) -> None:
    base = orbit_numbers["cases"][0]
    mine = base["confined-ellipse"]
    for case in _cases(orbit_numbers, "shear_rate") + _cases(orbit_numbers, "viscosity"):
        found, scale = case["confined-ellipse"], case["shear_rate"] * case["viscosity"] / MU
        assert found["shape_factor"] == mine["shape_factor"]
        assert found["period"] * case["shear_rate"] == pytest.approx(mine["period"], rel=ROUNDING)
        for name in ("min_pressure", "max_pressure", "tip_min", "tip_max"):
            assert found[name] == pytest.approx(scale * mine[name], rel=ROUNDING)


def test_a_circle_is_given_one_angle_of_all(orbit_numbers: dict[str, Any]) -> None:
    circle = _cases(orbit_numbers, "aspect_ratio")[0]
    for model in ("confined-ellipse", "ellipse"):
        assert circle[model]["angle_at_min"] == 0.0
        assert circle[model]["where_at_min"] == pytest.approx(0.25 * np.pi)
    slender = _cases(orbit_numbers, "aspect_ratio")[2]["confined-ellipse"]
    assert slender["angle_at_min"] == pytest.approx(0.25 * np.pi, abs=1e-3)  # order 3
    assert slender["where_at_min"] == pytest.approx(0.0, abs=1e-3)


def test_turns_begin_along_the_flow_and_end_with_the_period(orbits: xr.Dataset) -> None:
    assert np.all(orbits["turn_time"][..., 0] == 0.0)
    assert np.all(orbits["turn_angle"][..., 0] == 0.0)
    assert orbits["turn_time"][..., -1].to_numpy() == pytest.approx(
        orbits["orbit_period"].to_numpy()
    )
    lowest = orbits["turn_lowest"].min(dim="instant").to_numpy()
    # the instants' spacing, as the unit tests of the turn derive it
    assert lowest == pytest.approx(orbits["orbit_lowest"].to_numpy(), rel=2e-3)


def test_pressure_around_the_fiber_is_lowest_where_the_orbit_says(orbits: xr.Dataset) -> None:
    sweep = orbits.isel(case=orbits["case_sweep"].to_numpy() == "aspect_ratio")
    expected = sweep["orbit_lowest"].sel(orbit_model="confined-ellipse").to_numpy()
    found = orbits["near_pressure"].min(dim=("ring", "ray")).to_numpy()
    # cells of order 3 are off by that much between nodes; the response is smoothed
    assert found == pytest.approx(expected, rel=3e-2)
    place = orbits["near_pressure"].isel(ring=0).argmin(dim="ray").to_numpy()
    for k, ray in enumerate(place):
        x, y = orbits["near_point"].to_numpy()[k, 0, ray]
        angle = float(orbits["near_angle"][k])
        lab = np.array(
            [x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)]
        )
        # along the stretching direction, which is 45 degrees to the flow
        assert abs(lab[0] * lab[1]) == pytest.approx(0.5, abs=0.02)
        assert lab[0] * lab[1] > 0.0


def test_table_1(orbit_numbers: dict[str, Any]) -> None:
    rows = orbit_numbers["periods"]
    assert [row["sweep"] for row in rows] == 3 * ["aspect_ratio"] + 3 * ["shear_rate"]
    for row in rows:
        assert row["jeffery"] == pytest.approx(row["paper_jeffery"], abs=0.006)  # to 0.01
        assert row["ours_above_jeffery"] == pytest.approx(row["ours"] / row["jeffery"] - 1.0)
        assert 0.009 < row["paper_above_jeffery"] < 0.035
    assert [row["paper"] for row in rows] == [12.87, 39.53, 65.34, 78.76, 39.53, 19.99]


def test_a_line_that_the_paper_has_not() -> None:
    rows = summarize_orbits(turned(aspect_ratios=(4.0,), shear_rates=(3.0,), viscosities=(1.0,)))[
        "orbits"
    ]
    assert [row["paper"] for row in rows["periods"]] == [None, None]
    assert [row["paper_above_jeffery"] for row in rows["periods"]] == [None, None]
    assert orbits_in_words({"orbits": rows})[4].split() == ["the", "paper", "none"]


def test_fibers_that_stall_have_no_period() -> None:
    results = turned(domain_size=4.0, aspect_ratios=(6.0,), shear_rates=(1.0,), viscosities=(1.0,))
    numbers = summarize_orbits(results)["orbits"]
    json.dumps(numbers, allow_nan=False)
    assert numbers["cases"][0]["confined-ellipse"]["period"] is None
    assert numbers["periods"][0]["ours"] is None
    assert orbits_in_words({"orbits": numbers})[3].split() == ["M", "=", "4", "none"]
    time = results["turn_time"].sel(orbit_model="confined-ellipse")
    assert float(time[0, -1]) == pytest.approx(2.0 * np.pi * (6.0 + 1.0 / 6.0))


def test_printed_periods() -> None:
    lines = printed_periods()
    assert len(lines) == 10
    for line in lines:
        exact = 2 * np.pi * (line.aspect_ratio + 1 / line.aspect_ratio) / line.shear_rate
        assert line.jeffery == pytest.approx(exact, abs=0.006)
    assert printed_period(6.0, 1.0) in lines
    assert printed_period(6.0, 1.1) is None


def test_peaks_are_closed_forms(dimensions: xr.Dataset) -> None:
    ratio = dimensions["peak_ratio"].to_numpy()
    ellipse = dimensions["peak_pressure"].sel(unbounded_model="ellipse").to_numpy()
    assert ratio[[0, -1]] == pytest.approx([1.0, 20.0])
    assert ellipse == pytest.approx(1.0 + ratio, rel=ROUNDING)
    spheroid = dimensions["peak_at_ratio"].sel(dimension_model="spheroid").to_numpy()
    # half the tip pressures in axisymmetric extension, -5 (exact), -31.067 and -63.034 (printed
    # to five digits), as the strain of a shear is half its rate
    assert spheroid == pytest.approx([2.5, 15.5335, 31.517], rel=2e-5)
    confined = dimensions["peak_at_ratio"].sel(dimension_model="confined-ellipse").to_numpy()
    assert confined[1] == pytest.approx(9.8359, rel=1e-2)  # order 3
    assert np.all(confined > 1.0 + dimensions["ratio"].to_numpy())


def test_no_fiber_is_below_its_bound(dimensions: xr.Dataset) -> None:
    lowest, bound = dimensions["feature_lowest"], dimensions["feature_bound"]
    slack = 1.0 + 1e-8  # the support function's table
    assert np.all(lowest >= slack * bound)
    extreme, limit = dimensions["feature_extreme"], dimensions["feature_extreme_bound"]
    assert np.all(extreme >= slack * limit)
    least = extreme.min(dim=("planar_angle", "location"))
    xr.testing.assert_allclose(least, lowest.min(dim="point"), rtol=ROUNDING)


def test_bounds_along_streamlines_are_the_peaks_in_shear(dimensions: xr.Dataset) -> None:
    """The made-up bead is sheared at every point, as the fibers of the peaks are."""
    peak = dimensions["peak_at_ratio"].sel(ratio=PARAMETERS["fiber.aspect_ratio"])
    unit = dimensions["feature_bound"].sel(dimension_model="ellipse") / float(
        peak.sel(dimension_model="ellipse")
    )
    for model in dimensions["dimension_model"].to_numpy():
        expected = unit * float(peak.sel(dimension_model=model))
        found = dimensions["feature_bound"].sel(dimension_model=model)
        assert found.to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-9)


def test_dimensions_in_numbers(dimension_numbers: dict[str, Any], dimensions: xr.Dataset) -> None:
    json.dumps(dimension_numbers, allow_nan=False)
    assert [row["aspect_ratio"] for row in dimension_numbers["peaks"]] == [1.0, 6.0, 10.0]
    for row in dimension_numbers["peaks"]:
        assert row["spheroid_over_ellipse"] == pytest.approx(row["spheroid"] / row["ellipse"])
    rows = dimension_numbers["streamlines"]
    assert len(rows) == 3 * 3 * 3  # streamlines, models, locations
    for row in rows:
        assert row["bound"] * (1.0 + 1e-8) <= row["lowest"] <= row["mean"] < 0.0
    first = dimensions["feature_extreme"].isel(feature=0).sel(location=1, dimension_model="ellipse")
    [row] = [r for r in rows if (r["streamline"], r["location"], r["model"]) == (4, 1, "ellipse")]
    assert row["lowest"] == float(first.min())
    assert row["mean"] == pytest.approx(float(first.mean()))


def test_words(orbit_numbers: dict[str, Any], dimension_numbers: dict[str, Any]) -> None:
    lines = orbits_in_words({"orbits": orbit_numbers})
    assert len(lines) == 1 + 4 + 4
    assert "-5.72 kPa unbounded" in lines[0]
    assert lines[1].split() == ["period", "[s]", "r_e", "1", "6", "10"]
    assert lines[2].split() == ["Jeffery", "12.57", "38.75", "63.46"]
    assert lines[-1].split() == ["the", "paper", "78.76", "39.53", "19.99"]
    lines = dimensions_in_words({"dimensions": dimension_numbers})
    assert "2.87 times" in lines[0]
    assert len(lines) == 1 + 3 * 3
    assert all(len(line) < 120 for line in lines)


def test_feature_streamlines() -> None:
    paper = (4, 10, 18)
    assert feature_rows((np.arange(22) + 0.5) / 22, paper) == [3, 9, 17]
    assert feature_rows((np.arange(22) + 0.5) / 22, (2, 30)) == [1]
    assert feature_rows(np.array([0.5]), paper) == [0]
    found = compared(count=2, model="spheroid", aspect_ratios=(6.0,))
    assert found["feature_streamline"].to_numpy().tolist() == [1, 2]


def test_the_studys_own_cell_is_taken() -> None:
    """A confined fiber that the study solved already is not solved again, nor differently."""
    from fibermelt.engine.quantities import labelled  # noqa: PLC0415
    from fibermelt.fiber import unbounded_ellipse  # noqa: PLC0415  stands in for a cell
    from fibermelt.fiber.shape import Ellipse  # noqa: PLC0415
    from fibermelt.paper.dimensions.stages import fiber_models  # noqa: PLC0415
    from fibermelt.study.quantities import QUANTITIES  # noqa: PLC0415

    response = unbounded_ellipse(Ellipse(1.0, 6.0))
    cell = labelled(
        {
            "fiber_model": "confined-ellipse",
            "aspect_ratio": 6.0,
            "shape_factor": 1.25,
            "surface_angle": response.surface,
            "surface_basis": response.basis,
        },
        QUANTITIES,
    )
    models = fiber_models(Parameters(PARAMETERS), cell, 4.0)
    assert [model.name for model in models] == ["confined-ellipse", "ellipse", "spheroid"]
    assert models[0].response.shape_factor == 1.25
