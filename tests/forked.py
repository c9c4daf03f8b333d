"""Python programs in processes of their own that start at once, as forks of one that waits.

That one has loaded the product, which takes longer than most of these programs. `Forked` is
`subprocess.Popen` for the arguments of a new Python: `-m MODULE`, `-c CODE` or a file, and more.
"""

import contextlib
import gc
import importlib
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import threading
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any

LOADED = (
    "armdrive.exports",
    "armdrive.cli.chosen_arm",
    "armdrive.cli.set_up.sim",
    "armdrive.cli.program.run",
)
"""Not `tui`: its framework reads the environment as it is loaded."""


class Forked(subprocess.Popen):
    """A Python program in a process of its own. Where a system cannot fork, a new Python."""

    def __init__(self, *words: str, **more: Any) -> None:
        self._end: socket.socket | None = None
        super().__init__([sys.executable, *words], **more)

    if hasattr(os, "fork"):

        def _execute_child(self, args: list[str], *more: Any) -> None:
            call = signature(subprocess.Popen._execute_child).bind(self, args, *more).arguments
            given = (call["p2cread"], call["c2pwrite"], call["errwrite"])
            streams = [own if each < 0 else each for own, each in enumerate(given)]
            env = dict(os.environ if call["env"] is None else call["env"])
            wanted = [args[1:], str(call["cwd"] or Path.cwd()), env, call["start_new_session"]]
            self._end, theirs = socket.socketpair()
            with _starting:
                way, _ = _nursery()
            socket.send_fds(way, [b"."], [*streams, theirs.fileno()])
            theirs.close()
            self._end.sendall(json.dumps(wanted).encode() + b"\n")
            self.pid = _told(self._end)
            self._child_created = True
            pipes = ("p2cread", "p2cwrite", "c2pread", "c2pwrite", "errread", "errwrite")
            self._close_pipe_fds(*(call[name] for name in pipes))

        def _internal_poll(self, *_: Any, **__: Any) -> int | None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._wait(0.0)
            return self.returncode

        def _wait(self, timeout: float | None) -> int:
            if self.returncode is None and self._end is not None:
                if not select.select([self._end], [], [], timeout)[0]:
                    raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
                self.returncode = _told(self._end)
                self._end.close()
            return self.returncode


_starting = threading.Lock()


@cache
def _nursery() -> tuple[socket.socket, subprocess.Popen]:
    """Start the process that forks, and return the way to it; it ends when this one does."""
    ours, theirs = socket.socketpair()
    words = [sys.executable, __file__, str(theirs.fileno())]
    process = subprocess.Popen(words, pass_fds=[theirs.fileno()])
    theirs.close()
    return ours, process


def _tell(asker: socket.socket, number: int) -> None:
    with contextlib.suppress(OSError):  # nobody waits for it any more
        asker.sendall(number.to_bytes(4, "big", signed=True))


def _told(stream: socket.socket) -> int:
    data = stream.recv(4)
    assert data, "the process that forks has ended"
    return int.from_bytes(data, "big", signed=True)


def main(requests: socket.socket) -> None:
    """Fork a program for each request, and tell its number and its end, until there are no more."""
    for name in LOADED:
        importlib.import_module(name)
    gc.collect()
    gc.freeze()
    woken, wakes = socket.socketpair()
    for end in (woken, wakes):
        end.setblocking(False)
    signal.set_wakeup_fd(wakes.fileno())
    signal.signal(signal.SIGCHLD, lambda *_: None)
    askers: dict[int, socket.socket] = {}
    while True:
        ready = select.select([requests, woken], [], [])[0]
        if woken in ready:
            woken.recv(4096)
            for pid in [*askers]:
                ended, status = os.waitpid(pid, os.WNOHANG)
                if ended:
                    with askers.pop(pid) as asker:
                        _tell(asker, os.waitstatus_to_exitcode(status))
        if requests in ready:
            _, numbers, _, _ = socket.recv_fds(requests, 1, 4)
            if not numbers:
                return
            *streams, number = numbers
            asker = socket.socket(fileno=number)
            words, *wanted = json.loads(asker.makefile().readline())
            pid = os.fork()
            if pid == 0:
                for each in (requests, woken, wakes, asker, *askers.values()):
                    each.detach()  # `settle` closes them
                settle(streams, *wanted)
                run(*words)
                return
            for stream in streams:
                os.close(stream)
            askers[pid] = asker
            _tell(asker, pid)


def settle(streams: list[int], cwd: str, env: dict[str, str], own_session: bool) -> None:
    """Give a fork what a new Python has: its signals, files, folder and environment."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for own, given in enumerate(streams):
        os.dup2(given, own)
    os.closerange(3, max(streams) + 100)
    if own_session:
        os.setsid()
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    by_lines = 1 if env.get("PYTHONUNBUFFERED") or os.isatty(1) else -1
    sys.stdin, sys.stdout, sys.stderr = sys.__stdin__, sys.__stdout__, sys.__stderr__ = (
        open(0, closefd=False),  # noqa: SIM115
        open(1, "w", by_lines, closefd=False),  # noqa: SIM115
        open(2, "w", 1, errors="backslashreplace", closefd=False),  # noqa: SIM115
    )


def run(first: str, *rest: str) -> None:
    """Run a program by the arguments that a new Python would get."""
    sys.argv = [first, *rest]
    if first == "-m":
        sys.argv, sys.path[0] = [*rest], str(Path.cwd())
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif first == "-c":
        sys.argv, sys.path[0] = ["-c", *rest[1:]], ""
        exec(compile(rest[0], "<string>", "exec"), {"__name__": "__main__"})
    else:
        sys.path[0] = str(Path(first).resolve().parent)
        runpy.run_path(first, run_name="__main__")


if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])))
