import io

import pytest

from fibermelt.engine.progress import PlainProgress, duration, observing


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_pipe_gets_plain_lines():
    stream = io.StringIO()
    with observing(stream) as observer:
        assert isinstance(observer, PlainProgress)
        observer.step("flow", "Newton step 4: residual 3.1e-06")
        observer.done("flow", "done in 12.0 s")
    assert stream.getvalue() == "flow: Newton step 4: residual 3.1e-06\nflow: done in 12.0 s\n"


def test_a_terminal_keeps_what_is_done(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")
    stream = Terminal()
    with observing(stream) as observer:
        observer.step("flow", "step [1 of 3]")
        observer.done("flow", "done in 12.0 s")
    assert "flow: done in 12.0 s" in stream.getvalue()


def test_a_log_tells_of_the_whole_now_and_then_and_nothing_twice():
    stream, now = io.StringIO(), [0.0]
    observer = PlainProgress(stream, clock=lambda: now[0])
    for second in range(3600):
        now[0] = float(second)
        observer.tick("sweep", f"{second // 60} of 60 cases")
    lines = stream.getvalue().splitlines()
    assert lines[:2] == ["sweep: 0 of 60 cases", "sweep: 1 of 60 cases"]
    assert len(lines) == len(set(lines)) > 40


def test_the_lines_of_a_long_run_come_less_often():
    stream, now = io.StringIO(), [0.0]
    observer = PlainProgress(stream, clock=lambda: now[0])
    for second in range(24 * 3600):
        now[0] = float(second)
        observer.tick("sweep", f"{second} cases")
    # Every 10 s up to 500 s, then 2 per cent more each time: 50 and ln(86400 / 500) / ln(1.02).
    assert len(stream.getvalue().splitlines()) == pytest.approx(50 + 260, rel=0.05)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "0 s"), (89.0, "89 s"), (90.0, "2 min"), (3599.0, "60 min"), (18600.0, "5.2 h")],
)
def test_a_time_in_words(seconds, words):
    assert duration(seconds) == words
