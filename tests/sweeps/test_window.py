"""The process window: which sweeps have one, what it advises, what errors leave of contours."""

import numpy as np
import pytest
from figure_texts import shown
from matplotlib.backends.backend_agg import FigureCanvasAgg
from swept_cases import GAP, GRID, SPEED, VISCOSITY, made_up, sampled

from fibermelt.errors import ConfigError
from fibermelt.parts.voids.quantities import QUANTITIES
from fibermelt.report.sweep.window import contour_levels, figure_window, window_words
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.answer import answer_sweep
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.responses import LEADS
from fibermelt.sweeps.table import sweep_table
from fibermelt.sweeps.window import window_advice, window_of

SPEEDS_AND_GAPS = f"""
"flow.inlet_speed, {SPEED}" = [
    ["24 mm/s", "101.6 mm/s"], ["6 mm/s", "25.4 mm/s"], ["12 mm/s", "50.8 mm/s"],
]
"{GAP}" = ["3.5 mm", "2.5 mm"]
"""
"""Neither in rising order."""


def fibers(point):
    """What fibers add: nothing at the slowest speed, more from there on, less for wide gaps."""
    return max(0.0, 100.0 * (point[SPEED] - 0.03) * 3e-3 / point[GAP])


def severities(error=0.1):
    return {
        "severity_fibers": ("1", fibers),
        "severity_fibers_error": ("1", lambda point: error),
        "severity_melt": ("1", lambda point: 2.0 + 10.0 * point[SPEED]),
        "severity_melt_error": ("1", lambda point: 0.01),
    }


def drawn(collected):
    figure = figure_window(collected)
    FigureCanvasAgg(figure).draw()
    return figure


def marks(axes, marker):
    """Where cases are that are marked so, (across, up)."""
    return sorted(
        (float(line.get_xdata()[0]), float(line.get_ydata()[0]))
        for line in axes.lines
        if line.get_marker() == marker
    )


def test_responses_of_a_window_are_declared():
    assert all(QUANTITIES[name].response for name in LEADS[:3])
    assert all(f"{name}_error" in QUANTITIES for name in LEADS[:2])


def test_a_window_is_of_severity_with_its_cases_in_rising_order(tmp_path):
    numbers = {**severities(), "void_critical_moisture_mean": ("1", fibers)}
    window = window_of(sweep_table(made_up(tmp_path, SPEEDS_AND_GAPS, numbers)))
    assert [one.name for one in window.measures] == ["severity_fibers", "severity_melt"]
    # The sweep has (24, 3.5), (24, 2.5), (6, 3.5), ...; up are gaps, across are speeds.
    assert window.cases.tolist() == [[3, 5, 1], [2, 4, 0]]
    first = window.measures[0]
    assert window.over(first.values)[1] == pytest.approx(
        [fibers({SPEED: speed, GAP: 3.5e-3}) for speed in (0.0254, 0.0508, 0.1016)]
    )


def test_without_severity_it_is_of_what_the_sweep_is_about(tmp_path):
    numbers = {"void_critical_moisture_mean": ("1", lambda point: point[GAP])}
    window = window_of(sweep_table(made_up(tmp_path, GRID, numbers)))
    assert [one.name for one in window.measures] == ["void_critical_moisture_mean"]
    assert len(drawn(made_up(tmp_path, GRID, numbers)).axes) == 1


@pytest.mark.parametrize(
    ("table", "numbers", "failed"),
    [
        (sampled("latin-hypercube", 20), {"severity_fibers": ("1", lambda _: 1.0)}, ()),
        (f'"{GAP}" = ["2 mm", "3 mm"]', severities(), ()),
        (
            f'"{GAP}" = ["2 mm", "3 mm"]\n"fiber.model" = ["ellipse", "spheroid"]',
            {"severity_fibers": ("1", lambda _: 1.0)},
            (),
        ),
        (GRID, {"inlet_pressure": ("Pa", lambda point: point[GAP])}, ()),
        (SPEEDS_AND_GAPS, severities(), range(6)),
    ],
    ids=["samples", "one number", "a text", "no lead", "no answer"],
)
def test_another_sweep_is_no_window(tmp_path, table, numbers, failed):
    if SPEED not in table:
        numbers = {name: (unit, lambda _: 1.0) for name, (unit, _) in numbers.items()}
    collected = made_up(tmp_path, table, numbers, failed=failed)
    assert window_of(sweep_table(collected)) is None
    assert window_advice(sweep_table(collected)) == ""
    with pytest.raises(ConfigError, match="takes a grid over two numbers, and an answer"):
        figure_window(collected)


def test_a_single_value_beside_the_two_changes_nothing(tmp_path):
    table = f'"{VISCOSITY}" = [817]\n{SPEEDS_AND_GAPS}'
    window = window_of(sweep_table(made_up(tmp_path, table, severities())))
    assert window.cases.tolist() == [[3, 5, 1], [2, 4, 0]]


def test_what_an_error_does_not_tell_from_zero_is_not_detected(tmp_path):
    """Nothing at 6 mm/s; 1.78 at 12 mm/s and 3.5 mm is told by an error of 1, not of 2."""
    for error, count in ((1.0, 2), (2.0, 3)):
        table = sweep_table(made_up(tmp_path, SPEEDS_AND_GAPS, severities(error)))
        first = window_of(table).measures[0]
        assert np.count_nonzero(first.undetected) == count
        assert f"added by fibers: not detected in {count} of 6 cases, among them" in (
            window_advice(table)
        )
    collected = made_up(tmp_path, SPEEDS_AND_GAPS, severities(1.0))
    assert "from none detected (" in answer_sweep(collected)[0]
    text = [name for name, *_ in shown(drawn(collected))]
    assert text.count("< 1") == 2
    assert "melt alone: least, 2.25 ± 0.01, at inlet speed with bed speed 6 mm/s" in (
        window_words(collected).caption
    )


def test_it_is_not_detected_anywhere_below_its_error(tmp_path):
    collected = made_up(tmp_path, SPEEDS_AND_GAPS, severities(50.0))
    assert "Severity, added by fibers: not detected in any case." in answer_sweep(collected)[-1]
    drawn(collected)


def test_contours_are_no_closer_than_errors_tell_apart():
    values = np.array([[0.0, 3.0], [7.0, np.nan]])
    for error in (0.0, 0.4, 0.6, 1.7):
        levels = contour_levels(values, np.full(values.shape, error))
        assert len(levels) > 2
        assert np.diff(levels).min() >= 2 * error
        assert levels[0] <= 0.0
        assert levels[-1] >= 7.0
    # Two values are all that 7 is wide in errors of 5: no contour lies between the ends.
    assert len(contour_levels(values, np.full(values.shape, 5.0))) == 2
    assert len(contour_levels(np.zeros((2, 2)), np.zeros((2, 2)))) >= 2


def test_failed_cases_have_a_mark_of_their_own_and_are_counted(tmp_path):
    collected = made_up(tmp_path, SPEEDS_AND_GAPS, severities(), failed={0, 3})
    figure = drawn(collected)
    for axes in figure.axes:
        np.testing.assert_allclose(marks(axes, "X"), [(6.0, 2.5), (24.0, 3.5)])
        assert len(marks(axes, "o")) == 4
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words[:2] == ["computed", "failed"]
    assert "No answer: of 6 cases 2 failed." in window_words(collected).caption
    assert "No answer" not in window_words(made_up(tmp_path, GRID, severities_of_gap())).caption


def severities_of_gap():
    return {"severity_fibers": ("1", lambda point: 1e3 * point[GAP])}


def test_isolated_cases_are_marked_and_nothing_is_drawn_between(tmp_path):
    collected = made_up(tmp_path, SPEEDS_AND_GAPS, severities(), failed={1, 2, 4})
    assert [len(marks(axes, "o")) for axes in drawn(collected).axes] == [3, 3]


def test_what_differs_by_less_than_its_errors_is_the_same(tmp_path):
    numbers = {
        "severity_melt": ("1", lambda point: 3.0 + point[GAP]),
        "severity_melt_error": ("1", lambda _: 1e-3),
    }
    table = sweep_table(made_up(tmp_path, f'"{GAP}" = ["2 mm", "3.9 mm"]', numbers))
    assert not table.varying
    table = sweep_table(made_up(tmp_path, f'"{GAP}" = ["2 mm", "4.1 mm"]', numbers))
    assert [one.name for one in table.varying] == ["severity_melt"]


@pytest.mark.parametrize(
    ("name", "unit", "limit"),
    [("tip_pressure", "1", 0.01 * 2.5), ("inlet_pressure", "Pa", 1e-6 * 0.01)],
    ids=["a share of it", "in its unit, told in MPa"],
)
def test_a_limit_is_the_stated_error(tmp_path, name, unit, limit):
    numbers = {
        name: (unit, lambda point: 1e3 * point[GAP]),
        f"{name}_error": (unit, lambda _: 0.01),
    }
    responses = sweep_table(made_up(tmp_path, GRID, numbers)).responses
    (found,) = (one for one in responses if one.name == name)
    assert found.limit[0] == pytest.approx(limit)


def test_the_shipped_window_is_a_sweep_of_speed_and_gap():
    sweep = read_sweep(load_study("window"))
    assert sweep.shape == (3, 3)
    assert [axis.name for axis in sweep.axes] == [SPEED, GAP]
    for case in sweep.cases():
        assert case.config.flow.bead_height == pytest.approx(3e-3, rel=1e-12)
        assert CHAIN.asked(case.config.study.parts)
