"""Postures from which a simulated arm is jogged into its bounds, and the jogs that lead there."""

from __future__ import annotations

import math
import random
from dataclasses import replace

from jog_probes import Probe

from armdrive import Jog
from armdrive.arm import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.moves import CARTESIAN_AXES, GRIPPER_AXIS
from armdrive.registry import simulate
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import State
from kinematics import Joints
from kinematics.guards.shapes import Box

WALL = Box("wall", (-500.0, 250.0, -10.0), (500.0, 254.0, 700.0))
RADII_MM = (35.0, 30.0, 25.0)
NEAR_S = 0.8
"""A joint starts so near to its limit, at the speed that the device makes of full speed."""

COARSE_MM = 1.0
CLEAR_MM = 3.0


class Stand:
    """One simulated arm that is put into postures drawn at random, and jogs that lead to bounds.

    `share` is what the device makes of full speed.
    """

    share = 1.0

    def __init__(self, dialect: str, seed: int, *, over_base: bool = False) -> None:
        config = simulated_config(dialect)
        guards = replace(config.model.guards, radii_mm=RADII_MM, boxes=(WALL,))
        if over_base:
            guards = replace(guards, inner_radius_mm=None, hand_wrist_radius_mm=None)
        self.config = replace(config, model=replace(config.model, guards=guards))
        self.draw = random.Random(f"{seed} {dialect} {over_base}")
        self.twin = simulate(self.config)
        self.arm: Arm = Arm(connect_simulated(self.config, twin=self.twin))
        if self.arm.status.state is State.DISABLED:
            self.arm.enable()
        self.probe = Probe(self.config)

    def stand(self, joints: Joints, opening_mm: float) -> None:
        """Have the arm stand there, referenced."""
        self.arm.stop()
        world = self.twin.world
        world.drive_to(self.arm.core.transmission.to_motors(joints, opening_mm))
        self.arm.declare_posture(world.joints, opening_mm=world.opening_mm)

    def anywhere(self) -> tuple[Joints, float]:
        """Return a random posture clear of all guards."""
        while True:
            angles = (self.draw.uniform(b.low_rad, b.high_rad) for b in self.probe.geometry.limits)
            joints = Joints(tuple(angles))
            if self.probe.guarded.room_mm(joints) > CLEAR_MM:
                return joints, self.draw.uniform(*self.config.model.gripper_range_mm)

    def into_limit(self) -> tuple[str, Jog, Joints, float]:
        """Return a jog of one or two joints, the first of which is near its limit."""
        names = (*self.probe.geometry.joint_names, GRIPPER_AXIS)
        name, way = self.draw.choice(names), self.draw.choice((-1.0, 1.0))
        what = f"{name} {'high' if way > 0 else 'low'}"
        other = self.draw.choice([each for each in names if each != name])
        amounts = {name: way, other: self.draw.choice((0.0, 0.0, 1.0, -1.0))}
        jog = Jog.joint(**{each: amount for each, amount in amounts.items() if amount})
        while True:
            joints, opening_mm = self.anywhere()
            if name == GRIPPER_AXIS:
                return what, jog, joints, opening_mm
            index = self.probe.geometry.joint_names.index(name)
            bounds = self.probe.geometry.limits[index]
            speed = self.config.model.joint_speeds_rad_s[index] * self.share
            near = speed * NEAR_S * self.draw.uniform(0.1, 1.0)
            angle = bounds.high_rad - near if way > 0 else bounds.low_rad + near
            joints = joints.replace(**{name: angle})
            if self.probe.guarded.room_mm(joints) > CLEAR_MM:
                return what, jog, joints, opening_mm

    def into_guard(self) -> tuple[str, Jog, Joints, float]:
        """Return a line of the tip that leads to a guard, a limit or the edge of the reach."""
        joints, opening_mm = self.anywhere()
        tip = self.probe.geometry.fk(joints)
        r = max(math.hypot(tip.x_mm, tip.y_mm), 1.0)
        outwards = {"x": tip.x_mm / r, "y": tip.y_mm / r}
        inwards = {axis: -amount for axis, amount in outwards.items()}
        what, amounts, frame = self.draw.choice(
            (
                ("table", {"z": -1.0}, "base"),
                ("outwards", outwards, "base"),
                ("inwards", inwards, "base"),
                ("wall", {"y": 1.0}, "base"),
                ("pitch", {"pitch": self.draw.choice((-1.0, 1.0))}, "base"),
                ("along the tool", {"z": 1.0}, "tool"),
                ("any", {axis: self.draw.uniform(-1, 1) for axis in CARTESIAN_AXES}, "base"),
            )
        )
        jog = Jog.cartesian(frame=frame, **amounts)
        return what, jog, self._nearer(jog, joints), opening_mm

    def _nearer(self, jog: Jog, joints: Joints) -> Joints:
        """Return a posture further on along a line, not far before it meets a bound."""
        before_mm = self.draw.uniform(2.0, 60.0) * min(self.share, 1.0)
        passed = [joints]
        for there in self.probe.onwards(jog, ArmCoordinates(joints, 0.0), COARSE_MM):
            if there is None or self.probe.guarded.room_mm(there.joints) <= 0.0:
                break
            passed.append(there.joints)
        return passed[max(len(passed) - 1 - math.ceil(before_mm / COARSE_MM), 0)]

    def over_base(self) -> tuple[str, Jog, Joints, float]:
        """Return a line that passes the base axis at a few mm, where the base has to turn fast."""
        while True:
            joints, opening_mm = self.anywhere()
            tip = self.probe.geometry.fk(joints)
            r = math.hypot(tip.x_mm, tip.y_mm)
            if not 40.0 < r < 100.0:
                continue
            beside = self.draw.uniform(1.0, 15.0) / r
            x = -(tip.x_mm - beside * tip.y_mm) / r
            y = -(tip.y_mm + beside * tip.x_mm) / r
            most = max(abs(x), abs(y))
            return "over the base", Jog.cartesian(x=x / most, y=y / most), joints, opening_mm
