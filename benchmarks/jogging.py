"""Print what a jog cycle costs: `python benchmarks/jogging.py [--json]`.

One cycle of a Cartesian jog of the five-axis arm is: the ramp, the joints' rates, their scale
under the joints' speeds and stopping distances, and the posture where the line leads next. Beside
it stands the same of pinocchio (`pip install pin`): its Jacobian, a least-squares solve of the same
five rows and its integration, with the same ramp and limits in numpy, which is how one writes it
there. Below, the driver's own course with its guards, for the arms it drives.
"""

from __future__ import annotations

import importlib
import math
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
from measuring import Section, interleaved, timing
from reporting import report

from armdrive.config.arm import ArmConfig
from armdrive.connect.target import simulated_config
from armdrive.motion.jog.course import JogCourse, JogProposal, Terms, Wish
from armdrive.motion.jog.rates import ramped, share_of_limits, shares_to_stop
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
WISH = (60.0, -40.0, 30.0, 0.1, 0.0)
STILL = (0.0,) * 5
SLOPE = 100.0 / RAMP_S
LEAST = 4.0
MOST_US = 10.0


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


def pinocchio_arm(pin: ModuleType) -> tuple[Any, int]:
    """Return pinocchio's model of the arm in m, and its frame at the tip."""
    height, upper, fore, hand = (length / 1000.0 for length in preset("teachmover").arm.lengths)
    model = pin.Model()
    turns, down = np.eye(3), pin.JointModelRY
    lengths = ((0.0, height), (0.0, 0.0), (upper, 0.0), (fore, 0.0))
    kinds = (pin.JointModelRZ(), down(), down(), down())
    parent = 0
    for index, ((x, z), kind) in enumerate(zip(lengths, kinds, strict=True)):
        place = pin.SE3(turns, np.array([x, 0.0, z]))
        parent = model.addJoint(parent, kind, place, f"joint {index}")
    place = pin.SE3(turns, np.array([hand, 0.0, 0.0]))
    parent = model.addJoint(parent, pin.JointModelRX(), place, "roll")
    frame = pin.Frame("tip", parent, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
    return model, model.addFrame(frame)


def pinocchios(pin: ModuleType) -> Callable[[], object]:
    """Return the same run of cycles in pinocchio's way."""
    model, frame = pinocchio_arm(pin)
    data = model.createData()
    limits = np.array(preset("teachmover").joint_speeds_rad_s)
    ranges = preset("teachmover").arm.limits
    lows = np.array([one.low_rad for one in ranges])
    highs = np.array([one.high_rad for one in ranges])
    turn = np.array([1.0, -1.0, -1.0, -1.0, 1.0])  # its y axis turns downwards
    start = np.array(START) * turn
    lows, highs = np.minimum(lows * turn, highs * turn), np.maximum(lows * turn, highs * turn)
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    slope = SLOPE * CYCLE_S
    rolls = np.array([0.0, 0.0, 0.0, 0.0, 1.0])  # the roll is the hand's own

    def cycles() -> None:
        q, now = start.copy(), np.zeros(5)
        wish = np.array(WISH)
        for cycle in range(CYCLES):
            if cycle % 20 == 0:
                wish = -wish
            gap = wish - now
            most = np.abs(gap).max()
            now = now + gap * min(1.0, slope / most) if most else now
            pin.computeJointJacobians(model, data, q)
            jacobian = pin.getFrameJacobian(model, data, frame, aligned)
            c, s = math.cos(q[0]), math.sin(q[0])
            rows = np.vstack((jacobian[:3], s * jacobian[3] - c * jacobian[4], rolls))
            tip = now.copy()
            tip[:3] /= 1000.0
            rates = np.linalg.solve(rows, tip)
            share = min(1.0, (limits / np.maximum(np.abs(rates), 1e-9)).min())
            rates = rates * share
            room = np.where(rates > 0.0, highs - q, q - lows)
            ways = np.maximum(room, 0.0) / np.maximum(np.abs(rates), 1e-9)
            braked = 2.0 * ways / (CYCLE_S + np.sqrt(CYCLE_S**2 + 2.0 * RAMP_S * ways))
            q = pin.integrate(model, q, rates * min(1.0, braked.min()) * CYCLE_S)

    return cycles


def cycle() -> Section:
    """Measure one cycle's arithmetic, beside pinocchio's where it is installed."""
    cases = {"own": own()}
    try:
        cases["pinocchio"] = pinocchios(importlib.import_module("pinocchio"))
        note = f"at most {MOST_US:g} us, at least {LEAST:g} times as fast as pinocchio"
    except ImportError:
        note = "pinocchio is not installed: pip install pin"
    taken = interleaved(cases, ROUNDS)
    rows = []
    for name, values in taken.items():
        beside = {} if name == "own" else {"own": taken["own"]}
        rows.append(timing(f"{name}: a jog cycle", values, "us", per=CYCLES, beside=beside))
    return Section("the arithmetic of a jog cycle", tuple(rows), note)


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
