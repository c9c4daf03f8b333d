"""A program that drives a real port and kills itself, really, at the moment it is told to.

`python mortal_host.py PORT DIALECT` is a host of forking.py. A child references the arm by where
its `motors` physically stand, makes two short moves with a rest of `still_s` between, and ends by
SIGKILL: at a `disk` operation or a `wire` write of this number (after so many `bytes` of it),
counted from the first move on, once a motion is under way where it says `moving`, or after
`after_s` seconds.
"""

import os
import signal
import sys
import threading
import time
from typing import Any

from forking import end, order_of_child, ready
from waiting import until

from armdrive import Arm
from armdrive.runtime import persistence
from armdrive.storage.files import StateFiles
from kinematics import Motors

MOVE_DEG = 4.0
BEYOND_S = 0.3
OPERATIONS = ("make_folder", "create", "write", "sync", "close", "replace", "sync_folder")


def die() -> None:
    """End as by a power switch: nothing is closed, flushed or said."""
    os.kill(os.getpid(), signal.SIGKILL)


def mortal_disk(count: int) -> None:
    """Die just before the operation of this number, beginning with 0."""
    left = [count]

    def wrapped(name: str) -> None:
        inner = getattr(StateFiles, name)

        def operation(self: StateFiles, *args: Any) -> Any:
            if left[0] == 0:
                die()
            left[0] -= 1
            return inner(self, *args)

        setattr(StateFiles, name, operation)

    for name in OPERATIONS:
        wrapped(name)


def mortal_wire(arm: Arm, count: int, sent: int) -> None:
    """Die in the write of this number, after so many of its bytes."""
    left, write = [count], arm.parts.engine.link.write

    def mortal(data: bytes, now_s: float) -> None:
        if left[0] == 0:
            write(data[:sent], now_s)
            die()
        left[0] -= 1
        write(data, now_s)

    arm.parts.engine.link.write = mortal  # type: ignore[method-assign]


def under_way(arm: Arm) -> None:
    """Wait until a part of a motion has been sent."""
    start = arm.status.commanded
    until(lambda: arm.status.commanded != start, "no motion began")


def live(port: str, dialect: str, order: dict[str, Any]) -> int:
    """Connect, reference, and move until death; return 0 if that has not come."""
    persistence.STILL_S = order.get("still_s", persistence.STILL_S)
    arm = ready(port, dialect, Motors(order["motors"]))
    if "disk" in order:
        mortal_disk(order["disk"])
    if "wire" in order:
        mortal_wire(arm, order["wire"], order.get("bytes", 0))
    if order.get("moving"):
        threading.Thread(target=lambda: (under_way(arm), die()), daemon=True).start()
    if "after_s" in order:
        threading.Thread(target=lambda: (time.sleep(order["after_s"]), die()), daemon=True).start()
    name, angle_deg = next(iter(arm.joints.deg.items()))
    by_deg = order.get("move_deg", MOVE_DEG)
    there_deg = angle_deg - by_deg if angle_deg > 0 else angle_deg + by_deg
    arm.move_j(**{f"{name}_deg": there_deg})
    arm.sleep(persistence.STILL_S + BEYOND_S)
    arm.move_j(**{f"{name}_deg": angle_deg})
    arm.close()
    return 0


def main() -> None:
    """Have one child after the other."""
    if (order := order_of_child()) is not None:
        port, dialect = sys.argv[1:]
        end(lambda: live(port, dialect, order))


if __name__ == "__main__":
    main()
