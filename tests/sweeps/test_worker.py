"""A worker of a sweep with several threads."""

import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

from fibermelt.sweeps import worker


def test_a_process_does_one_task_at_a_time(monkeypatch):
    """What it holds of a folder is for one; on two threads the tasks would overlap for sure."""
    inside, most = [], []

    def compute(cases):
        inside.append(cases)
        most.append(len(inside))
        time.sleep(0.05)
        inside.pop()
        return []

    held = SimpleNamespace(compute=compute, starts={})
    monkeypatch.setattr(worker, "_worker", lambda folder: held)
    task = SimpleNamespace(folder=None, starts={}, stage="", cases=())
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(worker.fulfil, [task] * 3)) == [[], [], []]
    assert most == [1, 1, 1]
