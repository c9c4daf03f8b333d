"""Print what a jog cycle costs: `python benchmarks/jogging.py [--json]`.

A cycle is a leg of the driver's course, with its bounds and guards, and all values made.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

from measuring import Section, interleaved, report, timing

from armdrive.config.arm import ArmConfig
from armdrive.connect.target import simulated_config
from armdrive.motion.jog.course import JogCourse, JogProposal, Wish
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import Jog
from armdrive.registry import dialect
from armdrive.runtime.position import ArmCoordinates
from kinematics import Joints

ROUNDS = 60
CYCLES = 200
CYCLE_S = 0.05
START = (0.3, 0.7, -1.4, -0.6, 0.2)


def course_of(config: ArmConfig) -> JogCourse:
    """Return the course of a jog on a GRBL board."""
    controller, model = dialect("grbl").controller(config), config.model
    assert model.transmission is not None
    speeds = SpeedLimits(
        model.joint_speeds_rad_s,
        model.gripper_speed_mm_s,
        controller.usable_rate_hz(math.inf),
        model.transmission,
    )
    run_on_s = controller.stopping(config.motion.jog_burst_s).asked_motion_s
    return JogCourse(config, speeds, queued=True, run_on_s=run_on_s)


def legs(jog: Jog) -> Callable[[], object]:
    """Return a run of legs of the driver's course, back and forth."""
    back = Jog(jog.space, tuple((name, -amount) for name, amount in jog.axes), jog.frame)
    config = simulated_config("grbl")

    def run() -> None:
        course, here = course_of(config), ArmCoordinates(Joints(START), 20.0)
        now_s = 0.0
        for index in range(CYCLES):
            wish = Wish(jog if index // 20 % 2 else back, 1.0)
            found = course.propose(wish, here, CYCLE_S)
            if isinstance(found, JogProposal):
                course.take(found)
                here = found.leg.end
                now_s += found.leg.duration_s

    return run


def course() -> Section:
    """Measure what the driver asks for a leg: bounds, guards and all values made."""
    cases = {
        "joints": legs(Jog.joint(base=1.0, elbow=-0.5)),
        "a line": legs(Jog.cartesian(x=0.6, y=-0.4, z=0.3)),
        "along the tool": legs(Jog.cartesian(frame="tool", z=1.0)),
    }
    taken = interleaved(cases, ROUNDS // 4)
    rows = tuple(
        timing(f"{name}: a leg of the course", seconds, "us", per=CYCLES)
        for name, seconds in taken.items()
    )
    return Section("a leg of the driver's course", rows, "of 50 ms each on a GRBL board")


SECTIONS: dict[str, Callable[[], Section]] = {"course": course}


def main(argv: list[str] | None = None) -> int:
    """Run the sections that are asked for, or all of them."""
    return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
