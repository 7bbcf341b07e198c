"""The figure of a population over the bead, and what a page tells of one that is weighed."""

import re

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from swept_cases import about, made_up

from fibermelt.report.sweep.figures import sweep_plates
from fibermelt.report.sweep.page import render_sweep
from fibermelt.report.sweep.population import figure_population, population_words
from fibermelt.report.sweep.tables import responses_told
from fibermelt.sweeps.analysis import quantiles
from fibermelt.sweeps.answer import answer_sweep
from fibermelt.sweeps.table import sweep_table

LINES, NEAR = 6, 1
"""Streamlines, and the one among them that passes a singular corner in one case."""

RATIO = "fiber.aspect_ratio"
TABLE = (
    f'"{RATIO}" = {{ scale = 7, shape = 2, between = [1, 50] }}\n'
    'design = "latin-hypercube"\nsamples = 32\n'
)
WEIGHED = f'{TABLE}weight = "{RATIO}"\n'
PIXEL = 1e-9
"""What is drawn is what was computed, but for rounding."""


def lowest(ratio, line, location):
    """Lowest pressure [Pa]: in proportion to the aspect ratio, and to the streamline's number."""
    return -1e5 * ratio * (1 + line) * location


def population(tmp_path, table=WEIGHED, failed=(), extreme=lowest):
    """Return a collected sweep of fibers over a bead."""
    numbers = {"tip_pressure": ("1", lambda point: 1 + point[RATIO])}
    collected = made_up(tmp_path, table, numbers, failed)
    ratios = collected[RATIO].to_numpy()
    values = np.full((len(ratios), LINES, 2, 2), np.nan)
    for line in range(LINES):
        for location in (1, 2):
            values[:, line, location - 1, 0] = extreme(ratios, line, location)
    flagged = np.zeros((len(ratios), LINES))
    flagged[3, NEAR] = 1.0
    values[[*failed]], flagged[[*failed]] = np.nan, np.nan
    over = ("case", "streamline")
    return collected.assign(
        extreme_mean=((*over, "location", "kind"), values, about("Pa")),
        near_singularity=(over, flagged, about()),
    ).assign_coords(streamline=1 + np.arange(LINES), location=[1, 2], kind=["min", "max"])


def charts(collected):
    figure = figure_population(collected)
    FigureCanvasAgg(figure).draw()
    return figure.axes


def test_lines_and_bands_are_the_quantiles_on_each_streamline(tmp_path):
    collected = population(tmp_path)
    ratio = collected[RATIO].to_numpy()
    for location, axes in enumerate(charts(collected), start=1):
        median, _, weighed = (line.get_ydata() for line in axes.lines)
        # A streamline that is left out parts the band in two.
        paths = axes.collections[0].get_paths()
        corners = np.concatenate([path.vertices[:, 1] for path in paths])
        for line in (0, 4, 5):
            expected = 1e-6 * quantiles(lowest(ratio, line, location))
            assert median[line] == pytest.approx(expected[1], rel=PIXEL)
            for edge in expected[[0, 2]]:
                assert np.abs(corners - edge).min() < PIXEL
            by_length = 1e-6 * quantiles(lowest(ratio, line, location), (0.5,), ratio)[0]
            assert weighed[line] == pytest.approx(by_length, rel=PIXEL)


def test_a_streamline_that_is_singular_in_one_case_is_a_diamond_and_sets_no_scale(tmp_path):
    def extreme(ratio, line, location):
        return lowest(ratio, line, location) * (1e3 if line == NEAR else 1)

    collected = population(tmp_path, extreme=extreme)
    axes = charts(collected)[0]
    median, diamond, _ = axes.lines
    assert np.flatnonzero(np.isnan(median.get_ydata())).tolist() == [NEAR]
    assert diamond.get_xdata().tolist() == [1 + NEAR]
    lowest_band = 1e-6 * quantiles(lowest(collected[RATIO].to_numpy(), LINES - 1, 2))[0]
    assert axes.get_ylim()[0] == pytest.approx(1.06 * lowest_band, rel=PIXEL)
    caption = population_words(collected).caption
    told = re.search(r"streamlines 2 \(medians off the scale: (−\d+) MPa at Loc\. 1 of 2", caption)
    middle = 1e-6 * quantiles(extreme(collected[RATIO].to_numpy(), NEAR, 1))[1]
    assert float(told[1].replace("−", "-")) == pytest.approx(middle, rel=0.01)


def test_words_say_what_a_case_counts_and_where_it_is_lowest(tmp_path):
    words = population_words(population(tmp_path, failed={0, 7}))
    assert "a population of 30 cases that differ in aspect ratio" in words.caption
    assert "Every case counts once." in words.caption
    assert "shares of the fiber length and volume" in words.caption
    assert "Loc. 2: the median is lowest on streamline 6" in words.alt
    assert "weighed" not in population_words(population(tmp_path, TABLE)).caption


def test_cases_that_differ_in_no_fiber_are_no_population(tmp_path):
    collected = population(tmp_path).rename({RATIO: "flow.gap"})
    collected.attrs["sweep"] = collected.attrs["sweep"].replace(RATIO, "flow.gap")
    caption = population_words(collected).caption
    assert ", over 32 cases that differ in gap: median" in caption
    assert "population" not in caption


def names(collected):
    return [plate.name for plate in sweep_plates(collected)]


def test_it_is_drawn_of_samples_that_have_an_answer_only(tmp_path):
    assert names(population(tmp_path)) == ["population", "effects", "quantiles"]
    assert names(population(tmp_path, failed=set(range(31)))) == []
    grid = f'"{RATIO}" = [4, 6]'
    assert "population" not in names(made_up(tmp_path, grid, {"tip_pressure": ("1", abs_of)}))
    without = population(tmp_path).drop_vars("extreme_mean")
    assert "population" not in names(without)


def abs_of(point):
    return point[RATIO]


def test_one_location_alone_is_no_population_figure(tmp_path):
    collected = population(tmp_path)
    assert isinstance(collected, xr.Dataset)
    assert "population" not in names(collected.isel(location=0))


def test_the_page_tells_quantiles_by_number_and_weighed(tmp_path):
    page = render_sweep(population(tmp_path)).decode()
    words = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))
    assert "Weibull, scale 7, shape 2, between 1 and 50 (98 % of it)" in words
    assert "each counted once: by number" in words
    assert "each weighed by its aspect ratio (of fibers of one width, shares of the" in words
    assert "Medians with each case weighed by its aspect ratio: " in page


def test_without_a_weight_every_quantile_is_by_number(tmp_path):
    plain = sweep_table(population(tmp_path, TABLE))
    assert plain.weighing is None
    assert responses_told(plain).count("Quantiles of the responses over the cases<") == 1


def test_the_answer_tells_both_medians_and_no_share_of_one_parameter(tmp_path):
    # 64 cases are enough for an index: of one parameter it would only say 1.
    collected = population(tmp_path, WEIGHED.replace("samples = 32", "samples = 64"))
    ratio = collected[RATIO].to_numpy()
    pressure = 1e-6 * lowest(ratio, LINES - 1, 2)
    number, length = (quantiles(pressure, (0.5,), weights)[0] for weights in (None, ratio))
    told = " ".join(answer_sweep(collected)).replace("−", "-")
    assert f"Half of the cases lie below {number:.3g} MPa, nine tenths between" in told
    assert f"; weighed by aspect ratio, half lies below {length:.3g} MPa." in told
    assert "Sobol index" not in told
