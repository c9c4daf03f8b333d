"""A program on a pseudo-terminal of its own: keys to it, what it paints, and a line to it."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import queue
import select
import signal
import socket
import struct
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Self

from desk_child import SHOWN

CHILD = Path(__file__).with_name("desk_child.py")
SIZE = (120, 40)
PATIENCE_S = 30.0
AGAIN_S = 0.3
"""An arm key that fell on keys that were still arriving is pressed again after this."""

FASTER = [b"+"] * 5
"""Brings the desk to full speed, which is the worst."""


class Terminal:
    """Has a command for its foreground; a thread reads what it paints."""

    def __init__(
        self, command: Sequence[str], size: tuple[int, int] = SIZE, line: int = -1
    ) -> None:
        self._ours, theirs = os.openpty()
        width, height = size
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", height, width, 0, 0))
        environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
        self.began_s = time.monotonic()
        self.process = subprocess.Popen(
            command,
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            start_new_session=True,
            pass_fds=(line,) if line >= 0 else (),
            env={
                **environment,
                "TERM": "xterm-256color",
                "COLORTERM": "truecolor",
                "LANG": "C.UTF-8",
            },
        )
        os.close(theirs)
        self.painted = 0
        """Bytes that the program has sent to its terminal."""
        self._seen = b""
        self._changed = threading.Condition()
        self._closing, closes = os.pipe()
        self._closes = closes
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        while True:
            ready, _, _ = select.select([self._ours, self._closing], [], [])
            if self._closing in ready:
                return
            try:
                data = os.read(self._ours, 65536)
            except OSError:  # the program has ended
                return
            with self._changed:
                self.painted += len(data)
                self._seen = (self._seen + data)[-65536:]
                self._changed.notify_all()

    def shown_s(self, word: str = SHOWN) -> float:
        """Wait until a word is painted, and return how long after the command that was."""
        with self._changed:
            there = self._changed.wait_for(lambda: word.encode() in self._seen, PATIENCE_S)
        if not there:
            raise TimeoutError(f"{word} was never painted: {self._seen[-400:]!r}")
        return time.monotonic() - self.began_s

    def type(self, keys: bytes) -> None:
        """Press keys."""
        os.write(self._ours, keys)

    def close(self) -> None:
        """Take the terminal away, as somebody who closes its window does."""
        if self._closes >= 0:
            os.close(self._closes)
            self._closes = -1
            self._reader.join()
            os.close(self._ours)
            os.close(self._closing)

    def end(self) -> int:
        """End the program, whatever it is doing, and return its exit code."""
        self.close()
        with contextlib.suppress(ProcessLookupError):
            self.process.send_signal(signal.SIGCONT)
        try:
            return self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()


class LinedTerminal(Terminal):
    """Has one of the apps of desk_child.py, and a line to it."""

    def __init__(self, *words: str, size: tuple[int, int] = SIZE) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            number = theirs.fileno()
            super().__init__([sys.executable, str(CHILD), str(number), *words], size, number)
        self._line = ours
        self._answers: queue.Queue[dict[str, Any]] = queue.Queue()
        self.writes: queue.Queue[dict[str, Any]] = queue.Queue()
        """What the program has written to its wire: when (monotonic), and how it begins."""
        threading.Thread(target=self._hear, daemon=True).start()

    def _hear(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            for told in self._line.makefile("r"):
                words = json.loads(told)
                (self._answers if "answer" in words else self.writes).put(words)

    def ask(self, word: str) -> dict[str, Any]:
        """Ask the program something."""
        self._line.sendall(word.encode() + b"\n")
        try:
            answer: dict[str, Any] = self._answers.get(timeout=PATIENCE_S)["answer"]
        except queue.Empty:
            raise TimeoutError(f"no answer to {word}: {self._seen[-4000:]!r}") from None
        return answer

    def arm_keys(self) -> None:
        """Arm the jog keys, as often as it takes."""
        end_s = time.monotonic() + PATIENCE_S
        while not self.ask("look")["armed"]:
            if time.monotonic() > end_s:
                raise TimeoutError(f"the keys were never armed: {self.ask('look')}")
            self.type(b"\r")
            time.sleep(AGAIN_S)

    def end(self) -> int:
        """End the program, and the line to it."""
        code = super().end()
        self._line.close()
        return code


@contextlib.contextmanager
def desk_of(
    port: str,
    dialect: str,
    motors: Sequence[int],
    *,
    size: tuple[int, int] = SIZE,
    rate_hz: float = 0.0,
) -> Iterator[LinedTerminal]:
    """Have the desk of an arm that stands at these motors, at full speed, disarmed."""
    instructed()
    words = ("arm", port, dialect, json.dumps(list(motors)), str(rate_hz))
    with LinedTerminal(*words, size=size) as desk:
        desk.shown_s()
        for key in FASTER:  # one by one: keys that come together do nothing
            desk.type(key)
            time.sleep(AGAIN_S)
        yield desk


def instructed() -> None:
    """Have somebody read what a desk says at its very first start."""
    from armdrive.storage import files as places

    places.states().mkdir(parents=True, exist_ok=True)
    (places.states() / "desk.json").write_text('{"instructed": true}', encoding="utf-8")
