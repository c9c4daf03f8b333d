"""Programs that drive a real port until something ends them, a child for each.

`python ending_host.py` reads one JSON object a line, with the `port` and the `dialect` of an arm,
and the folder `home` for its records. Each forks a child, so that what Python takes to start is
paid once. The child references the arm by where its `motors` stand and sets out on a long way; with
`terminal` it has that pseudo-terminal for its own. Its number is told then, what its status
announces at the next line that it gets, when it raises where the order has `raises`, and how it
ended when it has. With `script` the child runs that text instead, and ends as Python ends a script;
its errors are written to the file `errors`.
"""

import contextlib
import fcntl
import json
import os
import sys
import termios
import traceback
from typing import Any

from mortal_host import ready
from waiting import until

from armdrive import Arm
from armdrive.cli.runner import CommandEnded, _signals
from kinematics import Motors

SPEED = 0.3
"""So slow that no busy computer lets the motion reach its goal before its program is ended."""


class LineFailure(Exception):
    """Something that the program did not expect."""


def tell(**words: Any) -> None:
    os.write(1, (json.dumps({"pid": os.getpid(), **words}) + "\n").encode())


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


def die_or_end(order: dict[str, Any]) -> None:
    """Live in a child, and never return."""
    code = 99
    with contextlib.suppress(BaseException):
        try:
            code = live(order)
        except BaseException:
            traceback.print_exc()
    os._exit(code)


def run_script(order: dict[str, Any]) -> None:
    """Run a script in a child, which then ends by itself."""
    os.dup2(os.open(order["errors"], os.O_CREAT | os.O_WRONLY | os.O_TRUNC), 2)
    exec(order["script"], {"under_way": under_way, "order": order})


def main() -> None:
    """Have one child after the other."""
    for line in sys.stdin:
        order = json.loads(line)
        child = os.fork()
        if child == 0:
            os.environ["ARMDRIVE_HOME"] = order["home"]
            if "script" in order:
                return run_script(order)
            die_or_end(order)
        _, ended = os.waitpid(child, 0)
        tell(ended=os.waitstatus_to_exitcode(ended))
    return None


if __name__ == "__main__":
    main()
