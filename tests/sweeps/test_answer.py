"""What a sweep comes to in a few sentences, of responses with known answers."""

import re

import pytest
from swept_cases import GAP, GRID, ONE_AT_A_TIME, SPEED, VISCOSITY, made_up, sampled

from fibermelt.report.sweep.sampled import quantile_words
from fibermelt.sweeps.answer import answer_sweep


def pressure(point):
    """Ten times as strong in the viscosity as in the gap [Pa]."""
    return 1e3 * point[VISCOSITY] + 4e7 * point[GAP]


INLET = {"inlet_pressure": ("Pa", pressure)}


def test_a_grid_tells_its_range_and_what_moves_it_most_first(tmp_path):
    first, second = answer_sweep(made_up(tmp_path, GRID, INLET))
    assert first == (
        "Inlet pressure: from 0.5 MPa (gap 2.5 mm, viscosity 400 Pa s) to 0.96 MPa "
        "(gap 4 mm, viscosity 800 Pa s)."
    )
    # Means over the other parameter: gaps have a mean of 9.5 / 3 mm, viscosities of 600 Pa s.
    assert second == (
        "What moves it, mean over the others, the strongest first: viscosity from 400 Pa s to "
        "800 Pa s: 0.527 MPa to 0.927 MPa; gap from 2.5 mm to 4 mm: 0.7 MPa to 0.76 MPa."
    )


def test_one_at_a_time_is_no_mean(tmp_path):
    _, second = answer_sweep(made_up(tmp_path, ONE_AT_A_TIME, INLET))
    assert second.startswith("What moves it, the strongest first: viscosity from 400 Pa s")


@pytest.mark.parametrize(
    ("rest", "function", "sentences"),
    [
        ("", lambda point: 4e7 * point[GAP], 1),
        ("", lambda point: -4e7 * point[GAP], 1),
        ("", lambda point: 1e12 * (point[GAP] - 2.9e-3) ** 2, 2),  # lowest in the middle
        ('design = "one-at-a-time"', lambda point: 1e12 * (point[GAP] - 3e-3) ** 2, 2),
    ],
)
def test_one_parameter_is_told_once(tmp_path, rest, function, sentences):
    text = f'"{GAP}" = ["2.5 mm", "2.9 mm", "4 mm"]\n{rest}'
    told = answer_sweep(made_up(tmp_path, text, {"inlet_pressure": ("Pa", function)}))
    assert len(told) == sentences
    assert told[0].startswith("Inlet pressure: from ")
    assert all(one.startswith("With gap from 2.5 mm to 4 mm: ") for one in told[1:])


def test_voids_come_before_pressures(tmp_path):
    numbers = {**INLET, "void_critical_moisture_mean": ("1", lambda point: point[GAP])}
    first, *_ = answer_sweep(made_up(tmp_path, GRID, numbers))
    assert first.startswith("Critical moisture, median fiber: from 0.25 % (gap 2.5 mm")


def test_failed_cases_are_counted(tmp_path):
    first, *_ = answer_sweep(made_up(tmp_path, GRID, INLET, failed=(0, 1)))
    assert first.endswith("; 2 of 6 cases have none.")


def test_samples_tell_quantiles_and_what_the_variance_is_due_to(tmp_path):
    _, second = answer_sweep(made_up(tmp_path, sampled("saltelli", 64), INLET))
    assert second.startswith("Half of the cases lie below ")
    assert "viscosity accounts for most of that (total Sobol index" in second


@pytest.mark.parametrize(
    ("numbers", "failed", "told"),
    [
        (INLET, range(6), "No case has an answer yet."),
        (
            {"inlet_pressure": ("Pa", lambda _: 1.0)},
            (),
            "The same in all 6 cases that have an answer: inlet pressure.",
        ),
        (INLET, range(1, 6), "One case has an answer: there is nothing to compare it with."),
    ],
)
def test_what_has_no_answer_says_so(tmp_path, numbers, failed, told):
    (only,) = answer_sweep(made_up(tmp_path, GRID, numbers, failed=failed))
    assert only.startswith(told)


@pytest.mark.parametrize(
    ("table", "failed", "reason"),
    [
        (
            sampled("saltelli", 8),
            (),
            "no Sobol indices, which need 16 blocks of 5 cases that all have an answer: 8 of 8 are "
            "such; take more samples.",
        ),
        (
            sampled("saltelli", 16),
            (3, 4, 60),
            "blocks of 5 cases that all have an answer: 14 of 16 are such; finish the sweep, see "
            "why cases failed, or take more samples.",
        ),
        (
            sampled("latin-hypercube", 40),
            (0,),
            "no Sobol indices, which need 64 cases with an answer: 39 of 40 have one; take more "
            "samples.",
        ),
        (sampled("sobol", 64), (0,), "63 of 64 have one; finish the sweep, see why"),
    ],
)
def test_samples_that_are_too_few_for_indices_say_so(tmp_path, table, failed, reason):
    collected = made_up(tmp_path, table, INLET, failed=failed)
    _, second = answer_sweep(collected)
    assert reason in second
    caption = quantile_words(collected).caption
    assert " No Sobol indices, which need " in caption
    assert reason.removeprefix("no ") in caption


def test_responses_that_lack_more_answers_than_others_are_named(tmp_path):
    # Without a void there is no moisture: too few cases have one, and all have a pressure.
    numbers = {
        **INLET,
        "void_critical_moisture_mean": (
            "1",
            lambda point: point[GAP] if point[VISCOSITY] > 800 else float("nan"),
        ),
    }
    caption = quantile_words(made_up(tmp_path, sampled("sobol", 64), numbers)).caption
    assert "Critical moisture, median fiber: no Sobol indices, which need 64 cases" in caption
    assert "with an answer: 32 of 64 have one" in caption
    assert "Inlet pressure:" not in caption


def test_enough_samples_give_no_reason(tmp_path):
    collected = made_up(tmp_path, sampled("sobol", 64), INLET)
    assert "no Sobol" not in "".join(answer_sweep(collected))
    assert "no Sobol" not in quantile_words(collected).caption


SPREAD = f'"{GAP}" = {{ low = "2 mm", high = "3 mm" }}\ndesign = "latin-hypercube"\nsamples = 20\n'


def stepped(share):
    """Return a moisture that is nothing for a share of the gaps, and follows the others."""
    return lambda point: max(0.0, point[GAP] - (2 + share) * 1e-3)


@pytest.mark.parametrize(
    ("function", "told"),
    [
        (stepped(0.7), "70 % of the cases lie at 0 %, the lowest value, nine tenths between 0 %"),
        (stepped(0.3), "Half of the cases lie below 0.0"),
        (lambda point: min(point[GAP], 2.2e-3), "80 % of the cases lie at 0.22 %, the highest"),
        (lambda point: sorted((2.2e-3, point[GAP], 2.8e-3))[1], "Half of the cases lie below 0.2"),
        (
            lambda point: 2.4e-3 if 2.2e-3 < point[GAP] < 2.8e-3 else point[GAP],
            "Half of the cases lie at or below 0.24 %",
        ),
    ],
)
def test_what_many_cases_share_is_not_what_half_lie_below(tmp_path, function, told):
    numbers = {"void_critical_moisture_mean": ("1", function)}
    _, second = answer_sweep(made_up(tmp_path, SPREAD, numbers))
    assert second.startswith(told)


def test_weighed_cases_share_by_weight(tmp_path):
    # Gaps from 2 to 2.7 of 3 mm hold 3.29 / 5 of all; a sample is off by a stratum of 20 at most.
    numbers = {"void_critical_moisture_mean": ("1", stepped(0.7))}
    _, second = answer_sweep(made_up(tmp_path, f'{SPREAD}weight = "{GAP}"', numbers))
    share = float(re.search(r"; weighed by gap, ([\d.]+) % lies at 0 %, the lowest", second)[1])
    assert share == pytest.approx(65.8, abs=100 / 20)


SPEEDS = f"""
"{GAP}" = ["2.5 mm", "3 mm", "4 mm"]
"{SPEED}" = ["90 mm/s", "100 mm/s", "110 mm/s"]
"""


def test_what_cases_differ_in_besides_is_no_effect(tmp_path):
    """Of three with an answer no two share gap or speed: each could be what moves it."""
    numbers = {"inlet_pressure": ("Pa", lambda point: 1e8 * point[GAP] + 1e7 * point[SPEED])}
    collected = made_up(tmp_path, SPEEDS, numbers, failed={1, 2, 3, 5, 6, 7})
    first, second = answer_sweep(collected)
    assert first.startswith("Inlet pressure: from 1.15 MPa (gap 2.5 mm, bed speed 90 mm/s) to ")
    assert second == (
        "What gap or bed speed alone would do cannot be told: no two cases that have an answer are "
        "alike in all else that varies, so that what differs besides may be what moves it (of 9 "
        "cases 6 failed). See why cases have none; take ranges of which every combination has an "
        "answer (a factorial); or, where only some combinations can be printed, vary what belongs "
        'together as one parameter, as in "flow.gap, flow.bed_speed" = [...].'
    )


def test_an_effect_is_told_over_the_values_that_share_the_rest(tmp_path):
    """Gaps of 2.5 and 3 mm at one speed, and 4 mm at another: the last is no part of the effect."""
    numbers = {"inlet_pressure": ("Pa", lambda point: 1e8 * point[GAP] + 1e7 * point[SPEED])}
    _, second = answer_sweep(made_up(tmp_path, SPEEDS, numbers, failed={1, 2, 4, 5, 6, 7}))
    assert second.startswith(
        "With gap from 2.5 mm to 3 mm: 1.15 MPa to 1.2 MPa. What bed speed alone would do cannot "
        "be told: no two cases that have an answer are alike in all else that varies"
    )


def test_an_effect_below_the_error_is_none_that_is_told(tmp_path):
    numbers = {
        "severity_fibers": ("1", lambda point: point[VISCOSITY] / 400 + 40 * point[GAP]),
        "severity_fibers_error": ("1", lambda _: 0.05),
    }
    second = answer_sweep(made_up(tmp_path, GRID, numbers))[1]
    assert second == (
        "With viscosity from 400 Pa s to 800 Pa s: 1.13 to 2.13. By gap it changes by less than "
        "its numerical error."
    )
