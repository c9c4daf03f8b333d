"""The device's end of a wire for other programs, and the pseudo-terminal among them.

A server never blocks: bytes that nobody takes are dropped, as on a real line without a listener.
"""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path
from typing import Protocol

from armdrive.errors import PortUnavailable

CHUNK = 4096
_PTY_FOLDERS = ("/dev/pts/", "/dev/ttys")


class Server(Protocol):
    """One end of a wire that another program opens."""

    @property
    def address(self) -> str:
        """What the other program opens."""

    @property
    def is_open(self) -> bool:
        """Whether the other end can be opened, and stays open."""

    @property
    def paced(self) -> bool:
        """Whether bytes come at the pace of a serial line; a network has none."""

    def open(self, address: str | None = None) -> None:
        """Offer the wire, again after `close`, and perhaps elsewhere. Raises `PortUnavailable`."""

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""

    def read(self) -> bytes:
        """Return what has come, possibly nothing."""

    def write(self, data: bytes) -> None:
        """Say something to whoever listens."""

    def close(self) -> None:
        """Withdraw the wire: its other end breaks, as by a pulled cable. Twice is no error."""


class PtyServer:
    """A pseudo-terminal in raw mode; `path` becomes a link to the side that others open.

    It keeps that side open itself, so that clients can come and go. The link replaces only a
    link to a pseudo-terminal that is gone, and is removed by `close`.
    """

    paced = True

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._ends: tuple[int, int] | None = None
        self._target = ""
        self.open()

    @property
    def address(self) -> str:
        """The link's path, or the pseudo-terminal's own where there is no link."""
        return str(self._path or self._target)

    @property
    def is_open(self) -> bool:
        """Whether clients can open it."""
        return self._ends is not None

    def open(self, address: str | None = None) -> None:
        """Make the pseudo-terminal and its link. Raises `PortUnavailable`."""
        if self._ends is not None:
            return
        if address is not None:
            self._path = Path(address)
        if sys.platform == "win32":
            raise PortUnavailable("this system has no pseudo-terminals: use --tcp 127.0.0.1:PORT")
        import pty
        import tty

        master, slave = pty.openpty()
        self._ends, self._target = (master, slave), os.ttyname(slave)
        os.set_blocking(master, False)
        try:
            tty.setraw(slave)
            if self._path is not None:
                self._link(self._path)
        except BaseException:
            self._close_ends()
            raise

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""
        return () if self._ends is None else self._ends[:1]

    def read(self) -> bytes:
        """Return what clients have written."""
        if self._ends is not None:
            with contextlib.suppress(BlockingIOError):
                return os.read(self._ends[0], CHUNK)
        return b""

    def write(self, data: bytes) -> None:
        """Write to whoever reads; what the system's buffer does not take is lost."""
        if self._ends is not None:
            with contextlib.suppress(BlockingIOError):
                os.write(self._ends[0], data)

    def close(self) -> None:
        """Hang up, and remove the link if it is still this pseudo-terminal's."""
        if self._ends is None:
            return
        if self._path is not None and self._path.is_symlink():
            with contextlib.suppress(OSError):
                if str(self._path.readlink()) == self._target:
                    self._path.unlink()
        self._close_ends()

    def _close_ends(self) -> None:
        for end in self._ends or ():
            os.close(end)
        self._ends = None

    def _link(self, path: Path) -> None:
        try:
            if path.is_symlink() and self._left_behind(path):
                path.unlink()
            path.symlink_to(self._target)
        except FileExistsError:
            raise PortUnavailable(
                f"{path} exists and is no left-over of an ended simulation: "
                "remove it, or choose another path"
            ) from None
        except OSError as error:
            raise PortUnavailable(f"{path} cannot be made: {error.strerror}") from None

    def _left_behind(self, path: Path) -> bool:
        """Tell whether a link leads to a pseudo-terminal that is gone, or by now is this one."""
        target = str(path.readlink())
        is_pty = target.startswith(_PTY_FOLDERS)
        return is_pty and (target == self._target or not path.exists())
