"""One pose, forwards and back: on bare floats and on value types, beside the sines they need."""

from __future__ import annotations

import math
import random
from math import acos, atan2, cos, hypot, sin, sqrt
from statistics import median

from measuring import Row, Section, interleaved, ratio

from kinematics import Joints, preset
from kinematics.five_axis import closed_form
from kinematics.five_axis.closed_form import Angles

SEED = 1982
MODEL = "minimover5"
START: Angles = (0.0, 0.6, -1.2, -0.6, 0.0)
MARGIN_RAD = math.radians(2.0)


def forward_floor(angles: Angles) -> tuple[float, ...]:
    """Take as many sines and cosines as the forward solution does, and nothing else."""
    a, b, c, d, _ = angles
    return cos(a), sin(a), cos(b), sin(b), cos(c), sin(c), cos(d), sin(d)


def inverse_floor(goal: Angles) -> tuple[float, ...]:
    """Take as many roots, sines and arc tangents as all four branches do, and nothing else."""
    x, y, z, pitch, roll = goal
    return (
        *(hypot(x, y), cos(pitch), sin(pitch), sqrt(x * x), acos(0.5)),
        *(atan2(y, x), atan2(z, x), atan2(y, roll)),
    )


def postures(count: int) -> list[Angles]:
    """Return postures within the limits, the same ones in every run."""
    chance = random.Random(SEED)
    ranges = preset(MODEL).arm.limits
    found = []
    for _ in range(count):
        b, s, e, w, r = (
            chance.uniform(one.low_rad + MARGIN_RAD, one.high_rad - MARGIN_RAD) for one in ranges
        )
        found.append((b, s, e, w, r))
    return found


def solving(poses: int = 500, rounds: int = 60) -> Section:
    """Measure both directions over the same poses."""
    arm = preset(MODEL).arm
    angles = postures(poses)
    joints = [Joints(each) for each in angles]
    lengths = arm.lengths
    goals = [closed_form.forward(each, lengths) for each in angles]
    targets = [arm.fk(each) for each in joints]
    seed = Joints(START)
    cases = {
        "floor, forwards (8 sines)": lambda: [forward_floor(each) for each in angles],
        "FK, bare floats (closed_form.forward)": lambda: [
            closed_form.forward(each, lengths) for each in angles
        ],
        "FK, value types (fk)": lambda: [arm.fk(each) for each in joints],
        "floor, backwards (8 calls of math)": lambda: [inverse_floor(each) for each in goals],
        "IK, four branches (closed_form.inverse)": lambda: [
            closed_form.inverse(each, lengths, START) for each in goals
        ],
        "IK, nearest within limits (solve_angles)": lambda: [
            arm.solve_angles(each, START) for each in goals
        ],
        "IK, value types (ik)": lambda: [arm.ik(each, seed) for each in targets],
    }
    taken = interleaved(cases, rounds)
    floors = [name for name in cases if name.startswith("floor")]
    rows = []
    for name, seconds in taken.items():
        floor = floors[0] if "FK" in name or name == floors[0] else floors[1]
        times = {} if name in floors else {"its floor": ratio(seconds, taken[floor])}
        rows.append(Row(name, median(seconds) / poses * 1e6, "us a pose", times=times))
    return Section(
        "One pose",
        tuple(rows),
        f"{poses} reachable poses of the {preset(MODEL).title}, medians of {rounds} rounds",
    )
