"""The process window: critical moistures of a collected sweep, the advice, the figure."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

from fibermelt.errors import ConfigError
from fibermelt.parts.voids.quantities import QUANTITIES
from fibermelt.report.sweep.window import figure_window, window_words
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.window import GAP, MEASURES, SPEED, critical_moistures, drying_advice

SATURATED = 0.005


def collected(worst, median=None):
    """A sweep over two speeds and three gaps."""
    worst = np.asarray(worst, dtype=float)
    median = np.full(worst.shape, 1e-4) if median is None else np.asarray(median)
    return xr.Dataset(
        {
            "void_critical_moisture": ((SPEED, GAP), worst),
            "void_critical_moisture_mean": ((SPEED, GAP), median),
            "void_saturation_moisture": ((SPEED, GAP), np.full(worst.shape, SATURATED)),
        },
        {SPEED: [0.01, 0.1], GAP: [2e-3, 3e-3, 4e-3]},
    )


MIXED = [[1e-4, 2e-4, np.nan], [0.0, 1e-5, 0.0]]
SLOW_ONLY = [[1e-4, 2e-4, 1.5e-4], [0.0, 0.0, 0.0]]


def test_measures_are_variables_of_every_case():
    assert all(QUANTITIES[name].dimensions == "" for name in MEASURES)


def test_axes_may_come_in_any_order():
    given = collected(SLOW_ONLY)
    for one in (given, given.transpose(GAP, SPEED)):
        worst, median = critical_moistures(one)
        assert worst.tolist() == SLOW_ONLY
        assert median.shape == (2, 3)


def test_nan_is_saturation_where_the_case_is_there_and_nothing_where_it_failed():
    worst, _ = critical_moistures(
        collected([[np.nan, np.nan, 0.0], [0.0] * 3], [[1e-4, np.nan, 1e-4], [1e-4] * 3])
    )
    assert worst[0, 0] == SATURATED
    assert np.isnan(worst[0, 1])


def test_advice_names_moisture_speed_and_gap_in_one_sentence():
    advice = drying_advice(collected(SLOW_ONLY))
    assert advice == (
        "Dry below 0.02 % and print at 10 mm/s and a gap of 3 mm to keep every fiber free of "
        "voids; from 100 mm/s on, drying alone does not do."
    )
    mixed = drying_advice(collected(MIXED, [[1e-4, 1e-4, np.nan], [1e-4] * 3]))
    assert mixed.endswith("a gap of 3 mm to keep every fiber free of voids.")
    assert drying_advice(collected(np.zeros((2, 3)))).startswith("No drying keeps every fiber")
    assert "no advice" in drying_advice(collected(np.full((2, 3), np.nan), np.full((2, 3), np.nan)))


def test_a_speed_is_hopeless_only_with_all_beyond_it():
    """From a slow one without an answer to its drying on, the advice gave up the fast ones too."""
    advice = drying_advice(collected(SLOW_ONLY[::-1]))
    assert advice.endswith("print at 100 mm/s and a gap of 3 mm to keep every fiber free of voids.")


def test_another_sweep_is_no_window():
    with pytest.raises(ConfigError, match=r"a process window is a sweep over flow\.bed_speed and"):
        critical_moistures(collected(SLOW_ONLY).isel({GAP: 0}))
    with pytest.raises(ConfigError, match='has no void_critical_moisture: name "voids"'):
        critical_moistures(collected(SLOW_ONLY).drop_vars("void_critical_moisture"))


def test_the_figure_shows_every_gap_and_says_what_to_do():
    given = collected(SLOW_ONLY)
    figure = figure_window(given)
    FigureCanvasAgg(figure).draw()
    first, second = figure.axes
    assert [line.get_label() for line in first.lines] == ["2", "3", "4"]
    assert first.lines[1].get_ydata() == pytest.approx([0.02, 0.0])
    assert len(second.lines) == 3
    words = window_words(given)
    assert drying_advice(given) in words.caption
    assert "between 0 and 0.02 %" in words.alt


@pytest.mark.parametrize(
    ("inlet", "told"),
    [
        (None, "the print, at one flux, for"),
        ([0.002, 0.02], "the print, with the flux in proportion, for"),
        ([0.002, 0.01], "the print, with a flux of its own for each, for"),
    ],
)
def test_the_caption_says_how_the_flux_follows_the_speed(inlet, told):
    """It said "in proportion" also of a sweep over the bed's speed alone."""
    given = collected(SLOW_ONLY)
    if inlet is not None:
        given = given.assign_coords({"flow.inlet_speed": (SPEED, inlet)})
    caption = window_words(given).caption
    assert told in caption
    assert "the viscosity is that of one rate" in caption
    given = given.assign_coords({"melt.viscosity": (SPEED, [900.0, 800.0])})
    assert "viscosity" not in window_words(given).caption


def test_the_shipped_window_is_a_sweep_of_speed_and_gap():
    sweep = read_sweep(load_study("window"))
    assert sweep.shape == (3, 3)
    assert [axis.name for axis in sweep.axes] == [SPEED, GAP]
    for case in sweep.cases():
        assert case.config.flow.bead_height == pytest.approx(3e-3, rel=1e-12)
        assert CHAIN.asked(case.config.study.parts)
