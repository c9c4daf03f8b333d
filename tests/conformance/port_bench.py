"""A bench with a real arm on a real port, and a person beside it with a hand on its switch.

Nobody sees the motors here but the arm's own registers, which are asked while it stands.
"""

from __future__ import annotations

import hashlib
import tempfile
import time
from pathlib import Path
from typing import ClassVar

from filelock import FileLock

from armdrive.arm import Arm
from armdrive.dialog.operator import Operator
from armdrive.errors import ArmError, Refused
from armdrive.sim.world.body import found_posture
from armdrive.status import State, Status, Trust
from kinematics import Motors

from .real_time_bench import RealTimeBench
from .seen import Seen

SLOWLY = 0.3


def port_lock(port: str) -> FileLock:
    """Return the lock of a port: tests take turns on it, whichever process they run in.

    The driver's own lock lies under `ARMDRIVE_HOME`, of which every test has another one.
    """
    name = hashlib.sha256(str(Path(port).resolve()).encode()).hexdigest()[:16]
    return FileLock(Path(tempfile.gettempdir()) / f"armdrive-bench-{name}.lock")


class PortBench(RealTimeBench):
    """A real arm, which stands in its reference posture when the first row begins."""

    transport: ClassVar[str] = "port"
    look_s: ClassVar[float] = 0.02
    simulated: ClassVar[bool] = False
    sees_motion: ClassVar[bool] = False
    _begun: ClassVar[bool] = False

    def __init__(self, dialect_name: str, port: str) -> None:
        super().__init__(dialect_name)
        self._lock = port_lock(port)
        self._lock.acquire()
        self.take_port(port)
        self._last = Motors([0] * self.row.abilities.motors)

    def end_device(self) -> None:
        """Let others have the port."""
        self._lock.release()

    def look(self) -> Seen:
        """Ask a standing arm for its registers; of a moving one, take what was told last."""
        if self.arm is not None:
            self._last = _told(self.arm, self._last)
        return Seen(time.monotonic(), self._last, self.tip(self._last), self.posture(self._last)[1])

    def refer(self, arm: Arm) -> None:
        """Confirm what the last row has left behind; of the first, the reference posture.

        Before the run the person beside the arm has brought it to its reference posture. It then
        goes to where simulated arms are found: raised, and clear of the table.
        """
        self.switch_on(arm)
        trust = arm.status.trust
        if trust is Trust.RESTORED:
            arm.confirm_restored()
        elif trust is Trust.UNKNOWN and not self._begun:
            arm.confirm_reference()
        else:
            raise Refused(
                f"the position is {trust.value}: bring the arm to its reference posture and begin "
                "anew with the rows that are left"
            )
        type(self)._begun = True
        found = found_posture(arm.model.arm)
        arm.move_j(speed=SLOWLY, **{f"{name}_deg": angle for name, angle in found.deg.items()})

    def operator(self) -> Operator:
        """Nobody is asked in the middle of a test."""
        raise Refused("a real arm is referenced by `armdrive home`")

    def fault(self, words: str) -> None:
        """Nobody harms a real arm."""
        raise Refused(f"no fault is made on a real arm: {words}")

    def heal(self) -> None:
        """Nothing was harmed."""


def _told(arm: Arm, last: Motors) -> Motors:
    status: Status = arm.status
    if status.state in (State.STANDBY, State.DISABLED):
        try:
            arm.read_inputs()
        except ArmError:
            return last
        status = arm.status
    return status.read_back or last
