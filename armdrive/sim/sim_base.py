"""What every simulated controller does alike, so that a dialect's device is its box alone.

The clock, the agenda, power, inputs, the person beside the arm, and the saved world. All times
are seconds on the clock that is handed in. What a person does happens at the device's present
time, or through `at` at a stated one; where a thread drives the device, it belongs on that thread,
or under its lock.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from typing import Any, ClassVar

from armdrive.errors import BadRequest
from armdrive.sim.agenda import Action, Agenda
from armdrive.sim.drive import Drive
from armdrive.sim.saved import Json, Saved
from armdrive.sim.world import World
from armdrive.sim.world_file import world_to_json
from kinematics.spaces import Joints, Motors, Pose


class SimBase(abc.ABC):
    """A simulated controller on a physical arm; a dialect fills in the methods below `The box`.

    `said` is what waits to be sent: the box appends to it, and never replaces it.
    """

    title: ClassVar[str]
    input_bits: ClassVar[int] = 8

    def __init__(self, world: World, drive: Drive[Any], baud: int | None) -> None:
        self.world = world
        self.baud = baud
        self.powered = True
        self.now_s = 0.0
        self.inputs_set = 0
        self.said = bytearray()
        self._drive = drive
        self._agenda = Agenda()

    # The box: what a dialect's device says of itself.

    @property
    @abc.abstractmethod
    def busy(self) -> bool:
        """Whether it is at work on something that the host has asked for."""

    @property
    @abc.abstractmethod
    def registers(self) -> Motors:
        """The positions that it would tell its host."""

    @abc.abstractmethod
    def _hear(self, data: bytes) -> None:
        """Take bytes that have arrived, at `now_s`; called only with power."""

    @abc.abstractmethod
    def _motion_ended(self) -> None:
        """Act on the end of a motion, at `now_s`."""

    @abc.abstractmethod
    def _forget(self) -> None:
        """Lose what is lost with the power; registers, motion and current are gone already."""

    @abc.abstractmethod
    def _known(self) -> dict[str, Json]:
        """Return what the controller knows, to be saved beside the world."""

    @abc.abstractmethod
    def _recall_known(self, saved: Saved) -> None:
        """Take all that `_known` wrote out of `saved`. Raises `StateFileError`."""

    def _boot(self) -> None:  # noqa: B027 - most boards have nothing to say
        """Do what the firmware does when power comes, a banner say."""

    def _due_s(self) -> float:
        """Tell when the device next acts by itself: by default when the motion ends."""
        return self._drive.done_s

    def _happen(self) -> None:
        """Do what is due at `now_s`; afterwards `_due_s` must be later, or this comes again."""
        self._drive.settle(self.now_s)
        self._motion_ended()

    def details(self) -> dict[str, Json]:
        """Return what only this kind of device has to show."""
        return {}

    # The wire's side.

    @property
    def byte_gap_s(self) -> float:
        """The pause after each byte that it sends."""
        return 0.0

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that have arrived by now; without power nobody hears them."""
        self._advance(now_s)
        if self.powered:
            self._hear(data)

    def transmit(self, now_s: float) -> bytes:
        """Advance the arm to now and return what the box has said since the last call."""
        self._advance(now_s)
        said = bytes(self.said)
        self.said.clear()
        return said

    def next_s(self) -> float:
        """Tell when a motion ends or something on the agenda is due; infinity while it waits."""
        return self.now_s if self.said else self._next_event_s()

    # What can be seen.

    @property
    def moving(self) -> bool:
        """Whether motors turn."""
        return self._drive.moving

    @property
    def inputs(self) -> int:
        """The input bits as the host would read them."""
        return self.inputs_set

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
        """Have something done when the device's clock shows this time."""
        self._agenda.add(time_s, action)

    def count_from(self, registers: Sequence[int]) -> None:
        """Have the registers stand as a saved controller's did; nothing turns."""
        self._drive.set_counts(registers, self.now_s)

    def jog(self, steps: Sequence[int]) -> None:
        """Move by hand of a person at the controls, at once; counted. `BadRequest` in motion."""
        if self.moving or not self.powered:
            raise BadRequest("a person moves the arm only when it is switched on and still")
        self._drive.turn(steps, self.now_s)

    def bring_to(self, joints: Joints, opening_mm: float) -> None:
        """Jog to a physical posture, as an operator does who looks at the arm."""
        goal = self.world.body.transmission.to_motors(joints, opening_mm)
        self.jog(self.world.play.turns_for(goal - self.world.motors))

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force: the registers know nothing of it."""
        self.world.force(steps, self.now_s)

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit, which keeps its place through a loss of power."""
        if not 0 <= bit < self.input_bits:
            raise BadRequest(f"input bits are 0 to {self.input_bits - 1}, not {bit}")
        self.inputs_set = self.inputs_set & ~(1 << bit) | on << bit

    def power_off(self) -> None:
        """Switch off: motion stops dead, the arm sags, and whatever the box knew is lost."""
        self._drive.set_counts((0,) * len(self.world.motors), self.now_s)
        self.world.cut_current(self.now_s)
        self.powered = False
        self.said.clear()
        self._forget()

    def power_on(self) -> None:
        """Switch on: registers at zero, as one finds the controller in the morning."""
        self.powered = True
        self._boot()

    # The saved world.

    def to_json(self) -> dict[str, Json]:
        """Return everything that a standing device needs to be made again.

        A motion under way is not saved: the arm stands where the motion had brought it.
        """
        return {
            "world": world_to_json(self.world),
            "powered": self.powered,
            "registers": list(self.registers),
            "inputs": self.inputs_set,
            **self._known(),
        }

    def recall(self, saved: Saved) -> None:
        """Know again what `to_json` wrote, apart from the world. Raises `StateFileError`."""
        low, high = self._register_range()
        self.count_from(saved.wholes("registers", len(self.world.motors), low, high))
        self.inputs_set = saved.whole("inputs", 0, (1 << self.input_bits) - 1)
        self.powered = saved.flag("powered")
        self._recall_known(saved)

    def _register_range(self) -> tuple[int, int]:
        """Return the least and the greatest number that a register can hold: 16 bits."""
        return -(1 << 15), (1 << 15) - 1

    # Time.

    def _next_event_s(self) -> float:
        own_s = self._due_s() if self.powered else math.inf
        return min(own_s, self._agenda.next_s)

    def _advance(self, now_s: float) -> None:
        """Live through everything up to now, each thing at its own time."""
        while (due_s := self._next_event_s()) <= now_s:
            self.now_s = max(self.now_s, due_s)
            self._drive.follow(self.now_s)
            if self.powered and self._due_s() <= due_s:
                self._happen()
            else:
                self._agenda.pop()()
        self.now_s = max(self.now_s, now_s)
        self._drive.follow(self.now_s)
