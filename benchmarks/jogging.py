"""Print what a jog cycle costs: `python benchmarks/jogging.py [--json]`.

One cycle of a Cartesian jog of the five-axis arm is: the ramp, the joints' rates, their scale
under the joints' speeds and stopping distances, and the posture where the line leads next. Below,
the driver's own course with its guards.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

from measuring import Section, interleaved, report, timing

from armdrive.config.arm import ArmConfig
from armdrive.connect.target import simulated_config
from armdrive.motion.jog.course import JogCourse, JogProposal, Terms, Wish
from armdrive.motion.jog.rates import Rates, ramped, share_of_limits, shares_to_stop
from armdrive.motion.plan import SpeedLimits
from armdrive.moves import Jog
from armdrive.registry import dialect
from armdrive.runtime.position import ArmCoordinates
from kinematics import Joints
from kinematics.five_axis.rates import joint_rates
from kinematics.presets import preset

ROUNDS = 60
CYCLES = 200
CYCLE_S = 0.05
RAMP_S = 0.2
START = (0.3, 0.7, -1.4, -0.6, 0.2)
WISH: Rates = (60.0, -40.0, 30.0, 0.1, 0.0)
STILL: Rates = (0.0, 0.0, 0.0, 0.0, 0.0)
SLOPE = 100.0 / RAMP_S


def own() -> Callable[[], object]:
    """Return a run of cycles of this project's, back and forth."""
    model = preset("teachmover")
    arm, limits = model.arm, model.joint_speeds_rad_s
    bounds = tuple((one.low_rad, one.high_rad) for one in arm.limits)
    lengths, solve = arm.lengths, arm.solve_angles
    first = arm.fk(Joints(START))
    origin = (first.x_mm, first.y_mm, first.z_mm, first.pitch_rad, first.roll_rad)
    ramps_s = (RAMP_S,) * 5

    def cycles() -> None:
        angles, pose, now, wish = START, origin, STILL, WISH
        for cycle in range(CYCLES):
            if cycle % 20 == 0:
                wish = tuple(-rate for rate in wish)
            mean, now = ramped(now, wish, SLOPE, CYCLE_S)
            rates = joint_rates(angles, mean, lengths)
            if rates is None:
                continue
            share = share_of_limits(rates, limits)
            share *= min(shares_to_stop(angles, rates, bounds, CYCLE_S, ramps_s))
            far_s = share * CYCLE_S
            x, y, z, pitch, roll = pose
            vx, vy, vz, pitching, rolling = mean
            pose = (
                x + vx * far_s,
                y + vy * far_s,
                z + vz * far_s,
                pitch + pitching * far_s,
                roll + rolling * far_s,
            )
            angles = solve(pose, angles) or angles

    return cycles


def cycle() -> Section:
    """Measure one cycle's arithmetic."""
    taken = interleaved({"own": own()}, ROUNDS)["own"]
    row = timing("a jog cycle", taken, "us", per=CYCLES)
    return Section("The arithmetic of a jog cycle", (row,), f"medians of {ROUNDS} rounds")


def terms() -> tuple[ArmConfig, SpeedLimits, Terms]:
    """Return what the course of a jog on a GRBL board is made of."""
    config = simulated_config("grbl")
    controller, model = dialect("grbl").controller(config), config.model
    assert model.transmission is not None
    speeds = SpeedLimits(
        model.joint_speeds_rad_s,
        model.gripper_speed_mm_s,
        controller.usable_rate_hz(math.inf),
        model.transmission,
    )
    run_on_s = controller.stopping(config.motion.jog_burst_s).asked_motion_s
    return config, speeds, Terms(RAMP_S, queued=True, run_on_s=run_on_s)


def legs(jog: Jog) -> Callable[[], object]:
    """Return a run of legs of the driver's course, back and forth."""
    back = Jog(jog.space, tuple((name, -amount) for name, amount in jog.axes), jog.frame)
    made = terms()

    def run() -> None:
        course, here = JogCourse(*made), ArmCoordinates(Joints(START), 20.0)
        now_s = 0.0
        for index in range(CYCLES):
            wish = Wish(jog if index // 20 % 2 else back, 1.0)
            found = course.propose(wish, here, CYCLE_S, now_s)
            if isinstance(found, JogProposal):
                course.take(found, now_s)
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


SECTIONS: dict[str, Callable[[], Section]] = {"cycle": cycle, "course": course}


def main(argv: list[str] | None = None) -> int:
    """Run the sections that are asked for, or all of them."""
    return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
