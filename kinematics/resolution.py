"""The finest motion of an arm's tip, motor by motor, and where a stated resolution comes from.

Source: McKerrow, chapter 4, section 14. The Mini-mover's papers state 0.28 mm (0.011 in). No
single number is true of the whole arm: one step of the base moves the tip by more the farther
out it is. The stated figure is what one half-step of the elbow's motor does anywhere: the forearm
over its steps per rad, 177.8 mm / 661.8 = 0.269 mm = 0.0106 in, rounded to 0.011 in and turned
back into 0.28 mm. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.accuracy import step_errors
from kinematics.five_axis import FiveAxisArm
from kinematics.presets import MM_PER_INCH
from kinematics.spaces import Joints
from kinematics.transmission import Transmission

_POSTURES_EACH_WAY = 4


@dataclass(frozen=True, slots=True)
class StepRange:
    """What one step of a motor does to the tip, from the least to the most over all postures."""

    motor: str
    least_mm: float
    most_mm: float

    @property
    def same_everywhere(self) -> bool:
        """Whether the posture makes no difference (to a millionth of the step)."""
        return self.most_mm - self.least_mm <= 1e-6 * self.most_mm

    def explains(self, stated_mm: float, thousandths_of_inch: float = 1.0) -> bool:
        """Whether a stated figure is this step's effect, as papers round it (to 0.001 in)."""
        rounding = thousandths_of_inch * MM_PER_INCH / 1000.0
        low, high = (round(value / rounding) * rounding for value in (self.least_mm, self.most_mm))
        return low - rounding / 2.0 <= stated_mm <= high + rounding / 2.0


def step_ranges(arm: FiveAxisArm, transmission: Transmission) -> tuple[StepRange, ...]:
    """Return what a step of each motor does over a lattice of postures within the limits."""
    rows = [step_errors(arm, transmission, joints) for joints in _lattice(arm)]
    return tuple(
        StepRange(
            column[0].cause,
            min(error.distance_mm for error in column),
            max(error.distance_mm for error in column),
        )
        for column in zip(*rows, strict=True)
    )


def explain_resolution(
    arm: FiveAxisArm, transmission: Transmission, stated_mm: float
) -> tuple[str, ...]:
    """Return one sentence a motor: what its step does, and whether that is the stated figure."""
    return tuple(_sentence(one, stated_mm) for one in step_ranges(arm, transmission))


def _sentence(one: StepRange, stated_mm: float) -> str:
    inches = f"{one.most_mm / MM_PER_INCH:.4f} in"
    if one.same_everywhere:
        said = f"one step of {one.motor} moves the tip by {one.most_mm:.3f} mm ({inches}) anywhere"
        if one.explains(stated_mm):
            return f"{said}: to the thousandth of an inch this is the stated {stated_mm:g} mm"
        return said
    said = (
        f"one step of {one.motor} moves the tip by {one.least_mm:.3f} to {one.most_mm:.3f} mm "
        f"(up to {inches}), depending on the posture"
    )
    if one.explains(stated_mm):
        return f"{said}: the stated {stated_mm:g} mm holds only somewhere between"
    return said


def _lattice(arm: FiveAxisArm) -> list[Joints]:
    """Return postures over the limits of shoulder, elbow and wrist; the ends are among them."""
    found: list[tuple[float, ...]] = [(0.0,)]
    for bounds in arm.limits[1:4]:
        width = bounds.high_rad - bounds.low_rad
        count = _POSTURES_EACH_WAY if math.isfinite(width) else 1
        values = [bounds.low_rad + width * step / count for step in range(count + 1)]
        values += [bounds.clamp(0.0)]
        found = [(*before, value) for before in found for value in values]
    return [Joints((arm.limits[0].clamp(0.0), *angles[1:], 0.0)) for angles in found]
