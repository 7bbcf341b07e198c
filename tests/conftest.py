"""What holds for all tests."""

import os
import signal

import pytest
from examples_drawn import FUZZ
from hypothesis import HealthCheck, settings

# A busy machine is no failure: nothing here is judged by the time that it takes. Where the
# environment says CI, hypothesis' own profile is the parent: the same examples in every run.
settings.register_profile(
    "untimed",
    deadline=None,
    derandomize=settings.default.derandomize and FUZZ == 1,
    suppress_health_check=[HealthCheck.too_slow],
    max_examples=FUZZ * settings.default.max_examples,
)
settings.load_profile("untimed")

# Who starts tests in the background of a shell has what they start ignore Ctrl-C.
for _name in ("SIGINT", "SIGHUP", "SIGTERM"):
    if signal.getsignal(getattr(signal, _name)) is signal.SIG_IGN:
        signal.signal(getattr(signal, _name), signal.SIG_DFL)

pytest_plugins = ["solved_flows"]


def pytest_configure(config: pytest.Config) -> None:
    """Keep each of several processes to a core of its own.

    What they start then starts no second process to help it: all cores are at work already.
    """
    worker = getattr(config, "workerinput", None)
    if worker is None or not hasattr(os, "sched_setaffinity"):
        return
    cores = sorted(os.sched_getaffinity(0))
    if worker["workercount"] >= len(cores):
        os.sched_setaffinity(0, {cores[int(worker["workerid"].removeprefix("gw")) % len(cores)]})
