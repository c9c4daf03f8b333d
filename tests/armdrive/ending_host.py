"""A program that drives a real port until something ends it.

`python ending_host.py PORT DIALECT ORDER` references the arm by where its `motors` stand and sets
out on a long way; with `terminal` it has that pseudo-terminal for its own. It tells when it is
under way, and what its status announces at the next line that it gets. It raises where the order,
in JSON, has `raises`.
"""

import fcntl
import json
import os
import sys
import termios
import threading
from typing import Any

from mortal_host import ready

from armdrive.cli.runner import CommandEnded, _signals
from kinematics import Motors

LONG_S = 600.0
SPEED = 0.3
"""So slow that no busy computer lets the motion reach its goal before its program is ended."""


class LineFailure(Exception):
    """Something that the program did not expect."""


def tell(**words: Any) -> None:
    os.write(1, (json.dumps(words) + "\n").encode())


def drive(port: str, dialect: str, order: dict[str, Any]) -> None:
    """Connect, reference, and move until something happens."""
    with ready(port, dialect, Motors(order["motors"])) as arm:
        there_deg = 80.0 if arm.joints.deg["base"] < 0.0 else -80.0
        arm.move_j(base_deg=there_deg, speed=SPEED, wait=False)
        tell()
        os.read(0, 1)  # the arm has been seen to move
        tell(silent_s=arm.status.silent_time_s, stop_s=arm.status.stop_time_s)
        if order.get("raises"):
            raise LineFailure
        threading.Event().wait(LONG_S)


def live(order: dict[str, Any]) -> int:
    """Drive as a command does, and return the exit code."""
    if "terminal" in order:
        os.setsid()
        terminal = os.open(order["terminal"], os.O_RDWR)
        fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)
    try:
        with _signals():
            drive(sys.argv[1], sys.argv[2], order)
    except CommandEnded as ended:
        return 128 + ended.number
    except LineFailure:
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(live(json.loads(sys.argv[3])))
