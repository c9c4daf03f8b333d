"""The desk on a real pseudo-terminal that is closed under it."""

import io
import os
import re
import select
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from amounts import every_row
from desk_fake import FakeArm
from textual.drivers._writer_thread import MAX_QUEUED_WRITES, WriterThread
from waiting import LONG_S, looks, tried

from tui.desk import TURN_S, Desk, run_desk
from tui.terminal import LastingFile

pty = pytest.importorskip("pty", reason="pseudo-terminals are a Unix matter")
termios = pytest.importorskip("termios")

CHILD = """
import fcntl, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
sys.path[:0] = sys.argv[2:]
from desk_fake import FakeArm
import tui.keys.presses
from tui import run_desk

tui.keys.presses.GATE_S = 0.0  # these keys come at once, one after the other

class Noting(FakeArm):
    def note(self, word):
        with open(sys.argv[1], "a") as notes:
            notes.write(word + " ")

    def request_stop(self):
        self.note("stop")

    def close(self):
        self.note("close")

    def nudge(self, jog, *, speed):
        self.note("nudge")

    def hold(self, jog, *, speed, for_s):
        self.note("hold")

sys.exit(run_desk(Noting()))
"""


COLOUR = re.compile(rb"\x1b\[(?:[0-9;]*;)?(?:3[0-8]|4[0-8]|9[0-7]|10[0-7])[;m]")


@pytest.mark.skipif(not hasattr(os, "setsid"), reason="needs a controlling terminal")
def test_a_desk_shows_no_colours_if_asked_and_stops_the_arm_when_its_terminal_closes(tmp_path):
    notes = tmp_path / "notes"
    ours, theirs = pty.openpty()
    child = _desk_on(theirs, notes, {"NO_COLOR": "1"})
    os.close(theirs)
    try:
        seen = _read_until(ours, b"understood")
        seen += _enter_until(ours, b"STOP")
        _enter_until(ours, b"armed:")
    finally:
        os.close(ours)
    assert child.wait(LONG_S) == 129
    assert notes.read_text().split()[:2] == ["stop", "close"]
    assert not COLOUR.search(seen)


@pytest.mark.skipif(not hasattr(signal, "SIGCONT"), reason="needs signals of Unix")
def test_a_desk_that_is_suspended_goes_on_whole_and_unmoved_and_ends_as_it_began(tmp_path):
    notes = tmp_path / "notes"
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    child = _desk_on(theirs, notes, {})
    try:
        seen = _read_until(ours, b"understood")
        seen += _enter_until(ours, b"STOP")
        assert COLOUR.search(seen)
        for suspending in (signal.SIGTSTP, signal.SIGSTOP):
            _enter_until(ours, b"armed:")
            _suspend(child, ours, suspending)
            os.write(ours, b"w")
            child.send_signal(signal.SIGCONT)
            _read_until(ours, b"SIMULATED")  # all is painted anew
        child.terminate()
        _read_until(ours, b"\x1b[?1004l")  # what it says last to its terminal
        assert child.wait(LONG_S) == 143
        assert termios.tcgetattr(theirs) == before
    finally:
        child.kill()
        child.wait(LONG_S)
        os.close(ours)
        os.close(theirs)
    assert set(notes.read_text().split()) == {"stop", "close"}


def _suspend(child, ours, number):
    """Send a signal that suspends the desk, and wait until it has."""
    child.send_signal(number)
    for _ in looks("the desk was not suspended"):
        if os.waitpid(child.pid, os.WUNTRACED | os.WNOHANG)[0]:
            return
        if select.select([ours], [], [], 0.05)[0]:  # what it still has to say is read
            os.read(ours, 65536)


class GoneFile:
    """A terminal that was closed."""

    def write(self, text):
        raise OSError(5, "Input/output error")

    def flush(self):
        raise OSError(5, "Input/output error")


@every_row(
    "encoding, shown",
    [("ascii", "6.9? |x| ?"), ("latin-1", "6.9° |x| ?"), ("utf-8", "6.9° |x| ⠤")],
)
def test_what_a_terminal_cannot_show_is_as_wide_as_what_stands_for_it(encoding, shown):
    sent = io.BytesIO()
    file = LastingFile(io.TextIOWrapper(sent, encoding, "backslashreplace"))
    file.write("6.9° |x| ⠤")
    file.flush()
    assert sent.getvalue().decode(encoding) == shown


def test_whoever_paints_a_closed_terminal_is_not_kept_waiting():
    writer = WriterThread(LastingFile(GoneFile()))
    writer.start()

    def paint():
        for _ in range(10 * MAX_QUEUED_WRITES):
            writer.write("text")
        writer.stop()

    painting = threading.Thread(target=paint, daemon=True)
    painting.start()
    painting.join(LONG_S)
    assert not painting.is_alive()


def _desk_on(theirs, notes, said):
    notes.touch()
    here = Path(__file__).parent
    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    return subprocess.Popen(
        [sys.executable, "-c", CHILD, str(notes), str(here), str(here.parent.parent)],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
        env={**environment, "TERM": "xterm-256color", "LANG": "C.UTF-8", **said},
    )


def _enter_until(terminal, words):
    """Press Enter until these words are painted; a desk that was kept waiting drops a key."""
    seen = bytearray()

    def painted():
        if select.select([terminal], [], [], 0.0)[0]:
            seen.extend(os.read(terminal, 65536))
        return words in seen

    tried(lambda: os.write(terminal, b"\r"), painted, f"{words} was not painted")
    return bytes(seen)


def _read_until(terminal, words):
    seen = b""
    while words not in seen:
        assert select.select([terminal], [], [], LONG_S)[0], "the desk painted nothing more"
        seen += os.read(terminal, 65536)
    return seen


def test_a_desk_that_fails_has_asked_for_a_stop_and_gives_threads_their_usual_turns(monkeypatch):
    arm, turns, before_s = FakeArm(), [], sys.getswitchinterval()

    def run(_):
        turns.append(sys.getswitchinterval())
        raise ValueError("a flaw")

    monkeypatch.setattr(Desk, "run", run)
    with pytest.raises(ValueError, match="a flaw"):
        run_desk(arm)
    assert turns == [pytest.approx(TURN_S)]
    assert sys.getswitchinterval() == before_s
    assert arm.asked("stop")
