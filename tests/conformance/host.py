"""A program that drives an arm by words: `python -m tests.conformance.host PORT DIALECT`.

It is a process of its own so that it can be killed. Each line of its input, a JSON list, is
answered by one line.
"""

from __future__ import annotations

import json
import sys
import threading

from armdrive.arm import Arm
from armdrive.status import State
from kinematics import LinePart, Motors

from .going import begin_sweep, beside, first_jog

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


class Driver:
    """Obeys the commands."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm

    def refer(self, motors: list[int]) -> None:
        """Say where the arm stands, by its motors, and switch them on."""
        if self._arm.status.state is State.ERROR_STOP:
            self._arm.reset()
        if self._arm.status.state is State.DISABLED:
            self._arm.enable()
        transmission = self._arm.model.transmission
        assert transmission is not None
        joints, opening_mm = transmission.to_joints(Motors(motors))
        self._arm.declare_posture(joints, opening_mm=opening_mm)

    def middle(self) -> None:
        """Drive to where there is room on all sides."""
        self._arm.move_j(**MIDDLE_DEG)

    def jog(self, direction: float) -> None:
        """Sweep the tip at full speed until it is released, by three joints at once."""
        axes = {name: share * direction for name, share in first_jog(self._arm).axes}
        threading.Thread(
            target=self._arm.jog_j,
            kwargs={**axes, "speed": 1.0, "duration_s": JOG_S},
            daemon=True,
        ).start()

    def move(self, direction: float) -> None:
        """Begin a planned joint motion at full speed."""
        begin_sweep(self._arm, SWEEP_DEG * direction)

    def path(self, direction: float) -> None:
        """Begin a path of two lines with a blend between them."""
        corner = beside(self._arm.pose, y_mm=PATH_MM * direction)
        end = beside(corner, z_mm=PATH_MM * direction)
        self._arm.move_path([LinePart(corner, BLEND_MM), LinePart(end)], wait=False)

    def release(self) -> None:
        """Let go of the jog."""
        self._arm.release()

    def stop(self) -> None:
        """Ask for a stop."""
        self._arm.request_stop()

    def bounds(self) -> list[float]:
        """Tell what the status announces now."""
        status = self._arm.status
        return [
            status.stop_time_s,
            status.stop_distance_mm,
            status.silent_time_s,
            status.silent_distance_mm,
        ]

    def state(self) -> str:
        """Tell the state of the arm."""
        return self._arm.status.state.value


def main(port: str, dialect: str) -> None:
    """Obey one line after the other until the end of input."""
    with Arm.connect(port, dialect=dialect) as arm:
        driver = Driver(arm)
        answer("ready")
        for line in sys.stdin:
            name, *words = json.loads(line)
            answer(getattr(driver, name)(*words))


def answer(value: object) -> None:
    """Answer a line."""
    sys.stdout.write(json.dumps(value) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:3])
