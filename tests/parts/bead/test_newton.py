"""What a study by the paper's algorithm says of its cost, and when it is refused."""

from types import SimpleNamespace

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.history import FlowHistory
from fibermelt.parts.bead import newton
from fibermelt.parts.bead.newton import newton_motions
from fibermelt.study.loading import resolve


def history(points):
    time, none = np.linspace(0.0, 1.0, points), np.zeros((points, 2))
    return FlowHistory(time, none, none, np.zeros((points, 2, 2)), np.zeros(points))


def test_time_to_go_is_at_the_pace_so_far(monkeypatch):
    """A solve takes 2 s by the clock of this test, a streamline 600 s."""
    now = [0.0]

    def motion(half_length, melt, angle, guess):
        now[0] += 8.0
        free.solves += 4

    def follow(free, fiber, history, viscosity, angles):
        now[0] += 600.0
        return history

    monkeypatch.setattr(newton, "follow_newton", follow)
    free = SimpleNamespace(unknowns=7, solves=0, motion=motion)
    lines, histories = [], [history(50)] * 3
    angles = np.zeros(13)
    found = newton_motions(free, None, histories, 817.0, angles, lines.append, lambda: now[0])
    assert list(found) == histories
    # 8 solves for each of 13 angles at each of 150 points, of 2 s
    assert lines[0] == (
        "the paper's algorithm, 13 angles on 3 streamlines: up to 15600 solves of 7 unknowns, "
        'about 8.7 h; fiber.path = "superposition" takes seconds'
    )
    assert lines[1:] == [
        "streamline 1 of 3 done, about 20 min to go",
        "streamline 2 of 3 done, about 10 min to go",
        "streamline 3 of 3 done",
    ]


def test_superposition_is_the_default():
    assert resolve({}).fiber.path == "superposition"
    assert resolve({"fiber": {"path": "newton"}}).fiber.path == "newton"


@pytest.mark.parametrize(
    ("fiber", "message"),
    [
        ({"model": "ellipse"}, 'fiber.path = "newton": .*fiber.model = "ellipse" has not'),
        ({"model": "spheroid"}, 'fiber.path = "newton": .*fiber.model = "spheroid" has not'),
        ({"directions": "equal-area"}, 'fiber.directions = "equal-area"'),
    ],
)
def test_no_cell_to_work_on(fiber, message):
    with pytest.raises(ConfigError, match=message):
        resolve({"fiber": {"path": "newton", **fiber}})


def test_another_algorithm():
    with pytest.raises(ConfigError, match=r'fiber.path.*"superposition" or "newton"'):
        resolve({"fiber": {"path": "euler"}})
