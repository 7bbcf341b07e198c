"""What the cases of a folder cost, counted by several at once."""

import threading

import pytest

from fibermelt.sweeps.progress import Progress, add_progress, read_progress, write_progress
from fibermelt.sweeps.store import open_case_store

CLIENTS, TIMES = 4, 8


def test_what_several_count_at_once_is_added_up(tmp_path):
    cases = open_case_store(tmp_path / "out")
    write_progress(cases, Progress(cases=5, cases_s=2.5, software={"numpy": "1"}))
    news = Progress(wall_s=3.0, reused_stages=2, cases=1, cases_s=0.25, cases_processor_s=0.125)

    def work():
        for _ in range(TIMES):
            add_progress(cases, news)

    threads = [threading.Thread(target=work) for _ in range(CLIENTS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    count = CLIENTS * TIMES
    # Sums of powers of two: exact in whatever order.
    assert read_progress(cases) == Progress(
        wall_s=3.0,
        reused_stages=2,
        cases=5 + count,
        cases_s=2.5 + 0.25 * count,
        cases_processor_s=0.125 * count,
        software={"numpy": "1"},
    )
    assert list(cases.locks.iterdir()) == []


@pytest.mark.parametrize("torn", [None, b"{}"])
def test_where_nothing_is_known_counting_begins_anew(tmp_path, torn):
    cases = open_case_store(tmp_path / "out")
    if torn is not None:
        cases.progress.write_bytes(torn)
    add_progress(cases, Progress(cases=2, software={"numpy": "2"}))
    assert read_progress(cases) == Progress(cases=2, software={"numpy": "2"})
