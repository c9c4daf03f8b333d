"""Programs that drive a real port until something ends them, a child for each.

`python ending_host.py` is a host of forking.py, whose orders have the `port` and the `dialect` of
an arm, and the folder `home` for its records. A child references the arm by where its `motors`
stand and sets out on a long way; with `terminal` it has that pseudo-terminal for its own. Its
number is told then, and what its status announces at the next line that it gets, when it raises
where the order has `raises`. With `script` the child runs that text instead, and ends as Python
ends a script; its errors are written to the file `errors`.
"""

import fcntl
import os
import termios
from functools import partial
from typing import Any

from forking import end, order_of_child, ready, tell
from waiting import until

from armdrive import Arm
from armdrive.cli.runner import CommandEnded, _signals
from kinematics import Motors

SPEED = 0.3
"""So slow that no busy computer lets the motion reach its goal before its program is ended."""


class LineFailure(Exception):
    """Something that the program did not expect."""


def under_way(arm: Arm) -> None:
    """Tell that a motion has begun; wait until it has been seen, and tell its bounds."""
    tell()
    os.read(0, 1)
    tell(silent_s=arm.status.silent_time_s, stop_s=arm.status.stop_time_s)


def drive(order: dict[str, Any]) -> None:
    """Connect, reference, and move until something happens."""
    with ready(order["port"], order["dialect"], Motors(order["motors"])) as arm:
        there_deg = 80.0 if arm.joints.deg["base"] < 0.0 else -80.0
        arm.move_j(base_deg=there_deg, speed=SPEED, wait=False)
        under_way(arm)
        if order.get("raises"):
            raise LineFailure
        # short sleeps: Python notices a signal that comes just before a sleep only after it
        until(lambda: False, "nothing ended the program")


def live(order: dict[str, Any]) -> int:
    """Drive as a command does, and return the exit code."""
    if "terminal" in order:
        os.setsid()
        terminal = os.open(order["terminal"], os.O_RDWR)
        fcntl.ioctl(terminal, termios.TIOCSCTTY, 0)
    try:
        with _signals():
            drive(order)
    except CommandEnded as ended:
        return 128 + ended.number
    except LineFailure:
        return 1
    return 0


def run_script(order: dict[str, Any]) -> None:
    """Run a script in a child, which then ends by itself."""
    os.dup2(os.open(order["errors"], os.O_CREAT | os.O_WRONLY | os.O_TRUNC), 2)
    exec(order["script"], {"under_way": under_way, "order": order})


def main() -> None:
    """Have one child after the other."""
    order = order_of_child()
    if order is None:
        return
    os.environ["ARMDRIVE_HOME"] = order["home"]
    if "script" in order:
        run_script(order)
    else:
        end(partial(live, order))


if __name__ == "__main__":
    main()
