"""Sweeps whose flows start from one another: the same end, whatever was finished first or died."""

import itertools
import shutil

import fake_sweeps
import numpy as np
import pytest
from coarse_runs import COARSE
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.stages import Neighbour, Parameters, stage_parameters
from fibermelt.engine.store import Store
from fibermelt.parts.flow.stages import flow_from, flow_stage
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.plan import plan_sweep
from fibermelt.sweeps.record import restored
from fibermelt.sweeps.runner import run_sweep
from fibermelt.sweeps.status import sweep_status
from fibermelt.sweeps.store import CaseStore

pytestmark = pytest.mark.end_to_end

GAPS = (3.0, 3.9, 5.0, 6.4)
"""Each within reach of the next only: the second is the root, and one way has two steps [mm]."""

SWEPT = f"""preset = "paper"
study.parts = ["bead"]
[sweep]
"flow.gap" = {[f"{gap} mm" for gap in GAPS]}
"fiber.aspect_ratio" = [4, 8]
"""


def planned(study, **options):
    swept = load_study(str(study))
    found = plan_sweep(read_sweep(swept, **options), swept, fake_sweeps.CHAIN)
    return {
        job.case.changes.get("flow.gap", 3e-3): job
        for job in found.jobs.values()
        if job.stage == "flow"
    }


def traces(out):
    found = fake_sweeps.collect_sweep(out)["trace"].isel({"fiber.aspect_ratio": 0})
    return found.values.tolist()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    study = fake_sweeps.study_file(folder, SWEPT)
    summary, _ = fake_sweeps.sweep(study, folder / "out")
    assert (summary["done"], summary["failed"]) == (8, 0)
    return study, folder / "out"


def test_the_tree_is_followed(undisturbed):
    """The trace of a flow tells its own gap, and in its digits those before it [m]."""
    study, out = undisturbed
    jobs = planned(study)
    by_key = {job.key: gap for gap, job in jobs.items()}
    assert sorted(1 if job.neighbour else 0 for job in jobs.values()) == [0, 1, 1, 1]
    expected = []
    for gap in sorted(jobs):
        trace, weight, here = 0.0, 1.0, gap
        while True:
            trace, weight = trace + weight * here, weight * 1e-2
            if not jobs[here].neighbour:
                break
            here = by_key[jobs[here].neighbour]
        expected.append(trace)
    np.testing.assert_allclose(traces(out), expected, rtol=1e-14)


LOST = [lost for k in range(1, 5) for lost in itertools.combinations(range(4), k)]


@pytest.mark.parametrize("lost", LOST)
def test_whatever_is_lost_is_found_again_alike(tmp_path, undisturbed, lost):
    """Some flows are gone with the numbers of all cases but one, as after any kill."""
    study, whole = undisturbed
    shutil.copytree(whole, tmp_path / "out")
    out = tmp_path / "out"
    jobs = planned(study)
    for place in lost:
        (stage,) = out.glob(f"stages/flow-{list(jobs.values())[place].key[:20]}")
        shutil.rmtree(stage)
    for batch in sorted(out.glob("cases/batch-*"))[1:]:
        batch.unlink()
    summary, _ = fake_sweeps.sweep(study, out)
    assert (summary["done"], summary["failed"]) == (8, 0)
    fake_sweeps.assert_same(out, whole)


def test_flows_whose_neighbour_is_finished_with_need_it_still(tmp_path, undisturbed):
    """The numbers of the root's cases are there, its flow is not: it is computed for the others."""
    study, whole = undisturbed
    first, out = tmp_path / "first.toml", tmp_path / "out"
    (root,) = (gap for gap, job in planned(study).items() if not job.neighbour)
    first.write_text(SWEPT.replace(str([f"{gap} mm" for gap in GAPS]), f"[{root}]"))
    fake_sweeps.sweep(first, out)
    shutil.rmtree(*out.glob("stages/flow-*"))
    summary, _ = fake_sweeps.sweep(study, out)
    assert summary["done"] == 8
    fake_sweeps.assert_same(out, whole)


@pytest.mark.parametrize("cases_left", [False, True])
def test_a_torn_neighbour_is_mended_first(tmp_path, undisturbed, cases_left):
    study, whole = undisturbed
    shutil.copytree(whole, tmp_path / "out")
    out = tmp_path / "out"
    jobs = planned(study)
    deepest = next(
        job
        for job in jobs.values()
        if any(o.key == job.neighbour and o.neighbour for o in jobs.values())
    )
    shutil.rmtree(out / "stages" / f"flow-{deepest.key[:20]}")
    for key in {deepest.neighbour, *(job.neighbour for job in jobs.values())} - {""}:
        data = out / "stages" / f"flow-{key[:20]}" / "data.nc"
        data.write_bytes(data.read_bytes()[:-7])
    if not cases_left:
        for batch in out.glob("cases/batch-*"):
            batch.unlink()
    else:
        min(out.glob("cases/batch-*")).unlink()
    fake_sweeps.sweep(study, out)
    fake_sweeps.assert_same(out, whole)


def test_a_flow_whose_neighbour_has_no_answer_starts_from_cold(tmp_path):
    gaps = ["1.7 mm", "2 mm", "2.5 mm"]
    text = SWEPT.replace(str([f"{gap} mm" for gap in GAPS]), str(gaps))
    study = fake_sweeps.study_file(tmp_path, text)
    (last,) = (job for gap, job in planned(study).items() if gap == 2.5e-3)
    assert last.neighbour
    summary, _ = fake_sweeps.sweep(study, tmp_path / "out")
    assert (summary["done"], summary["failed"]) == (2, 4)
    assert traces(tmp_path / "out")[2] == 2.5e-3
    summary, _ = fake_sweeps.sweep(study, tmp_path / "out", workers=0)
    assert (summary["done"], summary["failed"]) == (2, 4)


def test_a_flow_that_its_neighbour_did_not_lead_to_counts_as_from_cold(tmp_path):
    gaps = ["3.9 mm", "4.3 mm", "4.7 mm"]
    text = SWEPT.replace(str([f"{gap} mm" for gap in GAPS]), str(gaps))
    study, out = fake_sweeps.study_file(tmp_path, text.replace("[4, 8]", "[4]")), tmp_path / "out"
    jobs = planned(study)
    (root,) = (gap for gap, job in jobs.items() if not job.neighbour)
    assert root != fake_sweeps.LEADS_NOWHERE
    fake_sweeps.sweep(study, out)
    began = {record.key: record.neighbour for record, _ in Store(out, ()).records()}
    lost = jobs[fake_sweeps.LEADS_NOWHERE]
    assert lost.neighbour
    assert began[lost.key] == ""
    assert sorted(map(bool, began.values())) == [False, False, True]
    assert sweep_status(out)["stages"]["flow"]["from_neighbour"] == 1


def test_a_sweep_from_cold_stays_so_when_it_goes_on(tmp_path, undisturbed):
    study, out = undisturbed[0], tmp_path / "out"
    swept = load_study(str(study))
    run_sweep(read_sweep(swept, cold=True), swept, out, fake_sweeps.CHAIN, workers=0)
    assert traces(out) == pytest.approx([gap * 1e-3 for gap in GAPS], rel=1e-14)
    again, _ = restored(CaseStore(out))
    assert again.is_cold
    warm, _ = restored(CaseStore(undisturbed[1]))
    assert not warm.is_cold


@pytest.mark.parametrize("options", [[], ["--cold"]])
def test_a_plan_tells_how_flows_start(tmp_path, options):
    study = str(fake_sweeps.study_file(tmp_path, SWEPT))
    printed = CliRunner().invoke(app, ["plan", study, "--out", str(tmp_path / "out"), *options])
    assert printed.exit_code == 0
    told = "1 from cold, 3 from a neighbour, 0 scaled from one; 3 one after the other"
    assert (told in " ".join(printed.stdout.split())) is not bool(options)


SWEEP = """
[sweep]
"flow.gap" = ["3 mm", "3.2 mm"]
"melt.viscosity" = [400, 817]
"""
FEW = ["fiber.model=ellipse", "streamlines.count=2", "streamlines.points=60"]
"""Settings that leave little to do besides the flows."""

FINER = ["numerics.lip_edge=0.01", "numerics.contact_edge=0.02", "numerics.corner_edge=0.1"]
"""Settings with which the estimated errors of a coarse flow are no luck."""


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """Return a study of two gaps and two melts, and the folder of its sweep."""
    folder = tmp_path_factory.mktemp("real")
    coarse = COARSE.read_text()
    (folder / "swept.toml").write_text(coarse + SWEEP)
    study = load_study(str(folder / "swept.toml"), FEW + FINER)
    summary = run_sweep(read_sweep(study), study, folder / "out", CHAIN, workers=0)
    assert (summary["done"], summary["failed"]) == (4, 0)
    return study, folder / "out"


def stored(real, kind):
    """Return the parameters and the data of a flow that was computed in some way."""
    study, out = real
    (stage,) = (stage for stage in CHAIN.stages if stage.name == "flow")
    jobs = plan_sweep(read_sweep(study), study, CHAIN).jobs.values()
    job = next(job for job in jobs if job.kind == kind)
    store = Store.open(out)
    values = {**study.config.values(), **job.case.changes}
    return stage_parameters(stage, values), store.load(store.find("flow", job.key))


def test_a_flow_from_a_neighbour_ends_within_its_error_in_fewer_steps(real):
    parameters, found = stored(real, "flow from a neighbour")
    expected = flow_stage(parameters, {}, lambda line: None)
    for name in ("contact_point", "heel", "inlet_pressure"):
        assert abs(found[name] - expected[name]) <= expected[f"{name}_error"], name
    assert found["contact_point"] != expected["contact_point"]
    assert found["newton_steps"] < expected["newton_steps"]


EXACT = ("node_x", "node_y", "node_velocity", "upstream_surface", "downstream_surface")
"""What a viscosity does not touch, computed by the same solver on the same mesh."""


def test_a_flow_of_another_melt_is_as_good_as_solved(real):
    """Shape and velocity agree to the last bit, the rest to rounding: sums in threads' order."""
    other, data = stored(real, "flow")
    one = Parameters({**other, "law.viscosity": 123.0})
    said = []
    scaled, is_from_it = flow_from(one, {}, said.append, Neighbour(other, data))
    assert is_from_it
    assert said == ["the same flow of another melt, or faster: scaled"]
    expected = flow_stage(one, {}, lambda line: None)
    assert set(scaled.variables) == set(expected.variables)
    for name, variable in expected.variables.items():
        if name in EXACT:
            np.testing.assert_array_equal(scaled[name].values, variable.values)
        else:
            top = np.abs(variable.values).max()
            np.testing.assert_allclose(scaled[name].values, variable.values, atol=1e-10 * top)


def test_real_flows_are_found_again_alike(tmp_path, real):
    """All flows but the one that comes last in the tree are gone: others are finished first."""
    study, whole = real
    out = tmp_path / "out"
    shutil.copytree(whole, out)
    plan = plan_sweep(read_sweep(study), study, CHAIN)
    flows = [job for job in plan.jobs.values() if job.stage == "flow"]
    last = max(flows, key=lambda job: plan.level(job.key))
    assert plan.level(last.key) == 2
    for job in flows:
        if job is not last:
            shutil.rmtree(out / "stages" / f"flow-{job.key[:20]}")
    for batch in out.glob("cases/batch-*"):
        batch.unlink()
    run_sweep(read_sweep(study), study, out, CHAIN, workers=0)
    fake_sweeps.assert_same(out, whole)
