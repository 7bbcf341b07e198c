"""Signals that end a command as Ctrl-C does."""

import os
import signal

import pytest

from fibermelt.cli.signals import Ended, ended_in_order


@pytest.fixture(autouse=True)
def as_they_were():
    """Give the test process its handlers back, whatever happens."""
    numbers = (signal.SIGTERM, signal.SIGHUP)
    before = [signal.getsignal(number) for number in numbers]
    yield
    assert [signal.getsignal(number) for number in numbers] == before


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_ends_with_its_code(number, code):
    with pytest.raises(KeyboardInterrupt) as ended, ended_in_order():
        os.kill(os.getpid(), number)
    assert isinstance(ended.value, Ended)
    assert ended.value.code == code


def end_and_close(steps):
    """End by one signal, and close what is open while others come."""
    with ended_in_order():
        try:
            os.kill(os.getpid(), signal.SIGHUP)
        finally:
            os.kill(os.getpid(), signal.SIGTERM)
            os.kill(os.getpid(), signal.SIGHUP)
            steps.append("closed")


def test_a_second_signal_does_not_interrupt_the_end():
    steps = []
    with pytest.raises(Ended):
        end_and_close(steps)
    assert steps == ["closed"]


def test_what_nohup_ignores_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ended_in_order():
            os.kill(os.getpid(), signal.SIGHUP)
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
