"""A TeachMover that is not there: the device side of its dialect on a simulated physical arm.

Where the real arm's habit is unknown the harsher one is built: bytes that come in while a command
is unanswered are lost, the program memory is lost with the power, and after power-up the motors
are without current until the first motion. All times are seconds on the clock that is handed in.

What a person does beside the arm (keys, power, inputs, pushing) happens at the device's present
time, or through `at` at a stated one. Where a thread drives the device, these belong on that
thread, or under its lock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from armdrive.errors import BadRequest
from armdrive.sim.agenda import Action, Agenda
from armdrive.sim.drive import Drive
from armdrive.sim.rates import DEFAULT_RATES, RateTable, checked_error
from armdrive.sim.teachmover_box import STILL, ControllerBox, TwinSettings
from armdrive.sim.world import World
from firmware_protocol.teachmover import Key, ProgramRow
from kinematics.spaces import Joints, Motors, Pose

BAUD = 9600
_INPUT_BITS = 8


class SimTeachMover:
    """The controller box, the arm, and the person beside them; see `TwinSettings` for the rest."""

    def __init__(
        self,
        world: World | None = None,
        *,
        speed_table: RateTable = DEFAULT_RATES,
        speed_error: float = 0.0,
        baud: int = BAUD,
        keeps_input_while_moving: bool = False,
        delay_unit_s: float = 0.001,
        grip_bit: int = 0,
    ) -> None:
        self.world = world or World()
        self.baud = baud
        self.powered = True
        self.now_s = 0.0
        self._drive = Drive(self.world)
        self._agenda = Agenda()
        self._box = ControllerBox(
            self._drive,
            TwinSettings(
                speed_table,
                checked_error(speed_error),
                keeps_input_while_moving,
                delay_unit_s,
                grip_bit,
            ),
        )

    # The wire's side.

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that have arrived by now; without power nobody hears them."""
        self._advance(now_s)
        if self.powered:
            self._box.receive(data, self.now_s)

    def transmit(self, now_s: float) -> bytes:
        """Advance the arm to now and return what the box has said since the last call."""
        self._advance(now_s)
        said = bytes(self._box.said)
        self._box.said.clear()
        return said

    def next_s(self) -> float:
        """Tell when a motion ends or something on the agenda is due; infinity while it waits."""
        if self._box.said:
            return self.now_s
        return min(self._drive.done_s, self._agenda.next_s)

    @property
    def byte_gap_s(self) -> float:
        """The pause after each byte that it sends, as @DELAY has set it."""
        return self._box.byte_gap_s

    def count_from(self, registers: Sequence[int]) -> None:
        """Have the registers stand as a saved controller's did; nothing turns."""
        self._drive.set_counts(registers, self.now_s)

    # What can be seen.

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered."""
        return self._box.busy

    @property
    def moving(self) -> bool:
        """Whether motors turn."""
        return self._drive.moving

    @property
    def registers(self) -> Motors:
        """The position registers, which know only what was commanded."""
        return self._box.registers

    @property
    def last_key(self) -> Key:
        """The pendant's key pressed last."""
        return self._box.last_key

    @property
    def inputs(self) -> int:
        """The input byte, the grip switch in it."""
        return self._box.inputs

    @property
    def inputs_set(self) -> int:
        """The input byte as it was set from outside, without the grip switch."""
        return self._box.inputs_set

    @property
    def outputs(self) -> int:
        """The output byte that a STEP wrote last."""
        return self._box.outputs

    @property
    def lost_bytes(self) -> int:
        """How many bytes came in while it was deaf, since power-up."""
        return self._box.lost_bytes

    @property
    def memory(self) -> Mapping[int, ProgramRow]:
        """The program's rows by number."""
        return self._box.memory

    @property
    def speed_error(self) -> float:
        """By which share motions last longer than the speed table says."""
        return self._box.settings.speed_error

    @property
    def joints(self) -> Joints:
        """The physical joint angles."""
        return self.world.joints

    @property
    def pose(self) -> Pose:
        """The physical pose."""
        return self.world.pose

    @property
    def opening_mm(self) -> float:
        """The physical width between the fingers."""
        return self.world.opening_mm

    @property
    def grip_force_n(self) -> float:
        """The physical grip force."""
        return self.world.grip_force_n

    # What a person can do.

    def at(self, time_s: float, action: Action) -> None:
        """Have something done at a time of the device's clock, whatever it is doing then."""
        self._agenda.add(time_s, action)

    def press(self, key: Key) -> None:
        """Press a key of the pendant: STOP ends a motion, a program and the pendant's control."""
        if self.powered:
            self._box.last_key = key
            if key is Key.STOP:
                self._box.stop_key(self.now_s)

    def pendant_move(self, steps: Sequence[int]) -> None:
        """Move by the pendant, at once; the registers count it. Raises `BadRequest` in motion."""
        if self.moving or not self.powered:
            raise BadRequest("the pendant moves the arm only when it is switched on and still")
        self._drive.turn(steps, self.now_s)

    def pendant_to(self, joints: Joints, opening_mm: float) -> None:
        """Move by the pendant to a physical posture, as an operator does who looks at the arm."""
        goal = self.world.body.transmission.to_motors(joints, opening_mm)
        self.pendant_move(goal - self.world.motors)

    def pendant_returns(self) -> bool:
        """Give control back to the host, answering its @SET; False where it has control."""
        return self._box.give_back(self.now_s)

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force: the registers know nothing of it."""
        self.world.drive(steps, self.now_s)

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit; the grip switch's own bit follows the fingers alone."""
        grip = self._box.settings.grip_bit
        if not 0 <= bit < _INPUT_BITS or bit == grip:
            raise BadRequest(f"input bits are 0 to 7 without {grip}, the grip switch; not {bit}")
        kept = self._box.inputs_set & ~(1 << bit)
        self._box.inputs_set = kept | on << bit

    def set_speed_error(self, error: float) -> None:
        """Make motions that begin from now on last longer (0.2: a fifth) or shorter (negative)."""
        self._box.settings = replace(self._box.settings, speed_error=checked_error(error))

    def restore(
        self,
        counts: Sequence[int],
        key: Key,
        inputs: int,
        outputs: int,
        rows: Sequence[ProgramRow],
    ) -> None:
        """Have the box know what another one knew."""
        self.count_from(counts)
        self._box.last_key, self._box.inputs_set, self._box.outputs = key, inputs, outputs
        self._box.memory.update((row.number, row) for row in rows)

    def power_off(self) -> None:
        """Switch off: motion stops dead, the arm sags, and whatever the box knew is lost."""
        inputs = self._box.inputs_set
        self._drive.set_counts(STILL, self.now_s)
        self.world.cut_current(self.now_s)
        self.powered = False
        self._box = ControllerBox(self._drive, self._box.settings)
        self._box.inputs_set = inputs  # switches on the arm's table keep their places

    def power_on(self) -> None:
        """Switch on: registers at zero, and no motor current until the first motion."""
        self.powered = True

    def _advance(self, now_s: float) -> None:
        """Live through everything up to now, each thing at its own time."""
        while (due_s := min(self._drive.done_s, self._agenda.next_s)) <= now_s:
            self.now_s = max(self.now_s, due_s)
            self._drive.follow(self.now_s)
            if self._drive.done_s <= due_s:
                self._drive.stop(self.now_s)
                self._box.motion_ended(self.now_s)
            else:
                self._agenda.pop()()
        self.now_s = max(self.now_s, now_s)
        if self._drive.moving:
            self._drive.follow(self.now_s)
