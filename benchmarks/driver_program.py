"""A program that drives an arm on request, in a process that a test can kill.

    python -m benchmarks.driver_program PORT DIALECT

Each line of the standard input is a JSON list: a method of `CommandDriver` and its arguments. The
program answers each with one line: the result as JSON.
"""

import contextlib
import json
import sys
import threading

from armdrive.arm import Arm
from armdrive.errors import ArmError
from armdrive.status import State
from kinematics import LinePart, Motors
from tests.conformance.motions import begin_sweep, shifted, sweeping_jog

JOG_S = 30.0
SWEEP_DEG = 55.0
PATH_MM, BLEND_MM = 60.0, 15.0
MIDDLE_DEG = {
    "base_deg": 0.0,
    "shoulder_deg": 60.0,
    "elbow_deg": -90.0,
    "wrist_pitch_deg": -30.0,
    "wrist_roll_deg": 0.0,
}


class CommandDriver:
    """The commands, one method each."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm

    def reference(self, motors: list[int]) -> None:
        """Switch the motors on, and declare where they stand."""
        if self._arm.status.state is State.ERROR_STOP:
            self._arm.reset()
        if self._arm.status.state is State.DISABLED:
            self._arm.enable()
        joints, opening_mm = self._arm.parts.core.transmission.to_joints(Motors(motors))
        self._arm.reference.declare(joints, opening_mm=opening_mm)

    def middle(self) -> None:
        """Move to a posture with room on all sides."""
        self._arm.move_j(**MIDDLE_DEG)  # type: ignore[call-overload]

    def jog(self, direction: float) -> None:
        """Begin a jog of three joints at full speed, until `release`."""
        axes = {name: share * direction for name, share in sweeping_jog(self._arm).axes}
        threading.Thread(target=self._jog, args=(axes,), daemon=True).start()

    def _jog(self, axes: dict[str, float]) -> None:
        with contextlib.suppress(ArmError):  # `state` tells how it ended
            self._arm.jog_j(**axes, speed=1.0, duration_s=JOG_S)

    def move(self, direction: float) -> None:
        """Begin a planned joint motion at full speed."""
        begin_sweep(self._arm, SWEEP_DEG * direction)

    def path(self, direction: float) -> None:
        """Begin a path of two lines with a blend between them."""
        corner = shifted(self._arm.pose, y_mm=PATH_MM * direction)
        end = shifted(corner, z_mm=PATH_MM * direction)
        self._arm.move_path([LinePart(corner, BLEND_MM), LinePart(end)], wait=False)

    def release(self) -> None:
        """Release the jog."""
        self._arm.jogging.release()

    def stop(self) -> None:
        """Request a stop."""
        self._arm.request_stop()

    def bounds(self) -> list[float]:
        """Return the announced bounds: of a stop, and of a silent program, in s and mm."""
        status = self._arm.status
        return [
            status.stop_time_s,
            status.stop_distance_mm,
            status.silent_time_s,
            status.silent_distance_mm,
        ]

    def state(self) -> str:
        """Return the state of the arm."""
        return self._arm.status.state.value


def main(port: str, dialect: str) -> None:
    """Run one command after the other until the end of the input."""
    with Arm.connect(port, dialect=dialect) as arm:
        driver = CommandDriver(arm)
        answer("ready")
        for line in sys.stdin:
            name, *words = json.loads(line)
            answer(getattr(driver, name)(*words))


def answer(value: object) -> None:
    """Write the result of a command."""
    sys.stdout.write(json.dumps(value) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:3])
