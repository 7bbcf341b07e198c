"""What a sweep comes to in a few sentences, of responses with known answers."""

import pytest
from swept_cases import GAP, GRID, ONE_AT_A_TIME, VISCOSITY, made_up, sampled

from fibermelt.study.sweep.answer import answer_sweep


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
