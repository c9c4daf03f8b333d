"""`armdrive shell` in a process of its own, on a pseudo-terminal."""

import os
import pty
import re
import select
import signal

from command_host import begin, ended
from waiting import LONG_S, looks

AGAIN_S = 1.0
PROMPT, MORE = "\n> ", "\n... "
_WIPED = re.compile(r"[^\n]*\r\x1b\[K")
_CODES = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\r")
CTRL_C, CTRL_D = "\x03", "\x04"


class Prompt:
    """The terminal of a shell: types keys, and reads what is shown."""

    def __init__(self, *words: str, columns: int = 200) -> None:
        self._number, slave = pty.openpty()
        environment = {"TERM": "xterm", "COLUMNS": str(columns)}
        self._pid, self._alive = begin(("shell", *words), [slave] * 3, environment)
        os.close(slave)
        self._raw = ""
        self._over = False

    def type(self, text: str) -> None:
        """Type without Enter."""
        os.write(self._number, text.encode())

    def enter(self, line: str, *, until: str = PROMPT) -> str:
        """Type a line; return what is shown up to the next prompt."""
        self.type(f"{line}\r")
        return self.until(until)

    def interrupt(self) -> None:
        """Press Ctrl-C, again and again until something is shown.

        Python's readline misses a signal that comes between the prompt and the wait for a key.
        """
        self.type(CTRL_C)
        while not select.select([self._number], [], [], AGAIN_S)[0]:
            self.type(CTRL_C)

    def until(self, text: str = PROMPT) -> str:
        """Return what is shown after the last such call, up to a text that has to come."""
        for _ in looks(f"{text!r} was never shown"):
            if text in "\n" + (shown := self._shown()):
                break
            if select.select([self._number], [], [], LONG_S)[0]:
                self._raw += self._data()
        self._raw = ""
        return shown

    def end(self) -> int:
        """Wait until the shell ends by itself; return its exit code."""
        while select.select([self._number], [], [], LONG_S)[0]:
            data = self._data()
            self._raw += data
            if not data:
                break
        self._over = True
        return ended(self._pid, self._alive, LONG_S)

    def close(self) -> None:
        """Kill the shell, unless it has ended by itself."""
        if not self._over:
            os.kill(self._pid, signal.SIGKILL)
            self.end()
        os.close(self._number)

    def _shown(self) -> str:
        """Return the text on the screen, without lines that were wiped."""
        return _CODES.sub("", _WIPED.sub("", self._raw.replace("\r\n", "\n")))

    def _data(self) -> str:
        try:
            return os.read(self._number, 65536).decode(errors="replace")
        except OSError:  # the other end has gone
            return ""
