"""The example for SLURM: what its jobs are, and that what it runs on a cluster is a sweep."""

import itertools
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from distributed import LocalCluster

from fibermelt.sweeps.worker import single_threaded

pytestmark = [pytest.mark.end_to_end, pytest.mark.slow]

EXAMPLE = Path(__file__).parents[2] / "examples" / "sweep_on_slurm.py"

FIBERS = """preset = "paper"
[study]
parts = ["interaction"]
[sweep]
"interaction.volume_fraction" = [0.05, 0.084]
"""


@pytest.fixture(scope="module")
def example():
    return runpy.run_path(str(EXAMPLE))


def minutes(text):
    assert text.endswith("m")
    return int(text[:-1])


def test_it_can_be_read_without_dask_jobqueue():
    script = (
        "import runpy, sys\nsys.modules['dask_jobqueue'] = None\n"
        f"print(sorted(runpy.run_path({str(EXAMPLE)!r})['JOB']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert (done.returncode, "walltime" in done.stdout) == (0, True), done.stderr


def test_a_job_has_one_thread_for_each_worker(example):
    jobqueue = pytest.importorskip(
        "dask_jobqueue", reason='needs dask-jobqueue: pip install "fibermelt[slurm]"'
    )
    with jobqueue.SLURMCluster(**example["JOB"]) as cluster:
        script, address = cluster.job_script().splitlines(), cluster.scheduler_address
    assert "#SBATCH --cpus-per-task=16" in script
    assert "#SBATCH -t 04:00:00" in script
    (command,) = (shlex.split(line) for line in script if "dask_worker" in line)
    option = dict(itertools.pairwise(command))
    assert (option["--nworkers"], option["--nthreads"]) == ("16", "1")
    # Set before the workers start, as they read it when they do.
    assert script.index("export NGS_NUM_THREADS=1") < len(script) - 1
    assert {line for line in script if line.startswith("export")} == {
        f"export {name}={value}" for name, value in single_threaded().items()
    }
    # A worker has left before its job ends, however late it is.
    late = minutes(option["--lifetime"]) + minutes(option["--lifetime-stagger"])
    assert late < 4 * 60
    # Its scheduler is that of the script: the results folder, or a file in it, is none.
    assert address in command
    assert "--scheduler-file" not in command
    assert str(example["RESULTS"]) not in " ".join(script)


def test_it_runs_a_sweep_on_the_workers_of_a_cluster(example, tmp_path):
    study = tmp_path / "swept.toml"
    study.write_text(FIBERS)
    with LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        host="127.0.0.1",
        local_directory=tmp_path / "scratch",
        dashboard_address="127.0.0.1:0",
    ) as cluster:
        summary = example["sweep_on"](cluster, str(study), tmp_path / "out")
    assert (summary["cases"], summary["done"], summary["failed"]) == (2, 2, 0)
