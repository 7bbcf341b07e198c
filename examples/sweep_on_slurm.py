"""
A sweep on a SLURM cluster
==========================

Its workers are batch jobs, this script stays while it runs.

Start it on the login node. What is named here is for you to change: the study, a results folder
that every node sees under the same path, and what a job of your cluster is.
It needs dask-jobqueue: pip install "fibermelt[slurm]".
"""

from pathlib import Path
from typing import Any

from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.runner import run_sweep
from fibermelt.sweeps.worker import single_threaded

STUDY = "mine.toml"
RESULTS = Path("/shared/mine")

JOB = {
    "queue": "compute",
    "walltime": "04:00:00",
    "cores": 16,
    "processes": 16,  # as many as cores: a worker has one thread
    "memory": "64 GB",
    "job_script_prologue": [f"export {name}={n}" for name, n in single_threaded().items()],
    # Workers leave before their job ends, not all at once: the scheduler moves on what they had.
    "worker_extra_args": ["--lifetime", "220m", "--lifetime-stagger", "10m"],
    # Others on the login node may have dask's usual port.
    "scheduler_options": {"dashboard_address": ":0"},
}
JOBS = 8


def slurm() -> Any:
    """Return a cluster of jobs, at most `JOBS` at once; where one ends, another is submitted."""
    from dask_jobqueue import SLURMCluster  # noqa: PLC0415  only who runs this needs it

    cluster = SLURMCluster(**JOB)
    cluster.adapt(minimum_jobs=1, maximum_jobs=JOBS)
    return cluster


def sweep_on(cluster: Any, study: str, results: Path) -> dict[str, Any]:
    """Run the sweep of a study on the workers of a cluster, and return what became of it."""
    swept = load_study(study)
    scheduler = cluster.scheduler_address
    return run_sweep(read_sweep(swept), swept, results, CHAIN, scheduler=scheduler)


if __name__ == "__main__":
    with slurm() as jobs:
        print(sweep_on(jobs, STUDY, RESULTS))
