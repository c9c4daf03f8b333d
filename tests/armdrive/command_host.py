"""Commands in processes of their own, forked by a host that has loaded them already.

A command that is loaded anew takes a third of a second of the processor; here all commands of a
test run pay that once. `begin` sends the words and the three streams of a command to the host, over
a socket. The host forks; the child takes the streams, the environment and the folder over, and ends
as the command line does. So it is a process like any other, to signals, pipes and terminals.

Two tests start Python itself: `test_cli_words` with streams that are closed, and `test_completion`.
"""

import atexit
import contextlib
import fcntl
import functools
import gc
import json
import os
import select
import signal
import socket
import subprocess
import sys
import termios
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

LONGEST = 1 << 20
"""Bytes of one order: the words of a command, and the environment."""
SHARED_FD = "ARMDRIVE_HOST_FD"


# In the test's process.


class HostedCommand:
    """A command in a process of its own, at pipes, as `subprocess.Popen` has it."""

    def __init__(self, *words: str) -> None:
        theirs, ours = zip(os.pipe(), reversed(os.pipe()), reversed(os.pipe()), strict=True)
        self.pid, self._alive = begin(words, theirs)
        for fd in theirs:
            os.close(fd)
        stdin, stdout, stderr = ours
        self.stdin = os.fdopen(stdin, "w", buffering=1, encoding="utf-8")
        self.stdout = os.fdopen(stdout, encoding="utf-8")
        self.stderr = os.fdopen(stderr, encoding="utf-8")
        self.returncode: int | None = None

    def send_signal(self, number: int) -> None:
        """Send a signal, unless the process has ended."""
        if self.returncode is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        """Kill the process."""
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float) -> int:
        """Wait until the process has ended; return its exit code."""
        if self.returncode is None:
            self.returncode = ended(self.pid, self._alive, timeout)
        return self.returncode

    def communicate(self, text: str = "", timeout: float = 60.0) -> tuple[str, str]:
        """Type a text and end the input; return what both outputs still say up to their end."""
        if self.stdin is not None:
            with contextlib.suppress(BrokenPipeError, ValueError), self.stdin:
                self.stdin.write(text)
        said = ["", ""]

        def read(at: int, stream: Any) -> None:
            with stream:
                said[at] = stream.read()

        streams = enumerate((self.stdout, self.stderr))
        open_ones = [(at, each) for at, each in streams if each is not None and not each.closed]
        readers = [threading.Thread(target=read, args=each, daemon=True) for each in open_ones]
        for reader in readers:
            reader.start()
        for reader in readers:
            reader.join(timeout)
            assert not reader.is_alive(), "the command did not end"
        self.wait(timeout)
        return said[0], said[1]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.kill()
        self.communicate()


@functools.cache
def _host() -> socket.socket:
    """Return the connection to the host of this test process, which ends together with it."""
    ours, theirs = socket.socketpair()
    environment = {**os.environ, SHARED_FD: str(theirs.fileno())}
    command = [sys.executable, str(Path(__file__))]
    process = subprocess.Popen(command, pass_fds=[theirs.fileno()], env=environment)
    theirs.close()

    def end() -> None:
        ours.close()
        process.wait()

    atexit.register(end)
    return ours


def begin(
    words: Sequence[str], fds: Sequence[int], terminal: Mapping[str, str] | None = None
) -> tuple[int, int]:
    """Begin a command at three streams; return its process, and a pipe that ends with it.

    With the variables of a `terminal`, the first stream becomes that of a session of its own.
    """
    alive, dies = os.pipe()
    env = {**os.environ, **(terminal or {})}
    order = {"words": words, "session": bool(terminal), "env": env, "cwd": str(Path.cwd())}
    pid = _ask(order, *fds, dies)
    os.close(dies)
    return pid, alive


def ended(pid: int, alive: int, timeout: float) -> int:
    """Wait until a process has ended; return its exit code, or minus the signal that killed it."""
    assert select.select([alive], [], [], timeout)[0], "the command did not end"
    os.close(alive)
    return _ask({"wait": pid})


def _ask(order: dict[str, Any], *fds: int) -> int:
    data = f"{json.dumps(order)}\n".encode()
    sent = socket.send_fds(_host(), [data], list(fds))
    _host().sendall(data[sent:])
    return int(_host().recv(64))


# In the host.


def child_order(test: socket.socket) -> dict[str, Any] | None:
    """Return its order in each child, and None in the host once the test process has ended."""
    while True:
        data, fds, _, _ = socket.recv_fds(test, LONGEST, 4)
        if not data:
            return None
        while not data.endswith(b"\n"):
            data += test.recv(LONGEST)
        order: dict[str, Any] = json.loads(data)
        if "wait" in order:
            answer = os.waitstatus_to_exitcode(os.waitpid(order["wait"], 0)[1])
        else:
            answer = os.fork()
            if answer == 0:
                test.close()
                _take_over(order, fds)
                return order
            for fd in fds:
                os.close(fd)
        test.sendall(f"{answer}\n".encode())


def _take_over(order: dict[str, Any], fds: list[int]) -> None:
    """Make this child what the command would find; the last pipe stays open until its end."""
    *streams, _ = fds
    if order["session"]:
        os.setsid()
    for number, fd in enumerate(streams):
        os.dup2(fd, number)
        os.close(fd)
    if order["session"]:
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    os.chdir(order["cwd"])
    os.environ.clear()
    os.environ.update(order["env"])
    # as Python opens them: by lines at a terminal
    sys.stdin = os.fdopen(0, encoding="utf-8", closefd=False)
    sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = os.fdopen(2, "w", 1, "utf-8", "backslashreplace", closefd=False)
    sys.argv = ["armdrive", *order["words"]]


if __name__ == "__main__":
    from armdrive.cli import main

    # what most commands load; not the prompt, whose readline looks at its terminal as it is loaded
    from armdrive.cli.drive import home, move  # noqa: F401
    from armdrive.cli.program import run_program  # noqa: F401
    from armdrive.cli.set_up import sim  # noqa: F401
    from armdrive.programs import shell  # noqa: F401
    from armdrive.registry import DIALECTS, simulated_kind
    from armdrive.setup import keyboard  # noqa: F401
    from armdrive.sim import serving  # noqa: F401

    for each in DIALECTS:
        simulated_kind(each)
    gc.freeze()  # no child searches them for garbage as it ends
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with socket.socket(fileno=int(os.environ.pop(SHARED_FD))) as connection:
        found = child_order(connection)
    sys.exit(0 if found is None else main())
