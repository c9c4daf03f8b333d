"""A serial CAN adapter with an echoing drive, in a thread of the test."""

import contextlib
import threading
import time
from pathlib import Path

from can_bench import LONG_S, EchoDrive

from armdrive.sim.bus.line import BusLine
from armdrive.sim.serving.servers import SlcanServer
from armdrive.transports.link import Bell


class Served:
    """An adapter on a pseudo-terminal, with an echoing drive on its bus."""

    def __init__(self, path: Path) -> None:
        self.server = SlcanServer(path)
        self.drive = EchoDrive()
        self._line = BusLine(self.drive)
        self._bell = Bell()
        self._ended = False
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._ended:
            with self._lock:
                now_s = time.monotonic()
                self._line.send(self.server.read(), now_s)
                self.server.write(self._line.receive(now_s))
                pause_s = max(self._line.next_s() - time.monotonic(), 0.0)
                files = self.server.filenos()
            with contextlib.suppress(OSError):  # it was unplugged meanwhile
                self._bell.wait(min(pause_s, 0.02), *files)

    def unplug(self) -> None:
        with self._lock:
            self.server.close()

    def replug(self, path: Path) -> None:
        with self._lock:
            self.server.open(str(path))

    def end(self) -> None:
        self._ended = True
        self._bell.ring()
        self._thread.join(LONG_S)
        self.server.close()
        self._bell.close()
