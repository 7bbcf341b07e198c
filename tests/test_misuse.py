"""What a script may hand over by mistake: each is refused by name, with what is expected."""

import numpy as np
import pytest

import fibermelt as fm
from fibermelt import fiber
from fibermelt.fiber.shape import jeffery_factor
from fibermelt.flow.deposition import FlowSolution
from fibermelt.orientation import shape_factor

PARTS = ("time", "position", "velocity", "gradient", "pressure")
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


@pytest.mark.parametrize(
    ("value", "what"), [(3.5, "a whole number"), (1, "at least 2"), (7, "at most 6")]
)
def test_an_order_is_a_whole_number(value, what):
    with pytest.raises(fm.ConfigError, match=rf"^numerics\.flow_order = .*must be {what}$"):
        fm.FlowNumerics(flow_order=value)


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


@pytest.mark.parametrize(
    ("said", "call"),
    [
        ("fiber.domain_size = '4': must be one number", lambda: fm.solve_cell(ELLIPSE, "4")),
        ("fiber is of the type str, must be Ellipse", lambda: fm.solve_cell("fiber", 4.0)),
        ("solution is of the type str", lambda: fm.trace_streamlines("flow")),
        ("closure is of the type NoneType, must be str", lambda: fm.closure(None)),
        ("initial_angles is no array of numbers", lambda: fm.follow(HISTORY, 0.9, ["0 deg"])),
        ("shape_factor = '0.9': must be one number", lambda: fm.follow(HISTORY, "0.9", [0.0])),
        (
            "path is of the type Solved, must be FlowHistory",
            lambda: fm.follow(Solved(), 0.9, [0.0]),
        ),
        ("histories is of the type FlowHistory", lambda: fm.FlowHistory.stack(HISTORY)),
        (r"count = 2.5: must be a whole number of at least 1", lambda: fm.isotropic_angles(2.5)),
        (r"count = True: must be a whole number", lambda: fm.isotropic_angles(True)),
        (r"points = 2.5: must be a whole number", lambda: fm.simple_shear(1.0, 1.0, 2.5)),
        ("shear_rate = np.timedelta64", lambda: fm.orbit(RESPONSE, np.timedelta64(1, "s"), 817.0)),
        ("fiber.half_length = True", lambda: fm.Ellipse(True, 6.0)),
        ("folgar-tucker: interaction = '0.01'", lambda: fm.FolgarTucker(0.9, "0.01")),
        (
            "closure is of the type str: must be one",
            lambda: fm.steady_state(fm.FolgarTucker(0.9, 0.01), [[0, 1], [0, 0]], "ORE"),
        ),
        (
            "model is of the type str",
            lambda: fm.follow_orientation("rsc", fm.closure("ORE"), HISTORY, np.eye(3) / 3),
        ),
        (
            "history is of the type str",
            lambda: fm.follow_orientation(
                fm.FolgarTucker(0.9, 0.01), fm.closure("ORE"), "path", np.eye(3) / 3
            ),
        ),
        ("problem is of the type Nozzle", lambda: fm.solve_deposition(fm.Nozzle())),
        ("numerics.edge_growth = '0.3'", lambda: fm.FlowNumerics(edge_growth="0.3")),
    ],
)
def test_what_is_of_another_kind_is_refused_by_name(said, call):
    with pytest.raises(fm.FibermeltError, match=f"^{said}"):
        call()


@pytest.mark.parametrize("points", ["count", "points"])
def test_streamlines_are_counted(points):
    field = object.__new__(FlowSolution)  # the count is looked at first
    with pytest.raises(fm.ConfigError, match=rf"^streamlines.{points} = 62.5: must be a whole"):
        fm.trace_streamlines(field, **{points: 62.5})


def test_the_factor_of_an_endless_fiber_is_one():
    for factor in (shape_factor, jeffery_factor):
        assert factor(1e200) == 1.0
        assert factor(np.float64(1e300)) == 1.0
        assert factor(1e-200) == -1.0


def test_a_melt_in_place_of_a_nozzle():
    with pytest.raises(fm.ConfigError, match="nozzle is of the type Newtonian, must be Nozzle"):
        fm.Deposition(fm.Newtonian(817.0), fm.Nozzle())


def test_a_motion_along_another_path():
    with pytest.raises(fm.HistoryError, match="has 3 points, the motion was followed over 5"):
        fm.surface_pressure(fm.simple_shear(1.0, 2.0, 3), RESPONSE, 817.0, MOTION)


@pytest.mark.parametrize("name", ["time", "gradient", "velocity", "pressure"])
def test_a_motion_along_another_path_of_equal_length(name):
    parts = {key: getattr(HISTORY, key) for key in PARTS}
    other = fm.FlowHistory(**{**parts, name: parts[name] * 2.0 + (name != "gradient")})
    pressure = fm.surface_pressure(HISTORY, RESPONSE, 817.0, MOTION)
    for call in (
        lambda: fm.surface_pressure(other, RESPONSE, 817.0, MOTION),
        lambda: fm.extremes(other, pressure, MOTION),
        lambda: fiber.angle_to_stream(other, MOTION),
        lambda: fiber.angle_to_stream_at(other, MOTION, [1.0]),
    ):
        with pytest.raises(fm.HistoryError, match=rf"^the motion was .* another path: {name}\["):
            call()
    again = fm.FlowHistory(**parts)
    assert np.array_equal(
        fm.surface_pressure(again, RESPONSE, 817.0, MOTION).lowest, pressure.lowest
    )


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
