"""The hardware of a simulated GRBL board: wiring, outputs and fingers, switches, motors, current.

Counts of the board are in the order of its axes, those of the arm in the order of its motors. A
board may have more axes than the arm has motors; the surplus axes turn nothing.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from armdrive.sim.grbl.firmware import BoardSettings, Firmware
from armdrive.sim.mechanics.motors import LimitSwitch, MotorDrive
from armdrive.sim.mechanics.planner import PathLimits, PathRack
from armdrive.sim.world import World
from firmware_protocol.grbl import Modal
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class OutputWiring:
    """The output that moves the fingers, by its name in `BoardOutputs`; empty if none does.

    At the value `closed` the fingers are shut, at `opened` wide open, and proportional in between.
    `signals`: without a value, the fingers stay where they are, as those of a servo.
    """

    name: str = ""
    closed: float = 0.0
    opened: float = 1.0
    signals: bool = False

    def share(self, outputs: BoardOutputs) -> float | None:
        """Return how far the output opens the fingers, from 0 to 1; None if it does nothing."""
        value = outputs.on.get(self.name, None if self.signals or not self.name else 0.0)
        if value is None:
            return None
        return min(max((value - self.closed) / (self.opened - self.closed), 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class BoardBuild:
    """One board on one arm.

    `order` gives the axis of each motor by its place in `axes`; `fingers` is the output that moves
    the fingers, over `opening_mm` at `finger_mm_s`.
    """

    firmware: Firmware
    axes: str
    order: Sequence[int]
    fingers: OutputWiring
    opening_mm: tuple[float, float]
    finger_mm_s: float


# --- The receive ring: when it is full, bytes are lost without a word ----------------------------

_LINE_END = re.compile(rb"[\r\n]")
_LONGEST = 4096


class ReceiveRing:
    """Bytes that the main loop has not read, and the line that it has started to read.

    `lost` counts the bytes that did not fit.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.lost = 0
        self._bytes = bytearray()
        self._begun = bytearray()

    def __len__(self) -> int:
        return len(self._bytes)

    @property
    def free(self) -> int:
        """How many more bytes fit."""
        return self.size - len(self._bytes)

    def put(self, data: bytes) -> None:
        """Store as many bytes as fit."""
        kept = data[: self.free]
        self.lost += len(data) - len(kept)
        self._bytes += kept

    def take_line(self) -> bytes:
        """Read up to the end of a line and return the line; nothing if its end has not arrived."""
        end = _LINE_END.search(self._bytes)
        count = len(self._bytes) if end is None else end.end()
        self._begun += self._bytes[:count]
        del self._bytes[:count]
        if end is None:
            del self._begun[_LONGEST:]  # no line is this long, and its end is still to come
            return b""
        line = bytes(self._begun)
        self._begun.clear()
        return line

    def clear(self) -> None:
        """Forget everything."""
        self._bytes.clear()
        self._begun.clear()


# --- Outputs -------------------------------------------------------------------------------------


class BoardOutputs:
    """What is switched on: spindle, flood, mist, and the ports by names such as P0 and E0.

    `on` has the value of each: the spindle's speed, the number at an analog port, otherwise 1.
    """

    def __init__(self) -> None:
        self.on: dict[str, float] = {}

    def spin(self, modal: Modal) -> None:
        """Switch the spindle according to the modes."""
        self.switch("spindle", None if modal.spindle == "M5" else modal.speed)

    def cool(self, word: str) -> None:
        """Switch coolant: M7 and M8 add up, M9 ends both."""
        for name, begins in (("mist", "M7"), ("flood", "M8")):
            if word in (begins, "M9"):
                self.switch(name, 1.0 if word == begins else None)

    def put(self, word: str, values: Mapping[str, float]) -> None:
        """Set a digital or analog port."""
        if word in ("M67", "M68"):
            self.switch(f"E{values['E']:.0f}", values["Q"])
        else:
            self.switch(f"P{values['P']:.0f}", 1.0 if word == "M64" else None)

    def switch(self, name: str, value: float | None) -> None:
        """Switch an output to a value, or off if it is None."""
        self.on.pop(name, None)
        if value is not None:
            self.on[name] = value

    def off(self) -> None:
        """Stop spindle and coolant, as every reset does; ports keep their values."""
        for name in ("spindle", "flood", "mist"):
            self.switch(name, None)

    @property
    def letters(self) -> str:
        """The accessory letters of a status report."""
        shown = (("spindle", "S"), ("flood", "F"), ("mist", "M"))
        return "".join(letter for name, letter in shown if name in self.on)


class OutputFingers:
    """Fingers that an output moves, if no motor does; `due_s` is when they arrive."""

    def __init__(self, world: World, build: BoardBuild, outputs: BoardOutputs) -> None:
        self._world = world
        self._build = build
        self._outputs = outputs
        self.forget()

    def forget(self) -> None:
        """Forget where the fingers were to go."""
        self.due_s = math.inf
        self._opening_mm = 0.0

    def follow_output(self, now_s: float) -> None:
        """Send the fingers to the opening that their output commands."""
        build = self._build
        share = build.fingers.share(self._outputs)
        if share is None:
            return
        low, high = build.opening_mm
        self._opening_mm = low + (high - low) * share
        way_mm = abs(self._opening_mm - self._world.opening_mm)
        self.due_s = now_s + way_mm / build.finger_mm_s

    def arrive(self, now_s: float) -> None:
        """Move the fingers to where they were sent."""
        self.due_s = math.inf
        self._world.move_fingers(self._opening_mm, now_s)


# --- Limit switches ------------------------------------------------------------------------------


class Switches:
    """The limit switches, by the number of their axis; an axis without a motor has none."""

    def __init__(self, by_axis: Mapping[int, LimitSwitch]) -> None:
        self.by_axis = by_axis

    def pressed(self, axis: int) -> bool:
        """Return whether the board sees a switch pressed."""
        one = self.by_axis.get(axis)
        return one is not None and one.pressed

    def mask(self) -> int:
        """Return a bit for each switch seen pressed, the first axis in the lowest bit."""
        return sum(self.pressed(axis) << axis for axis in self.by_axis)

    def steps_to(self, axis: int, way: int) -> int | None:
        """Return how many steps in a direction press the switch; None if none ever do."""
        one = self.by_axis.get(axis)
        return None if one is None else one.steps_to(way)


# --- Motors --------------------------------------------------------------------------------------


class BoardDrive(MotorDrive[PathRack]):
    """A path in the space of the board's axes; the build maps motors to axes."""

    def __init__(self, world: World, build: BoardBuild, limits: PathLimits) -> None:
        axes = len(build.axes)
        super().__init__(world, PathRack((0,) * axes, limits, build.firmware.stepping))
        self._axes = axes
        self._order = tuple(build.order)
        self._blocks = build.firmware.blocks

    @property
    def goal_units(self) -> tuple[float, ...]:
        """Where the axes stand after the last queued line, in units."""
        return self.units_of(self.rack.goal)

    @property
    def registers(self) -> Motors:
        """The counts of the axes that have motors."""
        return self._of_motors(self.counts)

    def set_counts(self, counts: Sequence[int], now_s: float) -> None:
        """Set the counts of the motors. Nothing turns."""
        self.set_axes(self._of_axes(counts), now_s)

    def set_axes(self, counts: Sequence[int], now_s: float) -> None:
        """Set the counts of the axes. Nothing turns."""
        super().set_counts(counts, now_s)

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn motors from the controls: counted, with the current on, and at once."""
        super().turn(self._of_axes(steps), now_s)

    def steps_of(self, target: Sequence[float]) -> Motors:
        """Convert a target from units to steps, rounded once because it is absolute."""
        per_unit = self.rack.limits.steps_per_unit
        return Motors(
            math.floor(abs(unit * per) + 0.5) * (1 if unit >= 0 else -1)
            for unit, per in zip(target, per_unit, strict=True)
        )

    def units_of(self, counts: Sequence[int]) -> tuple[float, ...]:
        """Convert steps to units."""
        per_unit = self.rack.limits.steps_per_unit
        return tuple(count / per for count, per in zip(counts, per_unit, strict=True))

    def queue_to(self, target: Sequence[float], rate: float, now_s: float) -> bool:
        """Queue a line to a target in units; return False if it has no length."""
        self.follow(now_s)
        deltas = self.steps_of(target) - self.rack.goal
        return self.rack.queue(deltas, rate, now_s)

    def live(self, now_s: float) -> bool:
        """Do what is due; return True if the motors have come to a stand."""
        if self.rack.next_line_s <= now_s:
            self.settle(now_s)
            return not self.moving
        return False

    def brake(self, now_s: float, keep: int | None = None) -> None:
        """Brake along the path to a standstill, after all segments already computed or `keep`."""
        self.follow(now_s)
        self.rack.hold(now_s, keep=keep)

    def queued(self, now_s: float) -> int:
        """Return how many lines wait; a line whose last segment is computed no longer does."""
        return self.rack.waiting - self.rack.ending_by(self.rack.computed_s(now_s))

    def full(self, now_s: float) -> bool:
        """Return whether the planner has no room for another line."""
        return self.rack.waiting >= self._blocks and self.queued(now_s) >= self._blocks

    def speed(self, now_s: float) -> float:
        """Return the speed of the segment computed last, in units per second."""
        return self.rack.speed(self.rack.computed_s(now_s))

    def kill(self, now_s: float) -> None:
        """Stop dead and drop all lines; the arm overruns by the ramp that is cut off: a guess."""
        self.follow(now_s)
        here = there = Motors(self.rack.positions(now_s))
        if self.moving:
            self.rack.hold(now_s, keep=0)
            if self.moving:
                there = Motors(self.rack.positions(self.done_s))
        self.stop(now_s)
        self.world.force(self._of_motors(there - here), now_s)

    def _of_motors(self, counts: Sequence[int]) -> Motors:
        return Motors([counts[axis] for axis in self._order])

    def _of_axes(self, counts: Sequence[int]) -> Motors:
        turned = dict(zip(self._order, counts, strict=True))
        return Motors([turned.get(axis, 0) for axis in range(self._axes)])

    def _turn(self, steps: Motors, now_s: float) -> None:
        super()._turn(self._of_motors(steps), now_s)


class MotorCurrent:
    """The motors' current, which the board switches off some time after a motion.

    `off_s` is when the current goes off.
    """

    def __init__(self, world: World, settings: BoardSettings) -> None:
        self.off_s = math.inf
        self._world = world
        self._settings = settings
        world.energised = settings.motors_stay_on

    def keep_on(self) -> None:
        """Switch the current on until further notice."""
        self._world.energised = True
        self.off_s = math.inf

    def release(self, now_s: float) -> None:
        """Switch the current off after the idle delay, even if $1 says to leave it on."""
        self.off_s = now_s + self._settings.idle_s

    def release_at_rest(self, now_s: float) -> None:
        """Switch the current off after the idle delay, unless $1 says to leave it on."""
        if not self._settings.motors_stay_on:
            self.release(now_s)

    def cut(self, now_s: float) -> None:
        """Switch the current off at once: the arm sags."""
        self.off_s = math.inf
        self._world.cut_current(now_s)
