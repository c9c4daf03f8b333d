"""The physical arm and its surroundings, which no controller register sees.

    body       geometry, stops, fingers, backlash, sag, and the posture it begins in
    table      blocks: when one is gripped, carried, put down or knocked over
    saved      a world as plain data, for the next process

Motor positions are in half-steps of the model's own coordinates: all joints at zero means all
motors at zero. Incidents are kept in the order in which they happened.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import islice

from armdrive.errors.arguments import BASIC, checked_calls, known_attributes, made_of
from armdrive.sim.world.body import (
    MOST_FORCE_N,
    OPENING_STOP_MM,
    SWITCH_FORCE_N,
    ArmBody,
    Play,
    found_posture,
    sagged,
)
from armdrive.sim.world.table import (
    TABLE_TOLERANCE_MM,
    GripScene,
    Incident,
    IncidentKind,
    Point,
    Stand,
    TableBlock,
)
from kinematics.presets import preset
from kinematics.spaces import Joints, Motors, Pose
from kinematics.text import shown_name

# Calls made by people and tests. The other calls drive the motors, thousands of times a second.
BY_HAND = ("put", "take", "lose")
A_BLOCK = 'TableBlock("A", 250, 0)'

FOUND_OPENING_MM = 20.0  # of the fingers of a new arm
# Only this many of the latest incidents are kept.
MOST_INCIDENTS = 1000
_ROUNDING = 1e-6  # in steps and N


@known_attributes
@checked_calls({**BASIC, "TableBlock": made_of(TableBlock, "a block", A_BLOCK)}, *BY_HAND)
class World:
    """One arm, the true positions of its motors, and the blocks on its table.

    `stalled` holds the motors (counted from 0) that no longer follow their controller, and
    `to_lose` how many of its next steps each motor will lose.
    """

    def __init__(
        self,
        body: ArmBody | None = None,
        motors: Sequence[int] | None = None,
        blocks: Iterable[TableBlock] = (),
        stand: Stand | None = None,
    ) -> None:
        """Create the arm at rest. Without a `stand` it has a table of its own."""
        self.body = body or ArmBody.of_preset(preset("teachmover"))
        self.energised = True
        self.incidents: list[Incident] = []
        self.stalled: set[int] = set()
        self.play = Play(self.body.play)
        self.to_lose: dict[int, int] = {}
        self._fingers_mm = FOUND_OPENING_MM
        found = self.body.transmission.to_motors(found_posture(self.body.arm), FOUND_OPENING_MM)
        self._motors = found if motors is None else Motors(motors)
        self._stops = self.body.stops
        self._sample_steps = self.body.sample_steps
        self._has_gripper = self.body.transmission.has_gripper
        self._most_squeeze_mm = self.body.squeeze_mm(MOST_FORCE_N)
        self._blocked: set[str] = set()
        """The joints at their stops, `gripper` and `table`: a contact is reported once."""
        self._observe()
        self.scene = GripScene(blocks, None, self.tip, self._pull_mm, stand)

    @property
    def motors(self) -> Motors:
        """The true motor positions, after backlash."""
        return self._motors

    @property
    def joints(self) -> Joints:
        """The true joint angles."""
        return self._joints

    @property
    def pose(self) -> Pose:
        """The true pose of the hand."""
        return self._pose

    @property
    def tip(self) -> Point:
        """The true position of the tip, in mm."""
        return self._pose.x_mm, self._pose.y_mm, self._pose.z_mm

    @property
    def opening_mm(self) -> float:
        """The width between the fingers, limited by any block between them."""
        return max(self._pull_mm, self.scene.contact_mm, 0.0)

    @property
    def fingers_mm(self) -> float:
        """The opening commanded by a servo or a valve, ignoring any block between the fingers."""
        return self._fingers_mm

    @property
    def grip_force_n(self) -> float:
        """The force with which the fingers press on a block or on each other."""
        if not self._has_gripper:
            return 0.0
        return self.body.force_n(self.scene.contact_mm - self._pull_mm)

    @property
    def grip_switch(self) -> bool:
        """Whether the grip switch has tripped."""
        return self.grip_force_n >= SWITCH_FORCE_N - _ROUNDING

    def put(self, block: TableBlock) -> TableBlock:
        """Put a block down; return where it came to rest, possibly on other blocks.

        A block of that name is moved there, even out of the fingers.
        """
        return self.scene.put(block)

    def take(self, name: str) -> TableBlock:
        """Take a block away. Raises `BadRequest` if there is no block of that name."""
        return self.scene.take(name)

    def restore_blocks(self, blocks: Iterable[TableBlock], held: str | None) -> None:
        """Restore the blocks of a saved world, one of them possibly in the fingers."""
        self.scene = GripScene(blocks, held, self.tip, self._pull_mm)

    def steps_to_trip(self) -> Motors:
        """Return the steps that close the fingers until the switch trips; 0 if it has."""
        if self.grip_switch or not self._has_gripper:
            return Motors((0,) * len(self._motors))
        squeeze_mm = self.body.squeeze_mm(SWITCH_FORCE_N)
        return self._gripper_steps(self.scene.contact_mm - squeeze_mm)

    def drive(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn all motors in proportion, as commanded; stalled motors do not follow."""
        if self.stalled or self.to_lose:
            steps = [self._followed(motor, count) for motor, count in enumerate(steps)]
        self.force(self.play.drive(steps), time_s)

    def lose(self, motor: int, steps: int) -> None:
        """Make a motor lose its next commanded steps, in either direction."""
        self.to_lose[motor] = self.to_lose.get(motor, 0) + steps

    def force(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Turn motors by these steps, whatever the cause, and update the world."""
        last = len(steps) - self._has_gripper
        pieces = 1 + max(map(abs, islice(steps, last)), default=0) // self._sample_steps
        if pieces == 1:  # the usual case, because a moving arm is updated often
            self._shift(Motors(steps), time_s)
            return
        made = Motors((0,) * len(steps))
        for piece in range(1, pieces + 1):
            share = Motors(count * piece // pieces for count in steps)
            self._shift(share - made, time_s)
            made = share

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        """Let motors without current sag by these steps while others hold."""
        self.force(steps, time_s)

    def drive_to(self, motors: Sequence[int], time_s: float = 0.0) -> None:
        """Turn all motors in proportion to these positions, whatever holds them."""
        self.force(Motors(motors) - self._motors, time_s)

    def move_fingers(self, opening_mm: float, time_s: float = 0.0) -> None:
        """Open or close fingers that are driven by a servo or a valve instead of a gripper motor.

        A block between the fingers keeps them apart.
        """
        self._fingers_mm = min(max(opening_mm, 0.0), OPENING_STOP_MM)
        self.force((0,) * len(self._motors), time_s)

    def cut_current(self, time_s: float = 0.0) -> None:
        """Switch the motor current off: the spring opens the fingers, and the arm sags."""
        if not self.energised:
            return
        self.energised = False
        if self.grip_force_n > 0.0:
            self.force(self._gripper_steps(self.scene.contact_mm), time_s)
        rest = sagged(self.body.arm, self._joints)
        there = self.body.transmission.to_motors(rest, self._pull_mm)
        self.force(there - self._motors, time_s)

    def _followed(self, motor: int, count: int) -> int:
        """Return how many of the commanded steps a motor really makes."""
        if motor in self.stalled:
            return 0
        lost = min(abs(count), self.to_lose.get(motor, 0))
        if lost:
            self.to_lose[motor] -= lost
        return int(math.copysign(abs(count) - lost, count))

    def _shift(self, steps: Motors, time_s: float) -> None:
        # Stops come first: a tip that is held back touches no block beyond. The fingers come after
        # the scene, which knows whether they have just closed on a block.
        before = self.tip
        self._motors = self._motors + steps
        self._observe()
        for joint, stop in enumerate(self._stops):
            name, angle_rad = self._joints.names[joint], self._joints.angles_rad[joint]
            if name in self._blocked or not stop.low_rad <= angle_rad <= stop.high_rad:
                self._stop_joint(joint, name, stop.clamp(angle_rad), time_s)
        if incidents := self.scene.follow(before, self.tip, self._pull_mm, time_s):
            self._tell(*incidents)
        if self._has_gripper:
            self._stop_fingers(time_s)
        self._feel_table(time_s)

    def _stop_joint(self, joint: int, name: str, bound_rad: float, time_s: float) -> None:
        """Keep a joint at its mechanical stop: its motors lose the steps beyond it."""
        if self._joints[joint] == bound_rad:
            self._blocked.discard(name)
            return
        held = self.body.transmission.to_motors(
            self._joints.replace(**{name: bound_rad}), self._pull_mm
        )
        lost = self.body.stalls[joint]
        self._motors = Motors(
            held[index] if index in lost else count for index, count in enumerate(self._motors)
        )
        self._observe()
        self._block(name, f"the {shown_name(name)} is at its mechanical stop", time_s)

    def _stop_fingers(self, time_s: float) -> None:
        """Keep the fingers between their widest opening and the motor's greatest pull."""
        tightest = self.scene.contact_mm - self._most_squeeze_mm
        bound = min(max(self._pull_mm, tightest), OPENING_STOP_MM)
        if bound == self._pull_mm:
            self._blocked.discard("gripper")
            return
        self._motors = self._motors + self._gripper_steps(bound)
        self._observe()
        self._block("gripper", "the gripper's motor is blocked", time_s)

    def _block(self, name: str, sentence: str, time_s: float) -> None:
        if name not in self._blocked:
            self._blocked.add(name)
            loses = f"{sentence} and loses steps"
            self._tell(Incident(IncidentKind.STOP, name, loses, time_s))

    def _tell(self, *incidents: Incident) -> None:
        """Keep an incident, and drop the oldest if there are too many."""
        self.incidents += incidents
        del self.incidents[:-MOST_INCIDENTS]

    def _feel_table(self, time_s: float) -> None:
        depth_mm = -self._pose.z_mm
        if depth_mm <= TABLE_TOLERANCE_MM:
            self._blocked.discard("table")
        elif "table" not in self._blocked:
            self._blocked.add("table")
            sentence = f"the finger tips were driven {depth_mm:.1f} mm into the table"
            self._tell(Incident(IncidentKind.TABLE, "tip", sentence, time_s))

    def _gripper_steps(self, opening_mm: float) -> Motors:
        """Return the gripper motor's steps to an opening, rounded so as not to fall short of it."""
        *others, wanted = self.body.transmission.to_exact(self._joints, opening_mm)
        exact = wanted - self._motors[-1]
        whole = math.copysign(math.ceil(abs(exact) - _ROUNDING), exact)
        return Motors((*(0 for _ in others), int(whole)))

    def _observe(self) -> None:
        self._joints, pull_mm = self.body.transmission.to_joints(self._motors)
        self._pull_mm = pull_mm if self._has_gripper else self._fingers_mm
        self._pose = self.body.arm.fk(self._joints)
