"""Stations of a flow that is not solved here, named as planes."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.errors import ConfigError
from fibermelt.history import FlowHistory
from fibermelt.parts.flow.imported import along_paths, stations

NOWHERE = {f"paths.{name}": "" for name in ("entrance", "exit", "end_of_swell")}


def straight(*ends: float) -> list[FlowHistory]:
    """Return paths at unit speed along x from zero to the ends [m]."""
    found = []
    for end in ends:
        time = np.linspace(0.0, end, 21)
        velocity = np.column_stack([np.ones(21), np.zeros(21)])
        position = np.column_stack([time, np.zeros(21)])
        found.append(FlowHistory(time, position, velocity, np.zeros((21, 2, 2)), 0.0 * time))
    return found


def named(histories: list[FlowHistory], **planes: str) -> dict[str, object]:
    values = {f"paths.{name}": text for name, text in planes.items()}
    return stations({**NOWHERE, **values}, histories, along_paths(histories))


def test_without_stations_nothing_rests_on_them() -> None:
    assert named(straight(1.0)) == {}


def test_stations_are_the_zones() -> None:
    found = named(straight(1.0, 2.0), entrance="x = 200 mm", exit="x = 0.6 m")
    assert found["zone"] == [1, 2]
    assert found["zone_time"] == pytest.approx(np.array([[0.2, 0.6]] * 2), abs=1e-14)
    found = named(straight(1.0), exit="x = 0.6 m", end_of_swell="x = 0.9 m")
    assert found["zone"] == [2, 3]


def test_a_path_that_ends_before_a_station() -> None:
    found = named(straight(0.3, 1.0), entrance="x = 0.2 m", exit="x = 0.6 m")
    assert np.isnan(found["zone_time"]).tolist() == [[False, True], [False, False]]
    short, whole = found["path_notes"]
    assert short.endswith("does not reach paths.exit")
    assert "reach" not in whole


@pytest.mark.parametrize(
    ("planes", "said"),
    [
        ({"exit": "x = 3 m"}, r'paths.exit = "x = 3 m": no path crosses it: .* 0 to 1 m along x'),
        ({"entrance": "z"}, r'paths.entrance = "z": .* planar'),
        ({"entrance": "x = 0.6 m", "exit": "x = 0.2 m"}, r"paths.exit .*path 1 .* paths.entrance"),
    ],
)
def test_what_is_no_station(planes: dict[str, str], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        named(straight(1.0), **planes)
