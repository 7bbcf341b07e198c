"""What a script may hand over by mistake: each is refused by name, with what is expected."""

import numpy as np
import pytest

import fibermelt as fm

ELLIPSE = fm.Ellipse(42e-6, 6.0)
RESPONSE = fm.unbounded_ellipse(ELLIPSE)
HISTORY = fm.simple_shear(1.0, 2.0, 5)
MOTION = fm.follow(HISTORY, 0.9, fm.paper_angles())


class Solved:
    """A cell as `solve_cell` returns it: its response is what is worked with."""

    response = RESPONSE


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("flow.gap", lambda: fm.Nozzle(gap="3 mm")),
        ("flow.gap", lambda: fm.Nozzle(gap=np.array([3e-3]))),
        ("flow.bed_speed", lambda: fm.Deposition(fm.Nozzle(), fm.Newtonian(1.0), 1.0, "1 m/s")),
        ("melt.viscosity", lambda: fm.Newtonian("817 Pa s")),
        ("melt.viscosity", lambda: fm.surface_pressure(HISTORY, RESPONSE, "817", MOTION)),
        ("fiber.half_length", lambda: fm.Ellipse("42 um", 6.0)),
        ("fiber.aspect_ratio", lambda: fm.Ellipse(42e-6, None)),
        ("shear_rate", lambda: fm.orbit(RESPONSE, "1 1/s", 817.0)),
    ],
)
def test_what_is_no_number_is_refused_by_name(name, call):
    with pytest.raises(fm.ConfigError, match=f"^{name} = .*: must be one number, in SI; "):
        call()


def test_numbers_of_numpy_are_numbers():
    assert fm.Ellipse(np.float32(42e-6), np.int64(6)).aspect_ratio == 6


@pytest.mark.parametrize("value", [3.5, 1, 7])
def test_an_order_is_a_whole_number(value):
    with pytest.raises(fm.ConfigError, match=r"^numerics\.flow_order = .*a whole number$"):
        fm.FlowNumerics(order=value)


@pytest.mark.parametrize(
    "call",
    [
        lambda response: fm.surface_pressure(HISTORY, response, 817.0, MOTION),
        lambda response: fm.pressure_bounds(HISTORY, response, 817.0),
        lambda response: fm.orbit(response, 1.0, 817.0),
    ],
)
def test_a_cell_in_place_of_its_response(call):
    with pytest.raises(fm.ConfigError, match=r"of the type Solved, must be .*: give its \.resp"):
        call(Solved())
    with pytest.raises(fm.ConfigError, match=r"of the type Ellipse, must be FiberResponse$"):
        call(ELLIPSE)


def test_a_melt_in_place_of_a_nozzle():
    with pytest.raises(fm.ConfigError, match="nozzle is of the type Newtonian, must be Nozzle"):
        fm.Deposition(fm.Newtonian(817.0), fm.Nozzle())


def test_a_motion_along_another_path():
    with pytest.raises(fm.HistoryError, match="has 3 points, the motion was followed over 5"):
        fm.surface_pressure(fm.simple_shear(1.0, 2.0, 3), RESPONSE, 817.0, MOTION)


def test_a_history_of_lists():
    """A solver's output may be rows."""
    zero = np.zeros((2, 2))
    history = fm.FlowHistory([0, 1], zero.tolist(), zero, [[[0, 1], [0, 0]]] * 2, [0, 0])
    assert history.shear_rate == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("time", "ab", "no array of numbers"),
        ("time", 3.0, "shape"),
        ("time", [], "shape"),
        ("pressure", None, "no array of numbers"),
        ("position", [[0.0, 0.0], [1.0]], "no array of numbers"),
        ("gradient", np.zeros((2, 2, 2)) * 1j, "complex"),
    ],
)
def test_a_history_of_something_else(name, value, said):
    zero = np.zeros((2, 2))
    given = {
        "time": np.array([0.0, 1.0]),
        "position": zero,
        "velocity": zero,
        "gradient": np.zeros((2, 2, 2)),
        "pressure": np.zeros(2),
    }
    with pytest.raises(fm.HistoryError, match=f"^history: .*{said}"):
        fm.FlowHistory(**{**given, name: value})
