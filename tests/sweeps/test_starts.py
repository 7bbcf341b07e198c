"""Who starts from whom: one within reach that is from cold, settled by the parameters alone."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.engine.stages import Parameters, stage_parameters
from fibermelt.parts.flow.stages import flow_scaled
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study, resolve
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import REACH, neighbours, plan_sweep


def gaps(*values):
    return [{"flow.gap": value, "melt.viscosity": 800.0} for value in values]


def test_a_line_hangs_from_its_middle():
    """Seven gaps from 2.5 to 4 mm: all but the outermost are within reach of one."""
    parents = neighbours(gaps(*[2.5 + 0.25 * k for k in range(7)]))
    assert parents.count(None) <= 2


@pytest.mark.parametrize("count", [7, 41])
def test_a_long_line_has_no_more_roots_than_it_must(count):
    """Three steps are within reach: 0.3 of 0.3, which rounding must not decide."""
    parents = neighbours(gaps(*[math.exp(0.1 * k) for k in range(count)]))
    assert parents.count(None) == math.ceil(count / 7)


def test_what_is_out_of_reach_starts_from_cold():
    far = math.exp(REACH + 1e-6)
    assert neighbours(gaps(1.0, far)) == [None, None]
    assert neighbours(gaps(1.0, math.exp(REACH - 1e-6))) == [None, 0]
    parents = neighbours(gaps(1.0, 1.1, 1.2, 3.0, 3.1, 3.2))
    assert [parents.count(None), parents[:3].count(None)] == [2, 1]


def test_what_is_no_number_must_be_equal():
    one = {"numerics.contact_guess": None, "flow.gap": 1.0}
    assert neighbours([one, {**one, "flow.gap": 1.1}]) == [None, 0]
    assert neighbours([one, {"numerics.contact_guess": 0.1, "flow.gap": 1.0}]) == [None, None]
    words = [{"flow.kind": kind, "flow.gap": 1.0 + 0.1 * k} for k, kind in enumerate("aba")]
    assert neighbours(words) == [None, None, 0]


def test_numbers_that_are_not_positive_count_in_parts_of_the_largest():
    def shifted(*values):
        return neighbours([{"flow.shift": value} for value in values])

    assert shifted(0.0, 1.0) == [None, None]
    assert shifted(-1.0, -0.8) == [None, 0]


def test_those_that_are_alike_hang_from_one():
    parents = neighbours(gaps(3.0, 3.0, 3.3, 3.0))
    assert parents.count(None) == 1


def test_a_flow_scales_with_the_melt_and_with_both_speeds():
    stage = next(stage for stage in CHAIN.stages if stage.name == "flow")
    values = stage_parameters(stage, resolve({}).values())

    def flow(inlet, bed, **law):
        speeds = {"flow.inlet_speed": inlet, "flow.bed_speed": bed}
        constants = {f"law.{name}": value for name, value in law.items()}
        return dict(flow_scaled(Parameters({**values, **speeds, **constants})).reference)

    # The paper's speeds, and a quarter of them.
    assert flow(24e-3, 101.6e-3, viscosity=817.0) == flow(6e-3, 25.4e-3, viscosity=400.0)
    assert flow(24e-3, 101.6e-3, viscosity=817.0) != flow(24.001e-3, 101.6e-3, viscosity=817.0)

    def thinning(inlet, bed, viscosity, time_constant):
        rest = {"infinite_viscosity": 0.0, "transition": 2.0, "index": 0.4}
        return flow(
            inlet, bed, name="carreau", viscosity=viscosity, time_constant=time_constant, **rest
        )

    one = thinning(24e-3, 101.6e-3, 817.0, 0.1)
    # A melt that thins scales with all its viscosities, and with speeds and time constant together.
    assert one == thinning(24e-3, 101.6e-3, 400.0, 0.1) == thinning(6e-3, 25.4e-3, 817.0, 0.4)
    assert one != thinning(6e-3, 25.4e-3, 817.0, 0.1)


number = st.floats(1e-3, 1e3)


@given(st.lists(st.tuples(number, number), min_size=1, max_size=25, unique=True))
def test_whoever_is_started_from_is_a_root_within_reach(points):
    parameters = [{"flow.gap": x, "flow.bed_speed": y} for x, y in points]
    for child, parent in enumerate(parents := neighbours(parameters)):
        if parent is not None:
            assert parents[parent] is None
            ways = (math.log(a / b) for a, b in zip(points[child], points[parent], strict=True))
            assert math.hypot(*ways) <= REACH + 1e-8


def test_the_order_of_keys_and_of_cases_does_not_matter():
    cases = [{"a": math.exp(0.17 * k), "b": math.exp(0.05 * k * k)} for k in range(6)]
    parents = neighbours(cases)
    order = [3, 5, 0, 2, 4, 1]
    turned = neighbours([dict(reversed(cases[k].items())) for k in order])
    for place, k in enumerate(order):
        expected = parents[k]
        found = turned[place]
        assert (None if found is None else order[found]) == expected


def test_thousands_of_flows_are_settled_in_a_moment():
    dice = random.Random(1)
    cases = [{"a": dice.uniform(1, 3), "b": dice.uniform(1, 3)} for _ in range(2000)]
    # A square of 1.1 by 1.1 in logarithms: a disc of the reach covers a quarter of it at most.
    assert neighbours(cases).count(None) <= 40


def plan(tmp_path, text, cold=False):
    path = tmp_path / "swept.toml"
    path.write_text(f'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n{text}')
    study = load_study(str(path))
    return plan_sweep(read_sweep(study, cold=cold), study, CHAIN)


def flows(found):
    return [job for job in found.jobs.values() if job.stage == "flow"]


GRID = (
    '"flow.gap" = ["3 mm", "3.3 mm"]\n"melt.viscosity" = [400, 800]\n"fiber.aspect_ratio" = [4, 6]'
)


def test_a_plan_has_one_flow_from_cold_and_one_for_all_melts(tmp_path):
    found = plan(tmp_path, GRID)
    assert sorted(job.kind for job in flows(found)) == ["flow", "flow from a neighbour"]
    others = [job for job in found.jobs.values() if job.stage != "flow"]
    assert not any(job.neighbour for job in others)


def test_a_task_knows_its_neighbours(tmp_path):
    found = plan(tmp_path, GRID)
    (warm,) = (job for job in flows(found) if job.neighbour)
    starts = found.starts([warm.case])
    assert {key: case.keys["flow"] for key, case in starts.items()} == {warm.key: warm.neighbour}


@pytest.mark.parametrize("cold", [False, True])
def test_keys_are_the_same_from_cold(tmp_path, cold):
    found = plan(tmp_path, GRID, cold=cold)
    assert any(job.neighbour for job in flows(found)) is not cold
    assert list(found.jobs) == list(plan(tmp_path, GRID).jobs)
