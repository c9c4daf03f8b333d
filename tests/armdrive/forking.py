"""A host that forks a child for each program, so that what Python takes to start is paid once.

A host reads one JSON object a line, the order of the next child, and tells when that child has
ended: by 0 or its exit code, or by the negative number of the signal that killed it.
"""

import json
import os
import subprocess
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

sys.path.insert(0, str(Path(__file__).parents[1]))  # a host is run by its path

from armdrive import Arm
from armdrive.status import State
from kinematics import Motors

FAILED = 99
"""How a child ends that fails in another way than it should."""


def host(name: str, *words: str) -> subprocess.Popen[str]:
    """Return a host that is running: a script beside this one, with these arguments."""
    return subprocess.Popen(
        [sys.executable, str(Path(__file__).with_name(name)), *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        bufsize=1,
    )


def order_of_child() -> dict[str, Any] | None:
    """Return its order to each child; None to the host itself, once there are no more orders."""
    for line in sys.stdin:
        order: dict[str, Any] = json.loads(line)
        child = os.fork()
        if child == 0:
            return order
        _, ended = os.waitpid(child, 0)
        tell(ended=os.waitstatus_to_exitcode(ended))
    return None


def tell(**words: Any) -> None:
    """Tell this to whoever has begun the host."""
    os.write(1, (json.dumps({"pid": os.getpid(), **words}) + "\n").encode())


def end(live: Callable[[], int]) -> NoReturn:
    """Live in a child, and end with the exit code."""
    code = FAILED
    try:
        code = live()
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def ready(port: str, dialect: str, motors: Motors) -> Arm:
    """Connect, and say where the arm stands."""
    arm = Arm.connect(port, dialect=dialect)
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    if arm.status.state is State.DISABLED:
        arm.enable()
    assert arm.model.transmission is not None
    joints, opening_mm = arm.model.transmission.to_joints(motors)
    arm.reference.declare(joints, opening_mm=opening_mm)
    return arm
