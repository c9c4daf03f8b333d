"""The desk on a real pseudo-terminal that is closed under it."""

import os
import select
import subprocess
import sys
from pathlib import Path

import pytest

pty = pytest.importorskip("pty", reason="pseudo-terminals are a Unix matter")

CHILD = """
import fcntl, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
sys.path[:0] = sys.argv[2:]
from desk_fake import FakeArm
from tui import run_desk

class Noting(FakeArm):
    def note(self, word):
        with open(sys.argv[1], "a") as notes:
            notes.write(word + " ")

    def request_stop(self):
        self.note("stop")

    def close(self):
        self.note("close")

sys.exit(run_desk(Noting()))
"""


@pytest.mark.skipif(not hasattr(os, "setsid"), reason="needs a controlling terminal")
def test_closing_the_terminal_stops_and_closes_the_arm(tmp_path):
    notes = tmp_path / "notes"
    notes.touch()
    here = Path(__file__).parent
    ours, theirs = pty.openpty()
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(notes), str(here), str(here.parent.parent)],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
        env={**os.environ, "TERM": "xterm-256color", "LANG": "C.UTF-8"},
    )
    os.close(theirs)
    try:
        _read_until(ours, b"understood")
        os.write(ours, b"\r")
        _read_until(ours, b"STOP")
        os.write(ours, b"\r")
        _read_until(ours, b"armed:")
    finally:
        os.close(ours)
    assert child.wait(10.0) == 129
    assert notes.read_text().split()[:2] == ["stop", "close"]


def _read_until(terminal, words, patience_s=10.0):
    seen = b""
    while words not in seen:
        assert select.select([terminal], [], [], patience_s)[0], "the desk painted nothing more"
        seen += os.read(terminal, 65536)
