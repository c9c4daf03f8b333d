"""Ctrl-C while a program runs, twice, at the worst moment: while what it says is written."""

import io
import os
import signal
import sys

import pytest

from armdrive.cli.program.run_common import INTERRUPTED, stopped_by_interrupt


class Pressed(io.FileIO):
    """An error stream in the middle of whose writing a person presses Ctrl-C."""

    times = 0

    def write(self, text):
        while self.times:
            self.times -= 1
            signal.raise_signal(signal.SIGINT)
        return super().write(text)


class Arm:
    """What is asked of an arm by a signal."""

    stops = 0

    @property
    def core(self):
        return self

    def request_stop(self):
        self.stops += 1

    def stop_bound(self):
        return self

    silent_time_s = 1.25


class Left(BaseException):
    """The program is left at once."""


@pytest.fixture
def terminal():
    """Give an error stream as Python makes it, what is below it, and what was written to it."""
    ours, theirs = os.pipe()
    raw = Pressed(theirs, "w")
    stream = io.TextIOWrapper(io.BufferedWriter(raw), "utf-8", line_buffering=True)
    yield stream, raw, lambda: os.read(ours, 4096).decode()
    raw.times = 0
    stream.close()
    os.close(ours)


def speak(raw, times):
    """Say something, with one press meanwhile and the others right after it."""
    raw.times = 1
    try:
        sys.stderr.write("act 1\n")
    finally:
        for _ in range(times - 1):
            signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize(("times", "ends"), [(1, KeyboardInterrupt), (2, Left)])
def test_an_interrupt_during_output_is_not_lost(monkeypatch, terminal, times, ends):
    def leave(code):
        assert code == INTERRUPTED
        raise Left

    monkeypatch.setattr(os, "_exit", leave)
    stream, raw, read = terminal
    monkeypatch.setattr(sys, "stderr", stream)
    arm = Arm()
    with pytest.raises(ends), stopped_by_interrupt(lambda: (arm,)):
        speak(raw, times)
    assert arm.stops == 1
    said = read()
    assert said.startswith("\nstopping the arm; Ctrl-C again leaves at once\n")
    assert ("left: the arm may go on for 1.2 s" in said) == (times == 2)
