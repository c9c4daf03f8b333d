"""A disk that forgets what was not brought to it, and a world that ends at any chosen moment.

`Moments` counts every operation on the disk and every byte of motion on the wire; at the chosen
one the program ends as by SIGKILL or a power cut, and nothing that it still tries has an effect.
"""

import errno
import itertools
import math

from armdrive.sim.wire import MemoryLink
from tests.scenarios.disk import Disk

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


class PowerDisk(Disk):
    """A disk that ends the program, fails, or is full from a chosen operation on."""

    def __init__(self):
        super().__init__()
        self.moments = Moments()
        self.room = math.inf
        self.forgetful = False
        self.fails_from = math.inf
        self.fails_to_remove = True
        self.failed = False

    def _count_operation(self):
        self.moments.pass_one()
        if self.moments.count > self.fails_from:
            self.failed = True
            raise OSError(errno.EIO, "Input/output error")

    def write(self, handle, data):
        self._count_operation()
        path = self._handles[handle]
        begun = len(self.texts[path])
        part = data if begun else data[: len(data) // 2]  # of each file a half, then the rest
        part = part[: int(min(max(self.room - begun, 0), len(part)))]
        if not part:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.texts[path] += part
        return len(part)

    def sync(self, handle):
        self._count_operation() if self.forgetful else super().sync(handle)

    def sync_folder(self, folder):
        self._count_operation() if self.forgetful else super().sync_folder(folder)

    def remove(self, path):
        fails_from = self.fails_from
        if not self.fails_to_remove:
            self.fails_from = math.inf
        super().remove(path)
        self.fails_from = fails_from

    def after_kill(self, path):
        """What a file holds when only the program has ended."""
        return self.texts.get(path)

    def after_power_cut(self, path):
        """Everything that a file may hold afterwards: what was not safe got there, or did not."""
        found = set()
        for count in range(len(self._changes) + 1):
            for chosen in itertools.combinations(self._changes, count):
                texts = {each: {text} for each, text in self._safe.items()}
                for source, target, text in chosen:
                    texts.pop(source, None)
                    if target is not None:
                        torn = {b"", text[: len(text) // 2]} if source in self._unsynced else set()
                        texts[target] = {text} | torn
                found |= texts.get(path, {None})
        return found

    def holding(self, path, text):
        """Return another disk with just one file on it."""
        disk = PowerDisk()
        if text is not None:
            disk.texts[path] = text
            disk._safe = dict(disk.texts)
        return disk
