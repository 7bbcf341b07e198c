"""Distributions that a sweep samples: against scipy's, in their tails, and what is wrong with them.

The oracle is scipy.stats; the closed forms here are our own.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from fibermelt.errors import ConfigError
from fibermelt.study.loading import load_study
from fibermelt.sweeps.descriptions import distribution_told
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.distributions import (
    Histogram,
    Lognormal,
    Normal,
    Truncated,
    Uniform,
    Weibull,
)
from fibermelt.units import parse_difference

ROUNDING = 1e-12
"""A few thousand ulps: scipy's inverses and ours differ by the conditioning of the logarithm."""

SHARES = np.array([1e-9, 0.01, 0.05, 0.37, 0.5, 0.95, 0.999, 1 - 1e-9])

KNOWN = {
    "uniform": (Uniform(2.0, 5.0), stats.uniform(2.0, 3.0)),
    "normal": (Normal(6.0, 2.0), stats.norm(6.0, 2.0)),
    "lognormal": (Lognormal(6.0, 1.5), stats.lognorm(math.log(1.5), scale=6.0)),
    "weibull": (Weibull(7.0, 1.8), stats.weibull_min(1.8, scale=7.0)),
    "measured": (
        Histogram((1.0, 2.0, 4.0, 10.0), (10.0, 0.0, 30.0)),
        stats.rv_histogram((np.array([10, 0, 30]), np.array([1, 2, 4, 10])), density=False),
    ),
}
HISTOGRAM = KNOWN["measured"][0]


@pytest.mark.parametrize("name", KNOWN)
def test_shares_and_values_are_those_of_scipy(name):
    ours, theirs = KNOWN[name]
    values = theirs.ppf(SHARES)
    at = [ours.at(share) for share in SHARES]
    top = [ours.from_top(share) for share in SHARES]
    np.testing.assert_allclose(at, values, rtol=ROUNDING)
    np.testing.assert_allclose(top, theirs.isf(SHARES), rtol=ROUNDING)
    # 1e-7: near a share of 1 the value has half of the digits, so its share has as well.
    np.testing.assert_allclose([ours.below(value) for value in values], SHARES, rtol=1e-7)
    np.testing.assert_allclose([ours.above(value) for value in values], 1 - SHARES, atol=ROUNDING)


def test_what_has_no_values_below_zero_says_so():
    assert [Weibull(7.0, 1.8).below(value) for value in (-1.0, 0.0)] == [0.0, 0.0]
    assert [Lognormal(6.0, 1.5).above(value) for value in (-1.0, 0.0)] == [1.0, 1.0]


def test_fu_and_lauke_write_a_weibull_distribution_with_other_letters():
    a, b = 0.02, 2.3
    ours = Weibull(scale=a ** (-1 / b), shape=b)
    assert ours.below(5.0) == pytest.approx(1 - math.exp(-a * 5.0**b), rel=ROUNDING)


@pytest.mark.parametrize(
    ("share", "value"), [(0.125, 1.5), (0.25, 4.0), (0.625, 7.0), (1.0, 10.0), (0.0, 1.0)]
)
def test_a_histogram_is_uniform_inside_its_bins_and_never_in_an_empty_one(share, value):
    assert HISTOGRAM.at(share) == pytest.approx(value, rel=ROUNDING)


def test_a_histogram_ends_where_its_last_count_does():
    assert Histogram((0.0, 1.0, 2.0, 3.0), (0.0, 1.0, 0.0)).at(1.0) == 2.0


@pytest.mark.parametrize(("low", "high"), [(-1.0, 2.0), (0.5, 0.6), (6.0, 7.0), (-9.0, -8.0)])
def test_a_truncated_normal_is_exact_in_its_tails(low, high):
    ours = Truncated(Normal(0.0, 1.0), low, high)
    found = [ours.at(share) for share in SHARES]
    np.testing.assert_allclose(found, stats.truncnorm(low, high).ppf(SHARES), rtol=1e-11)


def test_a_truncated_weibull_is_exact_in_its_upper_tail():
    # Shape 1 is exponential and has no memory: cut off below, the rest is the same, moved.
    ours = Truncated(Weibull(1.0, 1.0), 30.0, 200.0)
    found = [ours.at(share) for share in SHARES]
    np.testing.assert_allclose(found, 30.0 - np.log1p(-SHARES), rtol=ROUNDING)


CUT = {name: Truncated(KNOWN[name][0], 3.0, 4.5) for name in ("normal", "lognormal", "weibull")}


@given(st.sampled_from(sorted(CUT)), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_a_truncated_distribution_keeps_its_bounds_its_order_and_its_shares(name, one, other):
    cut = CUT[name]
    least, most = sorted((one, other))
    assert 3.0 <= cut.at(least) <= cut.at(most) <= 4.5
    share = (cut.whole.below(cut.at(one)) - cut.whole.below(3.0)) / cut.kept
    assert share == pytest.approx(one, abs=1e-10)


def test_a_difference_of_temperatures_has_no_zero():
    assert parse_difference("10 degC", "K") == 10.0
    assert parse_difference("18 degF", "K") == pytest.approx(10.0, rel=ROUNDING)
    assert parse_difference("80 Pa s", "Pa s") == parse_difference(80, "Pa s") == 80.0


def swept(tmp_path, axes, rest='design = "latin-hypercube"\nsamples = 64'):
    path = tmp_path / "swept.toml"
    path.write_text(f'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n{axes}\n{rest}')
    return read_sweep(load_study(str(path)))


def ratios(found):
    return np.array([row["fiber.aspect_ratio"] for row in found.settings()])


def test_a_measured_and_a_weibull_population_are_sampled(tmp_path):
    counted = "{ edges = [2, 4, 6, 10], counts = [16, 32, 16] }"
    values = ratios(swept(tmp_path, f'"fiber.aspect_ratio" = {counted}'))
    # A Latin hypercube of 64 has one sample in each stratum: the very counts come back.
    assert np.histogram(values, [2, 4, 6, 10])[0].tolist() == [16, 32, 16]
    values = ratios(swept(tmp_path, '"fiber.aspect_ratio" = { scale = 7, shape = 2 }'))
    assert np.count_nonzero(values < 7) == math.floor(64 * (1 - math.exp(-1))) + 1


def test_values_have_the_units_of_what_varies(tmp_path):
    found = swept(
        tmp_path,
        '"fiber.half_length" = { edges = ["20 um", "40 um"], counts = [1] }\n'
        '"flow.gap" = { mean = "3 mm", std = "0.2 mm", between = ["2.8 mm", "3.2 mm"] }\n'
        '"melt.temperature" = { mean = "230 degC", std = "5 degC" }',
    )
    length, gap, temperature = (
        np.array([row[axis.name] for row in found.settings()]) for axis in found.axes
    )
    assert (length.min() > 20e-6, length.max() < 40e-6) == (True, True)
    assert (gap.min() >= 2.8e-3, gap.max() <= 3.2e-3) == (True, True)
    # One sample in each of 64 strata: mean and spread are off by less than a stratum's share.
    assert temperature.mean() == pytest.approx(503.15, abs=5 / 8)
    assert temperature.std() == pytest.approx(5.0, rel=1 / 8)


def test_a_sample_beyond_a_bound_says_how_to_cut_the_distribution_off(tmp_path):
    wide = "{ scale = 7, shape = 1"
    message = (
        r"of the sweep \(fiber\.aspect_ratio = 0\.\d+\): .* must be at least 1; "
        r'sweep\."fiber\.aspect_ratio" is a distribution: cut it off with \{ \.\.\., between = '
    )
    with pytest.raises(ConfigError, match=message):
        swept(tmp_path, f'"fiber.aspect_ratio" = {wide} }}').cases()
    cases = swept(tmp_path, f'"fiber.aspect_ratio" = {wide}, between = [1, 50] }}').cases()
    assert len(cases) == 64


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ({"scale": 7, "shape": 2}, "Weibull, scale 7, shape 2"),
        # exp(-1/49) lies above 1, next to nothing above 50.
        (
            {"scale": 7, "shape": 2, "between": [1, 50]},
            "Weibull, scale 7, shape 2, between 1 and 50 (98 % of it)",
        ),
        ({"edges": [2, 4, 10], "counts": [3, 1]}, "measured, 2 bins from 2 to 10"),
        ({"from": 2, "to": 4, "count": 3}, ""),
        ([2, 4], ""),
    ],
)
def test_a_distribution_is_told_as_the_study_has_it(entry, told):
    assert distribution_told("fiber.aspect_ratio", entry) == told


AXIS = '"fiber.aspect_ratio" = {{ {} }}'
WRONG = [
    ("scale = 7, shape = 0", r"shape = 0: must be above 0"),
    ("scale = -7, shape = 2", r"scale = -7: must be above 0"),
    ("scale = 7, shape = 0.01", r"shape = 0\.01: must be from 0\.1 to 1000"),
    ("median = 6, factor = 0.5", r"factor = 0\.5: must be above 1"),
    ("median = 6, factor = -1", r"factor = -1: must be above 1"),
    ("median = 0, factor = 2", r"median = 0: must be above 0"),
    ("mean = 6, std = 0", r"std = 0: must be above 0"),
    ("low = 6, high = 6", r"high = 6: must be above low"),
    ("edges = [2, 4, 4], counts = [1, 1]", r"edges: 4 after 4: must rise from bin to bin"),
    ("edges = [2, 4], counts = [1, 1]", r"2 edges and 2 counts: each bin has a count"),
    ("edges = [2], counts = []", r"1 edges and 0 counts"),
    ("edges = [2, 4, 6], counts = [1, -1]", r"counts: -1: must be at least 0"),
    ("edges = [2, 4, 6], counts = [0, 0]", r"counts are all 0: at least one bin"),
    ("edges = 2, counts = [1]", r"edges = 2: must be a list of values"),
    ('edges = [2, "4 mm"], counts = [1]', r'edges: item 2 = "4 mm" has the unit "mm"'),
    ("mean = 6, std = 2, between = [8, 4]", r"between = \[8, 4\]: must be two values, the lower"),
    ("mean = 6, std = 2, between = 8", r"between = 8: must be a list"),
    ("mean = 6, std = 0.1, between = [8, 9]", r"leaves .*e-89 of the distribution, at least 1e-06"),
    ("low = 2, high = 4, between = [1, 3]", r"has low and high already: leave between away"),
    ("mean = 6, factor = 2", r"has mean, factor: a range is .*\{ scale, shape \} or \{ edges"),
]


@pytest.mark.parametrize(("entry", "message"), WRONG)
def test_what_is_wrong_with_a_distribution_is_said_in_one_line(tmp_path, entry, message):
    with pytest.raises(ConfigError, match=message) as raised:
        swept(tmp_path, AXIS.format(entry))
    assert len(str(raised.value).splitlines()) == 1


def test_a_sobol_sequence_needs_a_power_of_two(tmp_path):
    axes = AXIS.format("low = 2, high = 10")
    message = r"samples = 100: a Sobol sequence needs a power of two, such as 64 or 128; a Latin"
    with pytest.raises(ConfigError, match=message):
        swept(tmp_path, axes, 'design = "sobol"\nsamples = 100')
    assert len(swept(tmp_path, axes, 'design = "sobol"\nsamples = 128').settings()) == 128


@pytest.mark.parametrize(
    ("axes", "rest", "message"),
    [
        (
            AXIS.format("low = 2, high = 10"),
            'design = "sobol"\nsamples = 4\nweight = "flow.gap"',
            r'weight = "flow\.gap": must be one of the keys that are sampled, such as fiber\.asp',
        ),
        (
            '"flow.gap" = ["3 mm"]',
            'weight = "flow.gap"',
            r'weight = "flow\.gap": design = "grid", which is .*, has no population .*, or leave',
        ),
        (
            '"flow.gap" = ["3 mm"]',
            'weight = "flow.gap"\ndesign = "one-at-a-time"',
            r'weight = "flow\.gap": design = "one-at-a-time" has no population .* take design',
        ),
        (
            '"numerics.contact_guess" = { low = "-1 mm", high = "1 mm" }',
            'design = "sobol"\nsamples = 4\nweight = "numerics.contact_guess"',
            r"is -0\.\d+ in case \d: a weight must be above 0",
        ),
    ],
)
def test_cases_are_weighed_by_what_is_sampled_and_positive(tmp_path, axes, rest, message):
    with pytest.raises(ConfigError, match=message):
        swept(tmp_path, axes, rest).cases()
