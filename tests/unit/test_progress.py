import io

from fibermelt.study.progress import PlainProgress, observing


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
