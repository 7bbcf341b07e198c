"""Sweeps whose workers, client or scheduler are killed, whose disk fills, whose files are torn.

What is killed is a real process, with SIGKILL, at a random moment whose seed is printed; no sweep
ends before that, however slow who kills is. Whatever happened, the sweep that goes on ends where an
undisturbed one does, and computes nothing twice that was finished.
"""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

import fake_sweeps
import pytest
from patience import PATIENCE
from sweeping import gate, is_alive, lines, process, wait_for, workers_of
from typer.testing import CliRunner

from fibermelt.cli import app
from fibermelt.engine.files import canonical, digest
from fibermelt.errors import StoreError
from fibermelt.sweeps.status import sweep_status
from fibermelt.sweeps.store import CaseStore, read_progress

pytestmark = [pytest.mark.end_to_end, pytest.mark.slow]

TAKES = {"FAKE_FLOW_TAKES": "0.2", "FAKE_MOTION_TAKES": "0.04"}
"""Cost [s] of the stages: 96 cases take 2 s on two workers, during which something is killed."""

BLOWS = 30
"""Stages, of the 44 at least that are left after a first blow, during which the next one falls."""

KILLS = 3


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    summary, _ = fake_sweeps.sweep(fake_sweeps.study_file(folder), folder / "out")
    assert (summary["done"], summary["failed"]) == (72, 24)
    return folder / "out"


@pytest.fixture
def study(tmp_path):
    return fake_sweeps.study_file(tmp_path)


@pytest.fixture
def dice(request):
    seed = int(os.environ.get("FAULT_SEED", random.SystemRandom().randrange(10**6)))
    print(f"FAULT_SEED={seed} repeats {request.node.name}")  # noqa: T201  told when a test fails
    return random.Random(seed)


def client(study, out, log, *options, **environment):
    arguments = [fake_sweeps.__file__, study, out, *options]
    return process(arguments, FAKE_LOG=str(log), **TAKES, **environment)


def wait_for_blow(log, stages, dice, running):
    """Wait until so many stages were begun, and somewhere into the next one."""
    wait_for(lambda: len(lines(log)) >= stages, f"{stages} stages", running)
    time.sleep(dice.uniform(0, 2 * float(TAKES["FAKE_MOTION_TAKES"])))


def computed(log):
    """Return what was computed, by its process, as lines such as ``flow 0.003``."""
    return [line.split(" ", 1)[1] for line in lines(log)]


def finished_work(out):
    """Return the keys of the cases whose numbers are there, and the names of stored stages."""
    stages = {path.name for path in (out / "stages").glob("flow-*")}
    return CaseStore(out).refresh(), stages


def resume(study, out, log, monkeypatch):
    """Go on in this process, and assert that nothing is computed that was finished."""
    cases, stages = finished_work(out)
    monkeypatch.setenv("FAKE_LOG", str(log))
    summary, _ = fake_sweeps.sweep(study, out)
    assert (summary["cases"], summary["done"], summary["failed"]) == (96, 72, 24)
    again = computed(log)
    assert sum(line.startswith("motion") for line in again) == 72 - len(cases)
    gaps = [line for line in again if line.startswith("flow") and line != "flow 0.002"]
    assert len(gaps) == 3 - len(stages)
    assert len(again) == len(set(again))


def test_workers_are_killed(tmp_path, study, undisturbed, dice):
    """The rest goes on: the sweep ends as if nothing had been."""
    log = tmp_path / "log"
    opened, held = gate(tmp_path, after=BLOWS)
    # As on a machine that is so busy that no other worker is there in the time of dask's.
    held["DASK_DISTRIBUTED__DEPLOY__LOST_WORKER_TIMEOUT"] = "0 s"
    with client(study, tmp_path / "out", log, "--workers", 2, **held) as running:
        for stages in sorted(dice.sample(range(1, BLOWS + 1), KILLS)):
            wait_for_blow(log, stages, dice, running)
            if alive := [pid for pid in workers_of(log) if is_alive(pid)]:
                os.kill(dice.choice(alive), signal.SIGKILL)
        opened.touch()
        told, complaints = running.communicate(timeout=PATIENCE)
        assert running.returncode == 0, complaints
    summary = json.loads(told)
    assert (summary["cases"], summary["done"], summary["failed"]) == (96, 72, 24)
    fake_sweeps.assert_same(tmp_path / "out", undisturbed)


def test_the_client_is_killed(tmp_path, study, undisturbed, dice, monkeypatch):
    """Its workers go with it, and the next one goes on from what they finished."""
    out = tmp_path / "out"
    for kill in range(2):
        log = tmp_path / f"log{kill}"
        _, held = gate(tmp_path, after=BLOWS)
        with client(study, out, log, "--workers", 2, **held) as running:
            wait_for_blow(log, dice.randint(1, BLOWS), dice, running)
            running.send_signal(signal.SIGKILL)
            running.wait(PATIENCE)
        workers = workers_of(log)
        wait_for(lambda workers=workers: not any(map(is_alive, workers)), "end of the workers")
    resume(study, out, tmp_path / "log", monkeypatch)
    fake_sweeps.assert_same(out, undisturbed)
    assert not list(out.rglob(".partial-*"))


@contextmanager
def cluster(folder, log, environment):
    """Yield a scheduler process and its address; two workers go when it goes."""
    file = folder / "scheduler.json"
    common = ["--no-dashboard", "--host", "127.0.0.1"]
    with process(
        ["-m", "distributed.cli.dask_scheduler", "--port", 0, "--scheduler-file", file, *common]
    ) as scheduler:
        wait_for(lambda: file.exists() and file.read_text().endswith("}"), "scheduler", scheduler)
        with process(
            ["-m", "distributed.cli.dask_worker", "--scheduler-file", file, "--nworkers", 2,
             "--nthreads", 1, "--local-directory", folder / "scratch", *common],
            FAKE_LOG=str(log), **TAKES, **environment,
        ):  # fmt: skip
            yield scheduler, file


def test_the_scheduler_is_killed(tmp_path, study, undisturbed, dice, monkeypatch):
    """The client says so and ends; what was finished is kept."""
    out, log = tmp_path / "out", tmp_path / "log0"
    (tmp_path / "cluster").mkdir()
    _, held = gate(tmp_path, after=BLOWS)
    with cluster(tmp_path / "cluster", log, held) as (scheduler, file):
        with client(study, out, log, "--scheduler", file) as running:
            wait_for_blow(log, dice.randint(1, BLOWS), dice, running)
            scheduler.send_signal(signal.SIGKILL)
            _, complaints = running.communicate(timeout=PATIENCE)
        assert running.returncode == 1
        assert "is gone: finished cases are kept" in complaints.splitlines()[-1]
    wait_for(lambda: not any(map(is_alive, workers_of(log))), "end of the workers")
    resume(study, out, tmp_path / "log", monkeypatch)
    fake_sweeps.assert_same(out, undisturbed)


def test_two_clients_share_a_folder_and_the_work(tmp_path, study, undisturbed):
    """Each with a worker of its own: both end, and between them nothing is computed twice."""
    out, log = tmp_path / "out", tmp_path / "log"
    opened, held = gate(tmp_path, after=0)
    with (
        client(study, out, log, "--workers", 1, **held) as one,
        client(study, out, log, "--workers", 1, **held) as other,
    ):
        # The first waits in its first stage, so that it cannot do it all.
        wait_for(lambda: len(workers_of(log)) == 2, "two workers", one)
        opened.touch()
        for running in (one, other):
            told, complaints = running.communicate(timeout=PATIENCE)
            assert running.returncode == 0, complaints
            assert json.loads(told)["done"] == 72
    everything = computed(log)
    assert len(everything) == len(set(everything)) == 72 + 4
    assert len(workers_of(log)) == 2
    # The cases of both, whoever of them ended last.
    assert read_progress(CaseStore(out)).cases == 72
    fake_sweeps.assert_same(out, undisturbed)


@contextmanager
def small_disk(folder):
    """Yield a file system of 200 kB, or skip."""
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", folder],
        capture_output=True,
        check=False,
    )
    if mounted.returncode:
        pytest.skip("file systems can be mounted by root only")
    try:
        yield folder
    finally:
        subprocess.run(["umount", folder], check=True)


def test_a_disk_fills_up(tmp_path, study, undisturbed, monkeypatch):
    """The sweep says so and ends; with room on the disk it goes on from what was finished."""
    with small_disk(tmp_path / "disk") as disk:
        out = disk / "out"
        with client(study, out, tmp_path / "log0", "--workers", 2) as running:
            _, complaints = running.communicate(timeout=PATIENCE)
        assert running.returncode == 1
        assert "no space left on device; free some space" in complaints
        assert not list(out.rglob(".partial-*"))
        subprocess.run(["mount", "-o", "remount,size=50m", disk], check=True)
        resume(study, out, tmp_path / "log", monkeypatch)
        fake_sweeps.assert_same(out, undisturbed)


@pytest.mark.parametrize("small", [3000, 18000])
def test_files_that_cannot_grow(tmp_path, study, undisturbed, monkeypatch, small):
    """A limit on the size of files, where a full disk cannot be had: the same end."""
    out = tmp_path / "out"
    script = (
        "import resource, fake_sweeps\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({small}, resource.RLIM_INFINITY))\n"
        "fake_sweeps.main()\n"
    )
    arguments = ["-c", script, study, out, "--workers", "0"]
    with process(arguments, PYTHONDONTWRITEBYTECODE="1") as running:
        _, complaints = running.communicate(timeout=PATIENCE)
    assert running.returncode == 1
    assert "file too large; free some space" in complaints.splitlines()[-1]
    resume(study, out, tmp_path / "log", monkeypatch)
    fake_sweeps.assert_same(out, undisturbed)
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != small


def flip(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)


def truncate(path):
    path.write_bytes(path.read_bytes()[:-7])


@pytest.mark.parametrize("tear", [flip, truncate])
@pytest.mark.parametrize(
    "name",
    [
        "cases/batch-*.npz",
        "cases/failed-*.json",
        "cases/progress.json",
        "stages/flow-*/data.nc",
        "stages/flow-*/record.json",
        "sweep.json",
    ],
)
def test_a_torn_file_is_known_and_mended(tmp_path, study, undisturbed, name, tear):
    """A stage is read again where a case needs it, so all cases are taken away with it."""
    out = tmp_path / "out"
    fake_sweeps.sweep(study, out)
    if name.startswith("stages"):
        for batch in out.glob("cases/batch-*"):
            batch.unlink()
    victim = min(out.glob(name))
    tear(victim)
    summary, said = fake_sweeps.sweep(study, out)
    assert (summary["done"], summary["failed"]) == (72, 24)
    if name.startswith(("stages", "cases/batch")):
        assert sum("was damaged" in line for line in said) == 1
    fake_sweeps.assert_same(out, undisturbed)
    assert sweep_status(out)["damaged"] == []


LOST = (["stages/store.json"], ["sweep.json"], ["sweep.json", "stages/store.json"])


@pytest.mark.parametrize("names", LOST)
@pytest.mark.parametrize("lose", [Path.unlink, truncate], ids=["gone", "torn"])
def test_a_sweep_that_lost_what_it_is_goes_on(
    tmp_path, study, undisturbed, names, lose, monkeypatch
):
    """A study run into the folder again finds all that is finished, and says what it mended."""
    out, log = tmp_path / "out", tmp_path / "log"
    shutil.copytree(undisturbed, out)
    for name in names:
        lose(out / name)
    monkeypatch.setenv("FAKE_LOG", str(log))
    summary, said = fake_sweeps.sweep(study, out)
    assert (summary["done"], summary["failed"]) == (72, 24)
    assert computed(log) == []
    told = "store: stages/store.json was missing or damaged: written anew"
    assert (told in said) is ("stages/store.json" in names)
    fake_sweeps.assert_same(out, undisturbed)


@pytest.mark.parametrize("command", ["resume", "status", "collect", "report", "clean"])
@pytest.mark.parametrize("with_mark", [True, False])
def test_a_sweep_without_what_was_asked_says_how_to_get_it_back(
    tmp_path, undisturbed, command, with_mark
):
    out = tmp_path / "out"
    shutil.copytree(undisturbed, out)
    (out / "sweep.json").unlink()
    if not with_mark:
        (out / "stages/store.json").unlink()
    told = CliRunner().invoke(app, [command, str(out)])
    assert told.exit_code == 2
    assert told.stderr == (
        f"error: {out}/sweep.json: is missing; run fibermelt sweep STUDY --out {out} again to "
        "write it anew: finished cases are kept\n"
    )


def test_a_folder_that_nothing_whole_is_in_is_not_taken_for_a_sweep(tmp_path, study):
    out = tmp_path / "out"
    (out / "cases").mkdir(parents=True)
    (out / "cases/progress.json").write_text("{}")
    with pytest.raises(StoreError, match="holds cases, which no run of fibermelt keeps track of"):
        fake_sweeps.sweep(study, out)
    (out / "sweep.json").write_text(json.dumps(sealed({"schema": 2})))
    with pytest.raises(StoreError, match=r"holds sweep\.json, which no run"):
        fake_sweeps.sweep(study, out)


def sealed(content):
    return {"content": content, "sha256": digest(canonical(content))}


def test_a_torn_batch_is_never_collected(tmp_path, study):
    fake_sweeps.sweep(study, tmp_path / "out")
    victim = min((tmp_path / "out").glob("cases/batch-*"))
    flip(victim)
    assert sweep_status(tmp_path / "out")["damaged"] == [str(victim)]
    with pytest.raises(StoreError, match=r"batch-\w+\.npz: is damaged.*resume"):
        fake_sweeps.collect_sweep(tmp_path / "out")


def test_a_failed_case_is_recorded_and_tried_again_only_if_asked(tmp_path, study, monkeypatch):
    out, log = tmp_path / "out", tmp_path / "log"
    fake_sweeps.sweep(study, out)
    found = sweep_status(out)
    reason = "flow.gap = 0.002 m: no steady surface; try a larger gap"
    assert found["reasons"] == {reason: 24}
    (failure,) = found["failures"]
    assert (failure["stage"], failure["kind"]) == ("flow", "ConvergenceError")
    assert failure["parameters"]["flow.gap"] == 0.002
    monkeypatch.setenv("FAKE_LOG", str(log))
    fake_sweeps.sweep(study, out)
    assert computed(log) == []
    summary, _ = fake_sweeps.sweep(study, out, retry_failed=True)
    assert computed(log) == ["flow 0.002"]
    assert summary["failed"] == 24
