"""Who starts from whom: a tree within reach, shallow, and settled by the parameters alone."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.engine.stages import stage_parameters
from fibermelt.parts.flow.stages import flow_but_for_scale
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study, resolve
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import plan_sweep
from fibermelt.sweeps.starts import REACH, neighbours


def level(parents, place):
    return 0 if parents[place] is None else 1 + level(parents, parents[place])


def levels(parents):
    return [level(parents, place) for place in range(len(parents))]


def gaps(*values):
    return [{"flow.gap": value, "melt.viscosity": 800.0} for value in values]


def test_a_line_hangs_from_its_middle():
    """Seven gaps from 2.5 to 4 mm: two thirds of one are within reach of the one in the middle."""
    parents = neighbours(gaps(*[2.5 + 0.25 * k for k in range(7)]))
    assert parents.count(None) == 1
    assert parents[3] is None or parents[2] is None
    assert max(levels(parents)) == 1


def test_a_long_line_has_no_longer_chains_than_it_must():
    count, step = 41, 0.1
    parents = neighbours(gaps(*[math.exp(step * k) for k in range(count)]))
    assert parents[20] is None
    # Three steps are within reach: 0.3 of 0.3, which rounding must not decide.
    assert max(levels(parents)) == math.ceil(20 / 3)


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


def test_those_that_differ_in_a_scale_only_hang_from_one():
    assert neighbours(gaps(3.0, 3.0, 3.3, 3.0)) == [None, 0, 0, 0]


def test_a_flow_scales_with_the_melt_and_with_both_speeds():
    stage = next(stage for stage in CHAIN.stages if stage.name == "flow")
    values = stage_parameters(stage, resolve({}).values())

    def flow(inlet, bed, **law):
        speeds = {"flow.inlet_speed": inlet, "flow.bed_speed": bed}
        constants = {f"law.{name}": value for name, value in law.items()}
        return flow_but_for_scale({**values, **speeds, **constants})

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
def test_every_tree_ends_in_a_root_and_no_step_is_beyond_reach(points):
    parameters = [{"flow.gap": x, "flow.bed_speed": y} for x, y in points]
    parents = neighbours(parameters)
    assert max(levels(parents)) < len(points)
    for child, parent in enumerate(parents):
        if parent is not None:
            ways = (math.log(a / b) for a, b in zip(points[child], points[parent], strict=True))
            assert math.hypot(*ways) <= REACH + 1e-8
    roots = [points[place] for place, parent in enumerate(parents) if parent is None]
    for one in roots:
        for other in roots:
            ways = (math.log(a / b) for a, b in zip(one, other, strict=True))
            assert one == other or math.hypot(*ways) > REACH - 1e-8


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
    assert max(levels(neighbours(cases))) <= 6


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


def test_a_plan_has_one_flow_from_cold_and_scales_where_only_the_melt_differs(tmp_path):
    found = plan(tmp_path, GRID)
    kinds = sorted(job.kind for job in flows(found))
    assert kinds == ["flow", "flow from a neighbour", "flow scaled", "flow scaled"]
    for job in flows(found):
        if job.is_scaled:
            there = found.jobs[job.neighbour].case.changes
            assert there.get("flow.gap") == job.case.changes.get("flow.gap")
    others = [job for job in found.jobs.values() if job.stage != "flow"]
    assert not any(job.neighbour for job in others)


def test_a_task_knows_its_neighbours_to_the_root(tmp_path):
    found = plan(tmp_path, GRID)
    deepest = max(flows(found), key=lambda job: found.level(job.key))
    assert found.level(deepest.key) == 2
    starts = found.starts([deepest.case])
    assert starts[deepest.key].keys["flow"] == deepest.neighbour
    root = starts[deepest.neighbour].keys["flow"]
    assert root not in starts
    assert not found.jobs[root].neighbour


@pytest.mark.parametrize("cold", [False, True])
def test_keys_are_the_same_from_cold(tmp_path, cold):
    found = plan(tmp_path, GRID, cold=cold)
    assert any(job.neighbour for job in flows(found)) is not cold
    assert list(found.jobs) == list(plan(tmp_path, GRID).jobs)
