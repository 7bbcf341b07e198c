"""What a sweep comes to: which stages cases share, which of them are kept, who waits for whom."""

import numpy as np

from fibermelt.engine.parts import Chain, Part
from fibermelt.engine.stages import Stage
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import plan_sweep


def plan(tmp_path, text, chain=CHAIN, head=""):
    path = tmp_path / "swept.toml"
    path.write_text(f'preset = "paper"\nstudy.parts = ["bead"]\n{head}\n[sweep]\n{text}')
    study = load_study(str(path))
    return plan_sweep(read_sweep(study), study, chain)


GRID = '"flow.gap" = ["3 mm", "3.5 mm"]\n"fiber.aspect_ratio" = [4, 6, 8]'


def test_cases_share_what_does_not_vary_between_them(tmp_path):
    found = plan(tmp_path, GRID)
    assert found.shared() == {"flow": 2, "streamlines": 2, "cell": 3, "motion": 6}
    kept = [job.stage for job in found.jobs.values()]
    assert {name: kept.count(name) for name in kept} == {"flow": 2, "streamlines": 2, "cell": 3}
    assert len(found.results()) == 6
    for job in found.jobs.values():
        expected = [job.case.keys["flow"]] if job.stage == "streamlines" else []
        assert list(job.needs) == expected


def test_inputs_come_before_those_that_need_them(tmp_path):
    found = plan(tmp_path, GRID)
    order = list(found.jobs)
    for key, job in found.jobs.items():
        assert all(order.index(need) < order.index(key) for need in job.needs)


def test_a_fiber_without_a_cell_is_not_kept(tmp_path):
    found = plan(tmp_path, GRID, head='[fiber]\nmodel = "ellipse"')
    assert {job.stage for job in found.jobs.values()} == {"flow", "streamlines"}


def test_a_case_holds_what_it_changes_only(tmp_path):
    case = plan(tmp_path, GRID).cases[-1]
    assert case.changes == {"flow.gap": 0.0035, "fiber.aspect_ratio": 8.0}
    assert case.point == case.changes


def test_what_no_stage_reads_does_not_make_another_result(tmp_path):
    found = plan(tmp_path, '"streamlines.features" = [[1], [2]]')
    assert len({case.id for case in found.cases}) == 2
    assert len(found.results()) == 1


def test_a_last_stage_that_different_cases_share_is_kept(tmp_path):
    def nothing(parameters, inputs, say):
        return np.nan

    def summary(results):
        return {}

    stages = (
        Stage("flow", 1, ("flow",), (), nothing),
        Stage("orbit", 1, ("fiber.aspect_ratio",), (), nothing),
    )
    part = Part("bead", ("flow", "orbit"), summary, lambda told: [])
    found = plan(tmp_path, '"flow.gap" = ["3 mm", "3.5 mm"]', Chain(stages, (part,), 1))
    assert [job.stage for job in found.jobs.values()] == ["orbit"]
    assert [case.kept for case in found.cases] == [("orbit",)] * 2
