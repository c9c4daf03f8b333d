"""Python programs in processes of their own that start at once, as forks of one that waits.

That process has loaded the product, which takes longer than most of these programs. `Forked` is
`subprocess.Popen` for the arguments of a new Python: `-m MODULE`, `-c CODE` or a file, and more.
Where a system cannot fork, it starts a new Python.
"""

import contextlib
import gc
import importlib
import io
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
    """A Python program in a process of its own; all as with `Popen`, except the words."""

    _ended: socket.socket | None = None

    def __init__(self, *words: str, **more: Any) -> None:
        super().__init__([sys.executable, *words], **more)

    if hasattr(os, "fork"):

        def _execute_child(self, args: list[str], *more: Any) -> None:
            call = signature(subprocess.Popen._execute_child).bind(self, args, *more).arguments
            ours, theirs = socket.socketpair()
            streams = (call["p2cread"], call["c2pwrite"], call["errwrite"])
            numbers = [own if given < 0 else given for own, given in enumerate(streams)]
            with _one_at_a_time:
                way, _ = _nursery()
            socket.send_fds(way, [b"."], [*numbers, theirs.fileno()])
            theirs.close()
            wanted = {name: call[name] for name in ("cwd", "env", "start_new_session")}
            wanted["env"] = dict(os.environ if call["env"] is None else call["env"])
            wanted["cwd"] = str(call["cwd"] or Path.cwd())
            ours.sendall(json.dumps([args[1:], wanted]).encode() + b"\n")
            self.pid, self._ended = int(_line(ours)), ours
            self._child_created = True
            pipes = ("p2cread", "p2cwrite", "c2pread", "c2pwrite", "errread", "errwrite")
            self._close_pipe_fds(*(call[name] for name in pipes))

        def _internal_poll(self, *_: Any, **__: Any) -> int | None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._wait(0.0)
            return self.returncode

        def _wait(self, timeout: float | None) -> int:
            if self.returncode is None and self._ended is not None:
                if not select.select([self._ended], [], [], timeout)[0]:
                    raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
                self.returncode = int(_line(self._ended))
                self._ended.close()
            return self.returncode


_one_at_a_time = threading.Lock()


@cache
def _nursery() -> tuple[socket.socket, subprocess.Popen]:
    """Start the process that forks, and return the way to it; it ends when this one does."""
    ours, theirs = socket.socketpair()
    words = [sys.executable, __file__, str(theirs.fileno())]
    process = subprocess.Popen(words, pass_fds=[theirs.fileno()])
    theirs.close()
    return ours, process


def _line(stream: socket.socket) -> bytes:
    data = b""
    while not data.endswith(b"\n"):
        piece = stream.recv(1 if data else 4096)
        assert piece, "the process that forks has ended"
        data += piece
    return data


def main(requests: socket.socket) -> None:
    """Fork a program for each request, and tell how it ended, until there are no more."""
    for name in LOADED:
        importlib.import_module(name)
    gc.collect()
    gc.freeze()
    woken, wakes = socket.socketpair()
    for end in (woken, wakes):
        end.setblocking(False)
    signal.set_wakeup_fd(wakes.fileno())
    signal.signal(signal.SIGCHLD, lambda *_: None)
    children: dict[int, socket.socket] = {}
    while True:
        ready = select.select([requests, woken], [], [])[0]
        if woken in ready:
            woken.recv(4096)
            for pid in [*children]:
                ended, status = os.waitpid(pid, os.WNOHANG)
                if ended:
                    with children.pop(pid) as asker, contextlib.suppress(OSError):
                        asker.sendall(b"%d\n" % os.waitstatus_to_exitcode(status))
        if requests in ready:
            _, numbers, _, _ = socket.recv_fds(requests, 1, 4)
            if not numbers:
                return
            *streams, number = numbers
            asker = socket.socket(fileno=number)
            words, wanted = json.loads(_line(asker))
            pid = os.fork()
            if pid == 0:
                for each in (requests, woken, wakes, asker, *children.values()):
                    each.detach()  # `settle` closes them
                settle(streams, **wanted)
                run(words)
                return
            for stream in streams:
                os.close(stream)
            children[pid] = asker
            asker.sendall(b"%d\n" % pid)


def settle(streams: list[int], cwd: str, env: dict[str, str], *, start_new_session: bool) -> None:
    """Give a fork what a new Python has: its signals, files, folder and environment."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for own, given in enumerate(streams):
        os.dup2(given, own)
    os.closerange(3, max(streams) + 100)
    if start_new_session:
        os.setsid()
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(env)
    at_once = bool(env.get("PYTHONUNBUFFERED"))
    sys.stdin = sys.__stdin__ = open(0, closefd=False)  # noqa: SIM115
    buffer = open(1, "wb", 0 if at_once else -1, closefd=False)  # noqa: SIM115
    sys.stdout = sys.__stdout__ = io.TextIOWrapper(
        buffer, line_buffering=os.isatty(1), write_through=at_once
    )
    sys.stderr = sys.__stderr__ = open(  # noqa: SIM115
        2, "w", buffering=1, errors="backslashreplace", closefd=False
    )


def run(words: list[str]) -> None:
    """Run a program by the arguments that a new Python would get."""
    first, *rest = words
    if first == "-m":
        module, *sys.argv[1:] = rest
        sys.path[0] = str(Path.cwd())
        runpy.run_module(module, run_name="__main__", alter_sys=True)
    elif first == "-c":
        code, *more = rest
        sys.argv, sys.path[0] = ["-c", *more], ""
        exec(compile(code, "<string>", "exec"), {"__name__": "__main__"})
    else:
        sys.argv, sys.path[0] = words, str(Path(first).resolve().parent)
        runpy.run_path(first, run_name="__main__")


if __name__ == "__main__":
    main(socket.socket(fileno=int(sys.argv[1])))
