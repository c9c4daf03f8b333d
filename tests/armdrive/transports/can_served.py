"""A process with a serial CAN adapter on a pseudo-terminal, behind which a drive echoes."""

from __future__ import annotations

import select
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2]))
from can_bench import EchoDrive

from armdrive.sim.bus.line import BusLine
from armdrive.sim.serving.servers import SlcanServer


def serve(path: str) -> None:
    """Echo until the standard input ends."""
    server = SlcanServer(Path(path))
    line = BusLine(EchoDrive())
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while True:
        pause_s = min(max(line.next_s() - time.monotonic(), 0.0), 0.2)
        ready, _, _ = select.select([*server.filenos(), sys.stdin], [], [], pause_s)
        if sys.stdin in ready:
            break
        now_s = time.monotonic()
        line.send(server.read(), now_s)
        server.write(line.receive(now_s))
    server.close()


if __name__ == "__main__":
    serve(sys.argv[1])
