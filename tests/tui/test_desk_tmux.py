"""The desk as a person has it, inside tmux: armed, jogged, stopped, left; on a simulated arm."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import looks, tried

from armdrive.cli import main
from armdrive.storage import files as places

ROOT = Path(__file__).parents[2]
LOOK_S = 0.05  # each look at tmux's screen starts a process

pytestmark = pytest.mark.skipif(shutil.which("tmux") is None, reason="there is no tmux here")


class Tmux:
    """A tmux of this test's own, with one window in which the desk runs."""

    def __init__(self, *words):
        self._call = ["tmux", "-L", f"armdrive-{os.getpid()}", "-f", os.devnull]
        command = [sys.executable, "-m", "armdrive", "jog", *words]
        environment = {"PYTHONPATH": str(ROOT), "LANG": "C.UTF-8"}
        options = [word for each in environment.items() for word in ("-e", "=".join(each))]
        self._tell("new-session", "-d", "-x", "100", "-y", "30", *options, *command)

    def _tell(self, *words):
        done = subprocess.run([*self._call, *words], check=False, capture_output=True, text=True)
        return done.stdout if done.returncode == 0 else None

    @property
    def shown(self):
        """The rows of the screen; None once the program in it has ended."""
        return self._tell("capture-pane", "-p")

    def press(self, *keys):
        self._tell("send-keys", *keys)

    def pressed(self, key, pattern):
        """Press a key until the screen shows the result; a busy desk drops a key that is late."""
        done = lambda: re.search(pattern, self.shown or "")  # noqa: E731
        tried(lambda: self.press(key), done, f"{key} never led to {pattern}", LOOK_S)

    def seen(self, pattern):
        """Wait until the screen shows something; return what was found."""
        for _ in looks(f"{pattern} was never shown", LOOK_S):
            if found := re.search(pattern, self.shown or ""):
                return found
        raise AssertionError

    def gone(self):
        """Wait until the desk has ended, and tmux with it."""
        for _ in looks("the desk never ended", LOOK_S):
            if self.shown is None:
                return

    def kill(self):
        self._tell("kill-server")


@pytest.fixture
def tmux(tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.delenv("TMUX", raising=False)
    assert main(["home", "--sim", "teachmover"]) == 0
    session = Tmux("--sim", "teachmover")
    yield session
    session.kill()


def base(tmux):
    """Return the angle of the base as it is shown, degrees."""
    return float(tmux.seen(r"base +(-?[0-9.]+)°")[1])


def test_a_person_arms_jogs_stops_and_leaves_inside_tmux(tmux):
    tmux.seen("Before you move anything")
    tmux.pressed("Enter", r"\A(?!(?s:.*)Before you move anything)")
    # a busy desk shows late that it has closed the dialog: one more Enter arms the keys
    unarmed = lambda: tmux.press("Space" if " ARMED " in tmux.shown else "q")  # noqa: E731
    told = lambda: "jog keys move nothing" in tmux.shown  # noqa: E731
    tried(unarmed, told, "nothing was said about keys that are not armed", LOOK_S)
    start = base(tmux)
    tmux.pressed("Enter", " ARMED ")
    # a busy desk leaves out a key that it hears too late, and disarms where it was kept from work
    jog = lambda: tmux.press("Enter" if "DISARMED" in tmux.shown else "q")  # noqa: E731
    tried(jog, lambda: base(tmux) != start, "the key jogged nothing", LOOK_S)
    assert base(tmux) > start
    tmux.press("Space")
    tmux.seen("STOP requested|the jog was stopped")
    tmux.seen("DISARMED")
    tmux.press("C-q")
    tmux.gone()
    left = json.loads((places.states() / "desk.json").read_text())
    assert left["instructed"] is True
    assert left["arms"]["simulated sim:teachmover"]["cartesian"] is False
