"""A disk that forgets what was not brought to it, and a world that ends at any chosen moment.

`Moments` counts every operation on the disk and every byte of motion on the wire; at the chosen
one the program ends as by SIGKILL or a power cut, and nothing that it still tries has an effect.
"""

import errno
import itertools
import math

from armdrive.sim.wire import MemoryLink
from armdrive.storage.files import StateFiles

MOTION = b"@STEP"


class End(BaseException):
    """The program is no more."""


class Moments:
    def __init__(self, last=math.inf):
        self.count = 0
        self.last = last
        self.over = False

    def pass_one(self):
        if self.ends():
            raise End

    def ends(self):
        self.over = self.over or self.count >= self.last
        self.count += not self.over
        return self.over


class MortalLink(MemoryLink):
    """A wire that the program leaves after any byte of a motion; what was sent arrives."""

    moments = Moments()

    def read(self, now_s):
        if self.moments.over:
            raise End
        return super().read(now_s)

    def write(self, data, now_s):
        if self.moments.over:
            raise End
        for sent in range(len(data) if data.startswith(MOTION) else 1):
            if self.moments.ends():
                super().write(data[:sent], now_s)
                raise End
        super().write(data, now_s)
        self.moments.pass_one()


class Inode:
    def __init__(self):
        self.data = self.safe = b""


class PowerDisk(StateFiles):
    """Names and data as programs see them, and as a power cut would leave them."""

    def __init__(self):
        self.moments = Moments()
        self.names = {}
        self.safe_names = {}
        self.changes = []
        self.handles = {}
        self.read_only = False
        self.room = math.inf
        self.forgetful = False
        self.fails_from = math.inf
        self.fails_to_remove = True
        self.failed = False

    def _pass(self, removing=False):
        self.moments.pass_one()
        if self.moments.count > self.fails_from and (self.fails_to_remove or not removing):
            self.failed = True
            raise OSError(errno.EIO, "Input/output error")
        if self.read_only:
            raise OSError(errno.EROFS, "Read-only file system")

    def read(self, path, most):
        if path not in self.names:
            raise FileNotFoundError(path)
        return self.names[path].data[:most]

    def make_folder(self, folder):
        self._pass()

    def may_change(self, folder):
        return not self.read_only

    def create(self, path):
        self._pass()
        if path in self.names:
            raise FileExistsError(path)
        self._change(path, Inode())
        handle = len(self.handles) + 3
        self.handles[handle] = self.names[path]
        return handle

    def write(self, handle, data):
        inode = self.handles[handle]
        for sent in (0, 1, len(data) // 2):
            if self.moments.ends():
                inode.data += data[:sent]
                raise End
        fits = data[: max(int(min(self.room - len(inode.data), len(data))), 0)]
        if not fits:
            raise OSError(errno.ENOSPC, "No space left on device")
        inode.data += fits
        return len(fits)

    def sync(self, handle):
        self._pass()
        if not self.forgetful:
            self.handles[handle].safe = self.handles[handle].data

    def close(self, handle):
        del self.handles[handle]

    def replace(self, source, target):
        self._pass()
        if source not in self.names:
            raise FileNotFoundError(source)
        inode = self.names[source]
        self._change(source, None)
        self._change(target, inode)

    def remove(self, path):
        self._pass(removing=True)
        if path in self.names:
            self._change(path, None)

    def sync_folder(self, folder):
        self._pass()
        if not self.forgetful:
            self.safe_names, self.changes = dict(self.names), []

    def _change(self, path, inode):
        _apply(self.names, path, inode)
        self.changes.append((path, inode))

    def after_kill(self, path):
        """What a file holds when only the program has ended."""
        return self.names[path].data if path in self.names else None

    def after_power_cut(self, path):
        """Everything that a file may hold afterwards: what was not safe got there, or did not."""
        found = set()
        for count in range(len(self.changes) + 1):
            for chosen in itertools.combinations(self.changes, count):
                names = dict(self.safe_names)
                for where, inode in chosen:
                    _apply(names, where, inode)
                inode = names.get(path)
                if inode is None:
                    found.add(None)
                elif inode.safe == inode.data:
                    found.add(inode.data)
                else:
                    found |= {inode.safe, inode.data, inode.data[: len(inode.data) // 2]}
        return found

    def holding(self, path, text):
        """Return another disk with just one file on it."""
        disk = PowerDisk()
        if text is not None:
            disk.names[path] = Inode()
            disk.names[path].data = disk.names[path].safe = text
        disk.safe_names = dict(disk.names)
        return disk


def _apply(names, path, inode):
    if inode is None:
        names.pop(path, None)
    else:
        names[path] = inode
