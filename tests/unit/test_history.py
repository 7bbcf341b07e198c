"""Flow histories: what they take over, and what they refuse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fibermelt.errors import HistoryError
from fibermelt.fiber import follow
from fibermelt.history import FlowHistory, simple_shear

PLAIN = {
    "time": [0, 1, 3],
    "position": [[0, 0]] * 3,
    "velocity": [[0, 0]] * 3,
    "gradient": [[[0, 2], [0, 0]]] * 3,
    "pressure": [0, 0, 0],
}


def test_lists_of_integers_are_taken() -> None:
    history = FlowHistory(**PLAIN)
    assert len(history) == 3
    assert history.shear_rate == pytest.approx([2.0, 2.0, 2.0])
    assert all(getattr(history, name).dtype == np.float64 for name in PLAIN)


def test_what_a_history_was_made_of_may_change_afterwards() -> None:
    time = np.array([0.0, 1.0, 3.0])
    history = FlowHistory(**{**PLAIN, "time": time})
    time[:] = 0.0
    assert history.time.tolist() == [0.0, 1.0, 3.0]


@pytest.mark.parametrize("name", list(PLAIN))
def test_a_history_and_a_bundle_stay_as_they_are(name: str) -> None:
    # `follow` keeps the last path's map for the next set of angles: it must not go stale
    history = simple_shear(1.0, 3.0, 4)
    for kept in (history, FlowHistory.stack([history, history])):
        with pytest.raises(ValueError, match="read-only"):
            getattr(kept, name)[...] = 0.0


def test_a_history_with_another_gradient_is_another() -> None:
    history = simple_shear(1.0, 3.0, 4)
    faster = replace(history, gradient=2.0 * history.gradient)
    slow, fast = (follow(one, 0.9, np.array([0.3])).angle[0, -1] for one in (history, faster))
    long = follow(simple_shear(1.0, 6.0, 4), 0.9, np.array([0.3])).angle[0, -1]
    assert fast == pytest.approx(long, abs=1e-12)  # twice the rate for half the time: rounding
    assert abs(fast - slow) > 0.1


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("time", "soon", "history: time is no array of numbers"),
        ("pressure", [[0, 0], [0]], "history: pressure is no array of numbers"),
        ("time", 1.0, r"history: time has shape \(\), expected \(1,\)"),
        ("time", [0.0], r"history: position has shape \(3, 2\), expected \(1, 2\)"),
        ("time", [0.0, 1.0, 1.0], r"time\[2\] = 1 s follows 1 s"),
        ("time", [0.0, 2.0, 1.0], r"time\[2\] = 1 s follows 2 s"),
        ("time", [0.0, 1.0, np.inf], r"time\[2\] = inf is not finite"),
        ("velocity", [[0, 0]] * 2, r"velocity has shape \(2, 2\), expected \(3, 2\)"),
        ("gradient", [[[1, 0], [0, 0]]] * 3, r"gradient\[0\] has trace 1 1/s"),
    ],
)
def test_what_no_history_can_be(name: str, value: object, message: str) -> None:
    with pytest.raises(HistoryError, match=message):
        FlowHistory(**{**PLAIN, name: value})


@pytest.mark.parametrize(
    ("duration", "points", "message"),
    [(1.0, 0, "0 points of time"), (1.0, 1, "1 points of time"), (0.0, 5, "follows 0 s")],
)
def test_a_shear_without_time(duration: float, points: int, message: str) -> None:
    with pytest.raises(HistoryError, match=message):
        simple_shear(1.0, duration, points)
