"""What the figures of a sweep are made of: tables, main effects, indices, and that they draw."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from swept_cases import GAP, GRID, NUMBERS, ONE_AT_A_TIME, SPEED, VISCOSITY, made_up, sampled

from fibermelt.errors import ConfigError, StoreError
from fibermelt.report.sweep.figures import effects_words, sweep_effects, sweep_plates
from fibermelt.report.sweep.maps import map_words, sweep_maps
from fibermelt.study.loading import load_study
from fibermelt.sweeps.analysis import effect, sobol_indices
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.responses import responses_of
from fibermelt.sweeps.table import sweep_table

LARGEST_INDEX_ERROR = 0.1
"""Of a Sobol index: twice the half 95 % interval that the bootstrap gives for these samples."""


def names(collected):
    return [plate.name for plate in sweep_plates(collected)]


def drawn(collected):
    """Draw every figure, and return the words of each by name."""
    words = {}
    for plate in sweep_plates(collected):
        FigureCanvasAgg(plate.draw(collected)).draw()
        words[plate.name] = plate.words(collected)
    return words


def test_a_table_has_units_that_people_write(tmp_path):
    table = sweep_table(made_up(tmp_path, GRID, NUMBERS))
    gap, viscosity = table.axes
    assert (gap.heading, viscosity.heading) == ("gap [mm]", "viscosity [Pa s]")
    assert gap.values == pytest.approx([2.5, 2.5, 3, 3, 4, 4])
    assert viscosity.values.tolist() == [400, 800] * 3
    contact, pressure, height = table.responses
    assert contact.values == pytest.approx(-1 - (gap.values - 2))
    assert (contact.unit, pressure.unit) == ("mm", "MPa")
    assert [one.varies for one in (contact, pressure, height)] == [True, True, False]
    assert table.point(1) == "gap 2.5 mm, viscosity 800 Pa s"


def test_degrees_have_a_zero_of_their_own(tmp_path):
    text = '"melt.temperature" = ["220 degC", "503.15 K"]'
    (temperature,) = sweep_table(made_up(tmp_path, text, {})).axes
    assert temperature.values == pytest.approx([220, 230], abs=1e-9)
    assert temperature.written(temperature.values[1]) == "230 °C"


def test_a_dataset_that_is_no_sweep_is_refused():
    with pytest.raises(StoreError, match="does not say what varied"):
        sweep_table(xr.Dataset({"status": ("case", ["done"])}))


def test_the_lowest_mean_extreme_leaves_flagged_streamlines_out():
    extreme = np.array([[[[-9e6, 1.0], [-8e6, 1.0]], [[-2e6, 1.0], [-3e6, 1.0]]]])
    collected = xr.Dataset(
        {
            "extreme_mean": (("case", "streamline", "location", "kind"), extreme),
            "near_singularity": (("case", "streamline"), [[1.0, 0.0]]),
        },
        {"location": [1, 2], "kind": ["min", "max"]},
    )
    found = {one.name: one.values.tolist() for one in responses_of(collected, ("case",))}
    assert found == {"lowest_mean_1": [-2.0], "lowest_mean_2": [-3.0]}


def test_a_moisture_that_no_drying_is_needed_for_is_saturation():
    worst, mean = [np.nan, np.nan, 1e-4], [1e-3, np.nan, 1e-4]
    collected = xr.Dataset(
        {
            "void_critical_moisture": ("case", worst),
            "void_critical_moisture_mean": ("case", mean),
            "void_saturation_moisture": ("case", [5e-3] * 3),
        }
    )
    found = responses_of(collected, ("case",))[0]
    np.testing.assert_allclose(found.values, [0.5, np.nan, 0.01])


def test_other_numbers_follow_where_few_are_known_but_no_parameter():
    numbers = {"shape_factor": [0.9, 0.95], "aspect_ratio": [4.0, 6.0], "unknowns": [9.0, 10.0]}
    collected = xr.Dataset({name: ("case", values) for name, values in numbers.items()})
    found = responses_of(collected, ("case",), ["fiber.aspect_ratio"])
    assert [one.title for one in found] == ["Shape factor B"]


def test_a_main_effect_is_the_mean_over_the_other_parameters(tmp_path):
    table = sweep_table(made_up(tmp_path, GRID, NUMBERS))
    levels, found = effect(table, table.responses[1], table.axes[0])
    mean = 0.5 * (400 + 800) * 1e-3 * (1 + 1 / levels)
    np.testing.assert_allclose(found, [mean, mean * 2 / 3, mean * 4 / 3], rtol=1e-12)


def test_failed_cases_do_not_pass_for_an_effect(tmp_path):
    # Without the case 4 mm, 800 Pa s the plain mean over the gap would fall by a third.
    numbers = {"inlet_pressure": ("Pa", lambda point: point[VISCOSITY])}
    table = sweep_table(made_up(tmp_path, GRID, numbers, failed={5}))
    _, found = effect(table, table.responses[0], table.axes[0])
    np.testing.assert_allclose(found[0], 400e-6, rtol=1e-12)


@pytest.mark.parametrize(
    ("failed", "gap", "viscosity"),
    [
        # 400 and 800 Pa s by column, 2.5, 3 and 4 mm by row; the response is 1 x gap + viscosity
        ({1, 2}, [np.nan, 803, 804], [404, 804]),  # two gaps at each viscosity
        ({1, 3, 5}, [402.5, 403, 404], [np.nan] * 2),  # one viscosity is missing
        ({1, 2, 4}, [np.nan, 803, 804], [np.nan] * 2),  # 2.5 at 400, 3 and 4 at 800
        ({1, 2, 4, 5}, [np.nan] * 3, [np.nan] * 2),  # 2.5 at 400, 3 at 800
    ],
)
def test_values_are_compared_where_all_else_is_the_same(tmp_path, failed, gap, viscosity):
    numbers = {"inlet_pressure": ("Pa", lambda at: 1e6 * (1e3 * at[GAP] + at[VISCOSITY]))}
    table = sweep_table(made_up(tmp_path, GRID, numbers, failed=failed))
    for axis, expected in zip(table.axes, (gap, viscosity), strict=True):
        mean = effect(table, table.responses[0], axis)[1][0]
        np.testing.assert_allclose(mean, expected, rtol=1e-12)


def test_a_figure_says_where_no_effect_can_be_told(tmp_path):
    numbers = {"inlet_pressure": ("Pa", lambda at: at[GAP] + at[VISCOSITY])}
    collected = made_up(tmp_path, GRID, numbers, failed={1, 2, 4, 5})
    figure = sweep_effects(collected)
    told = [text.get_text() for chart in figure.axes for text in chart.texts]
    assert told == ["cannot be told"] * 2
    words = effects_words(collected)
    assert "by what cannot be told" in words.alt
    assert "What gap or viscosity does cannot be told: no two cases" in words.caption
    assert "(of 6 cases 4 failed)" in words.caption
    assert "a factorial" in words.caption


def crosses(chart):
    """Where failed cases are marked in a chart."""
    return [x for line in chart.lines if line.get_marker() == "X" for x in line.get_xdata()]


def test_failed_cases_have_a_mark_of_their_own_and_are_counted(tmp_path):
    collected = made_up(tmp_path, GRID, NUMBERS, failed={1, 5})
    charts = sweep_effects(collected).axes
    assert [crosses(chart) for chart in charts[:2]] == [[2.5, 4.0], [800.0]]
    assert "Crosses: values with failed cases, 2 of 6 in all." in effects_words(collected).caption
    # A field for each case, the first parameter upwards: 2.5 and 4 mm at 800 Pa s.
    first = sweep_maps(collected).axes[0]
    at = [(x, y) for line in first.lines for x, y in line.get_xydata() if line.get_marker() == "X"]
    assert sorted(at) == [(1.0, 0.0), (1.0, 2.0)]
    assert "Grey: no answer, cross: failed (of 6 cases 2 failed)." in map_words(collected).caption
    whole = made_up(tmp_path, GRID, NUMBERS)
    assert "Crosses" not in effects_words(whole).caption
    assert "Grey" not in map_words(whole).caption


def test_what_is_not_told_from_zero_is_drawn_as_that(tmp_path):
    numbers = {
        "severity_melt": ("1", lambda point: 2e3 * (point[GAP] - 2.5e-3)),
        "severity_melt_error": ("1", lambda _: 0.25),
    }
    collected = made_up(tmp_path, GRID, numbers)
    assert "Dotted: below the numerical error" in effects_words(collected).caption
    (band,) = (patch for patch in sweep_effects(collected).axes[0].patches if patch.get_hatch())
    assert (band.get_y(), band.get_height()) == (-0.25, 0.5)
    told = [text.get_text() for text in sweep_maps(collected).axes[0].texts]
    assert told == ["< 0.3"] * 2 + ["1"] * 2 + ["3"] * 2


def test_keys_that_vary_together_are_one_parameter(tmp_path):
    text = f'"{SPEED}, {GAP}" = [["90 mm/s", "2.5 mm"], ["100 mm/s", "3 mm"]]\n"{VISCOSITY}" = [1]'
    caption = effects_words(made_up(tmp_path, text, NUMBERS)).caption
    assert "which of them moves a response cannot be told" in caption
    assert "vary together" not in effects_words(made_up(tmp_path, GRID, NUMBERS)).caption


def test_one_at_a_time_each_parameter_has_its_own_cases_and_the_study(tmp_path):
    table = sweep_table(made_up(tmp_path, ONE_AT_A_TIME, NUMBERS))
    assert table.groups == ((0, 1, 2, 3), (0, 4, 5))
    levels, (mean, least, most) = effect(table, table.responses[1], table.axes[1])
    assert levels.tolist() == [400, 800, 817]
    np.testing.assert_allclose(mean, levels * 1e-3 * (1 + 1 / 3), rtol=1e-12)
    assert (least.tolist(), most.tolist()) == (mean.tolist(), mean.tolist())
    assert (table.point(0), table.point(4)) == ("the study itself", "viscosity 400 Pa s")


@pytest.mark.parametrize("design", ["latin-hypercube", "saltelli"])
def test_indices_are_those_of_an_additive_response(tmp_path, design):
    # Var(x1 + 2 x2) of uniform shares: 1/5 and 4/5, first and total alike; the third has none.
    numbers = {
        "inlet_pressure": (
            "Pa",
            lambda point: (point[GAP] - 2.5e-3) / 1.5e-3 + 2 * (point[VISCOSITY] - 400) / 800,
        )
    }
    samples = 128 if design == "saltelli" else 512
    table = sweep_table(made_up(tmp_path, sampled(design, samples), numbers))
    found = sobol_indices(table, table.responses[0])
    assert found.cases == {"saltelli": 128 * 5, "latin-hypercube": 512}[design]
    np.testing.assert_allclose(found.first, [0.2, 0.8, 0.0], atol=LARGEST_INDEX_ERROR)
    assert (found.first_margin < LARGEST_INDEX_ERROR * 2).all()
    if design == "saltelli":
        np.testing.assert_allclose(found.total, [0.2, 0.8, 0.0], atol=LARGEST_INDEX_ERROR)
    else:
        assert found.total is None


def test_total_indices_tell_of_interactions(tmp_path):
    # Var of (x1 - 1/2)(x2 - 1/2): no first order at all, all of it total.
    numbers = {
        "inlet_pressure": ("Pa", lambda point: (point[GAP] - 3.25e-3) * (point[VISCOSITY] - 800))
    }
    table = sweep_table(made_up(tmp_path, sampled("saltelli", 256), numbers))
    found = sobol_indices(table, table.responses[0])
    np.testing.assert_allclose(found.first, 0.0, atol=2 * LARGEST_INDEX_ERROR)
    np.testing.assert_allclose(found.total, [1.0, 1.0, 0.0], atol=2 * LARGEST_INDEX_ERROR)


def test_a_failed_case_costs_its_block_and_no_more(tmp_path):
    table = sweep_table(made_up(tmp_path, sampled("saltelli", 32), NUMBERS, failed={7}))
    assert sobol_indices(table, table.responses[1]).cases == 31 * 5


@pytest.mark.parametrize(
    "text", [GRID, ONE_AT_A_TIME, sampled("sobol", 32), sampled("saltelli", 8)]
)
def test_no_indices_from_a_design_or_a_number_of_cases_that_cannot_give_them(tmp_path, text):
    collected = made_up(tmp_path, text, NUMBERS)
    table = sweep_table(collected)
    assert sobol_indices(table, table.responses[1]) is None
    assert "indices" not in names(collected)


def test_indices_are_the_same_each_time(tmp_path):
    table = sweep_table(made_up(tmp_path, sampled("saltelli", 16), NUMBERS))
    one, other = (sobol_indices(table, table.responses[1]) for _ in range(2))
    assert one.total_margin.tolist() == other.total_margin.tolist()


def test_a_saltelli_design_needs_a_power_of_two(tmp_path):
    path = tmp_path / "swept.toml"
    path.write_text(
        f'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n{sampled("saltelli", 100)}'
    )
    with pytest.raises(ConfigError, match=r"samples = 100: .* such as 64 or 128; .* 5 cases"):
        read_sweep(load_study(str(path)))


def test_a_grid_has_effects_and_maps(tmp_path):
    collected = made_up(tmp_path, GRID, NUMBERS, failed={5})
    words = drawn(collected)
    assert list(words) == ["effects", "maps"]
    assert "Contact point: −3 to −1.50 mm, most by gap." in words["effects"].alt
    assert "bead height" in words["effects"].caption
    assert "lowest −3 mm at gap 4 mm, viscosity 400 Pa s" in words["maps"].alt
    assert "no answer" in words["maps"].caption


def rising(part):
    """Return a bead height that rises by a part of itself over the viscosities of the grid."""
    return {"bead_height": ("m", lambda point: 3e-3 * (1 + part * (point[VISCOSITY] - 400) / 400))}


@pytest.mark.parametrize(
    ("tolerance", "part", "varies"),
    [(1e-7, 9e-7, False), (1e-7, 1.1e-6, True), (1e-6, 9e-6, False), (1e-12, 9e-7, False)],
)
def test_what_differs_by_the_tolerance_of_the_flow_is_the_same(tmp_path, tolerance, part, varies):
    text = f"{GRID}\n[numerics]\nflow_tolerance = {tolerance}"
    (height,) = sweep_table(made_up(tmp_path, text, rising(part))).responses
    assert height.varies == varies


def test_of_tolerances_that_vary_the_largest_counts(tmp_path):
    text = f'"numerics.flow_tolerance" = [1e-7, 1e-5]\n"{VISCOSITY}" = [400, 800]'
    (height,) = sweep_table(made_up(tmp_path, text, rising(9e-5))).responses
    assert not height.varies


ONE = f'"{GAP}" = {{ low = "2.5 mm", high = "4 mm" }}\ndesign = "sobol"\nsamples = 16\n'


@pytest.mark.parametrize("text", [GRID, ONE_AT_A_TIME, ONE, sampled("saltelli", 16)])
def test_no_axis_leaves_a_part_of_its_numbers_to_a_text_beside_it(tmp_path, text):
    """A small change of a large number, and a large one of a very small number."""
    numbers = {
        "inlet_pressure": ("Pa", lambda point: 4e6 * (1 + 1e-2 * point[GAP])),
        "void_critical_moisture_mean": ("1", lambda point: 1e-9 * point[GAP]),
    }
    collected = made_up(tmp_path, text, numbers)
    for plate in sweep_plates(collected):
        figure = plate.draw(collected)
        FigureCanvasAgg(figure).draw()
        for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
            assert axis.get_offset_text().get_text() == ""
            for tick in axis.get_major_ticks() if plate.name == "effects" else ():
                if tick.label1.get_visible():
                    # Three digits at least; what is drawn at 0 may be off by rounding.
                    told = float(tick.label1.get_text().replace("−", "-"))
                    assert told == pytest.approx(tick.get_loc(), rel=5e-3, abs=1e-15)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_one_parameter_alone_has_its_charts_over_the_whole_width(tmp_path, count):
    every = {
        "contact_point": NUMBERS["contact_point"],
        "inlet_pressure": ("Pa", lambda point: 1e8 * point[GAP]),
        "tip_pressure": ("1", lambda point: 1e3 * point[GAP]),
        "void_critical_moisture_mean": ("1", lambda point: point[GAP]),
    }
    collected = made_up(tmp_path, ONE, dict(list(every.items())[:count]))
    charts = sweep_effects(collected).axes
    assert len(charts) == max(count, 1)
    assert max(axes.get_position().x1 for axes in charts) > 0.95
    assert len({axes.get_position().y0 for axes in charts}) == (2 if count == 4 else 1)
    caption = effects_words(collected).caption
    assert "A point for each case." in caption


def test_one_at_a_time_has_effects_only(tmp_path):
    words = drawn(made_up(tmp_path, ONE_AT_A_TIME, NUMBERS))
    assert list(words) == ["effects"]
    assert "the diamond" in words["effects"].caption


def test_samples_have_their_spread_and_what_it_is_due_to(tmp_path):
    given = drawn(made_up(tmp_path, sampled("latin-hypercube", 80), NUMBERS))
    assert list(given) == ["effects", "quantiles", "indices"]
    assert "RBD-FAST" in given["indices"].caption
    assert "no total index" in given["indices"].caption
    whole = drawn(made_up(tmp_path, sampled("saltelli", 16), NUMBERS))
    assert "total index" in whole["indices"].caption
    assert "median" in whole["quantiles"].alt


def test_texts_and_more_parameters_than_fit_are_drawn(tmp_path):
    text = (
        '"fiber.model" = ["ellipse", "confined-ellipse"]\n"flow.capillary_width" = ["3 mm"]\n'
        '"flow.capillary_length" = ["5 mm"]\n"flow.taper_length" = ["7 mm"]\n'
        f'"{GAP}" = ["2.5 mm", "3.5 mm"]\n"{VISCOSITY}" = [400]\ndesign = "one-at-a-time"'
    )
    words = drawn(made_up(tmp_path, text, NUMBERS))
    assert list(words) == ["effects", "effects-2"]


def test_nothing_is_drawn_where_no_case_has_an_answer(tmp_path):
    assert names(made_up(tmp_path, GRID, NUMBERS, failed=set(range(6)))) == []


def test_a_process_window_is_drawn_as_such(tmp_path):
    text = (
        f'"{SPEED}, flow.inlet_speed" = [["25.4 mm/s", "6 mm/s"], ["101.6 mm/s", "24 mm/s"]]\n'
        f'"{GAP}" = ["2.5 mm", "3 mm"]'
    )
    numbers = {
        "void_critical_moisture": ("1", lambda point: 1e-6 / point[SPEED]),
        "void_critical_moisture_mean": ("1", lambda point: 2e-6 / point[SPEED]),
        "void_saturation_moisture": ("1", lambda point: 5e-3),
    }
    assert names(made_up(tmp_path, text, numbers)) == ["window", "effects", "maps"]
