"""The simulated device shared by all dialects: its board, optional abilities, settings and report.

A `WireDevice` (wire.py) consumes and produces bytes on a clock that its caller sets. A `SimDevice`
adds the physical arm and the person at the arm. It holds a `Board`, the dialect's controller: to
add a dialect, write a subclass of `Board`. Only some boards have a pendant, limit switches and so
on. Each such ability is a protocol; the rows of the tables of faults and of console commands name
the one that they need.
"""

from __future__ import annotations

import abc
import contextlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import Field, dataclass, fields
from functools import partial
from typing import Any, ClassVar, Protocol, TypeAlias, TypeVar, runtime_checkable

from armdrive.errors import ArmFileError, BadRequest
from armdrive.sim.mechanics.motors import MotorDrive, SwitchState
from armdrive.sim.wire import DeviceLine, TimeQueue, WireDevice
from armdrive.sim.world import World
from armdrive.sim.world.saved import Json, require_counts, unfit, world_to_json
from armdrive.status import pose_view
from armdrive.text.toml import plain, rule_of, section_of, setting
from firmware_protocol.fields import INT16_MAX, INT16_MIN
from kinematics.errors import did_you_mean
from kinematics.spaces import Joints, Motors
from kinematics.text import mm_text


@runtime_checkable
class HasPendant(Protocol):
    """A board with a teach pendant, to which the host can hand over control."""

    def press_named(self, name: str) -> None:
        """Press a key by its name. Raises `BadRequest` if the pendant has no such key."""

    def return_control(self) -> bool:
        """Return control to the host. Returns False if the host already has it."""


@runtime_checkable
class Resettable(Protocol):
    """A board that can be reset with the power on: by a button, a watchdog or DTR."""

    def reset(self) -> None:
        """Restart the firmware. Whether position and motor current survive depends on the board."""


@runtime_checkable
class HasSwitches(Protocol):
    """A board with one limit switch per axis."""

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Make the switch of an axis (counted from 0) stick, or free it."""


@runtime_checkable
class SaysEmergencies(Protocol):
    """A board whose drives, counted from 0 like the motors, send error codes on their own."""

    def put_in_fault(self, drive: int, code: int) -> None:
        """Give a drive a fault. The drive fails until the fault is fixed and then reset."""

    def fix(self, drive: int, code: int) -> None:
        """Remove the cause of a drive's fault. The fault itself still has to be reset."""

    def warn(self, drive: int, code: int) -> None:
        """Make a drive send an error code and carry on."""


# --- The board: what a dialect writes -----------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SavedDevice:
    """What is saved of every device. `world` is read by `world_from_json`."""

    world: object
    powered: bool
    registers: tuple[int, ...]
    inputs: int


@dataclass(frozen=True, slots=True)
class SavedBoard:
    """What is saved of one kind of board in addition: here nothing."""


class Board(abc.ABC):
    """A dialect's controller: how its electronics and firmware react to bytes and time.

    A board controls the arm (`world`) through its motors (`drive`). `baud` sets the speed of the
    serial line; None means that bytes arrive at once, as on a network.
    """

    title: ClassVar[str]
    """The name shown to people, for example `TeachMover`."""
    input_bits: int = 8
    register_range: ClassVar[tuple[int, int]] = (INT16_MIN, INT16_MAX)
    """The smallest and largest value of a position register."""
    saved_as: ClassVar[type[Any]] = SavedBoard
    """The dataclass of the board's own saved state."""
    message: ClassVar[type[Any]] = bytes
    """What arrives or leaves at once: bytes, or on a bus a tuple of frames."""

    def __init__(self, world: World, drive: MotorDrive[Any], baud: int | None) -> None:
        self.world = world
        self.drive = drive
        self.baud = baud
        self.now_s = 0.0
        """The current time. The device sets it, the power and the inputs."""
        self.powered = True
        self.inputs_set = 0
        self.outgoing: Any = bytearray()
        """What waits to be sent: bytes, or on a bus frames. Boards only append to it."""
        self.line: Callable[[WireDevice], DeviceLine] = partial(DeviceLine, baud=baud)
        """Makes the line to the device: by default a serial line at the board's baud rate."""

    # Observable state.

    @property
    @abc.abstractmethod
    def busy(self) -> bool:
        """Whether the board is carrying out a request of the host."""

    @property
    @abc.abstractmethod
    def registers(self) -> Motors:
        """The positions reported to the host. They count commanded motion only."""

    @property
    def inputs(self) -> int:
        """The input bits as the host reads them."""
        return self.inputs_set

    def details(self) -> dict[str, Json]:
        """Return extra state that only this kind of board reports."""
        return {}

    # Bytes and time.

    @abc.abstractmethod
    def receive(self, message: Any) -> None:
        """Receive bytes (or frames) that arrive now. Called only while the power is on."""

    def due_s(self) -> float:
        """Return when the board next acts on its own; by default when the motion ends."""
        return self.drive.done_s

    def happen(self) -> None:
        """Do what is due now. Afterwards `due_s` must be later, or this is called again."""
        self.drive.settle(self.now_s)
        self.motion_ended()

    def motion_ended(self) -> None:  # noqa: B027 - a host may have to ask
        """React to the end of a motion."""

    # Power.

    def boot(self) -> None:  # noqa: B027 - most boards have nothing to say
        """Start the firmware after power-on, for example with a banner."""

    @abc.abstractmethod
    def forget(self) -> None:
        """Clear volatile state. Registers, motion and current have already been cleared."""

    # Actions of a person.

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit, which survives a loss of power."""
        if not 0 <= bit < self.input_bits:
            raise BadRequest(f"inputs are numbered 1 to {self.input_bits}, not {bit + 1}")
        self.inputs_set = self.inputs_set & ~(1 << bit) | on << bit

    def moved_by_hand(self, *, counted: bool) -> None:  # noqa: B027 - most boards see nothing of it
        """React to motors turned by a person: at the controls (counted) or by force."""

    # The saved world.

    def count_from(self, registers: Sequence[int]) -> None:
        """Set the registers to those of a saved controller. Nothing moves."""
        self.drive.set_counts(registers, self.now_s)

    def known(self) -> Any:
        """Return the board's own state as `saved_as`: by default its attributes of these names."""
        return self.saved_as(*(getattr(self, each.name) for each in fields(self.saved_as)))

    def recall_known(self, saved: Any) -> None:
        """Restore what `known` returned. Raises `StateFileError`."""
        for each in fields(saved):
            setattr(self, each.name, getattr(saved, each.name))


# --- The device, which is the same for every board ----------------------------------------------
# Times are in seconds on the caller's clock. A person acts at the device's current time, or at a
# given time through `at`. If a thread drives the device, call these methods on that thread or under
# its lock.


Action = Callable[[], object]


class SimDevice:
    """A simulated device on a physical arm: its board, and the person at the arm.

    It keeps the clock, the agenda and the power state, passes bytes between wire and board, and
    saves all of it. Abilities of particular boards are reached through `board`.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self.world = board.world
        self._agenda: TimeQueue[Action] = TimeQueue()

    # The wire's side.

    def line(self) -> DeviceLine:
        """Make a line to the device."""
        return self.board.line(self)

    def receive(self, message: Any, now_s: float) -> None:
        """Receive a message that has arrived by now. Without power it is lost."""
        self._advance(now_s)
        if self.powered:
            self.board.receive(message)

    def transmit(self, now_s: float) -> Any:
        """Advance the arm to now and return what the board has sent since the last call."""
        self._advance(now_s)
        sent = self.board.message(self.board.outgoing)
        self.board.outgoing.clear()
        return sent

    def next_s(self) -> float:
        """Return when a motion ends or an agenda item is due; infinity if nothing is pending."""
        board = self.board
        if board.outgoing:
            return board.now_s
        own_s = self.board.due_s() if board.powered else math.inf
        return min(own_s, self._agenda.next_s)

    # Observable state.

    @property
    def now_s(self) -> float:
        """The device's current time."""
        return self.board.now_s

    @property
    def powered(self) -> bool:
        """Whether the device is switched on."""
        return self.board.powered

    @property
    def busy(self) -> bool:
        """Whether the device is carrying out a request of the host."""
        return self.board.busy

    @property
    def registers(self) -> Motors:
        """The positions reported to the host. They count commanded motion only."""
        return self.board.registers

    @property
    def moving(self) -> bool:
        """Whether any motor is turning."""
        return self.board.drive.moving

    @property
    def inputs(self) -> int:
        """The input bits as the host reads them."""
        return self.board.inputs

    # Actions of a person.

    def at(self, time_s: float, action: Action) -> None:
        """Schedule an action at a time of the device's clock."""
        self._agenda.put(time_s, action)

    def jog(self, steps: Sequence[int]) -> None:
        """Move motors from the device's own controls, which count the steps.

        `BadRequest` in motion.
        """
        if self.moving or not self.powered:
            raise BadRequest("a person moves the arm only when it is switched on and still")
        self.board.drive.turn(steps, self.now_s)
        self.board.moved_by_hand(counted=True)

    def bring_to(self, joints: Joints, opening_mm: float) -> None:
        """Jog to a physical posture, as an operator does by eye."""
        goal = self.world.body.transmission.to_motors(joints, opening_mm)
        self.jog(self.world.play.turns_for(goal - self.world.motors))

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force. The registers do not notice."""
        self.world.force(steps, self.now_s)
        self.board.moved_by_hand(counted=False)

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit. Raises `BadRequest` if the board has no such input."""
        self.board.set_input(bit, on)

    def power_off(self) -> None:
        """Switch off: motion stops dead, the arm sags, and the board loses its state."""
        self.board.drive.lose_power(self.now_s)
        self.board.powered = False
        self.board.outgoing.clear()
        self.board.forget()

    def power_on(self) -> None:
        """Switch on, with the registers at zero, as after a cold start."""
        self.board.powered = True
        self.board.boot()

    def set_power(self, on: bool) -> None:
        """Switch on or off; no effect if the device is already in that state."""
        if on != self.powered:
            (self.power_on if on else self.power_off)()

    # The saved world.

    def to_json(self) -> dict[str, Json]:
        """Return everything needed to recreate the device at rest.

        A motion in progress is not saved: the arm stands where it was at that moment.
        """
        saved = SavedDevice(
            world_to_json(self.world), self.powered, tuple(self.registers), self.board.inputs_set
        )
        return {**plain(saved), **plain(self.board.known())}

    def recall(self, saved: SavedDevice, known: Any) -> None:
        """Restore what was saved, except for the world. Raises `StateFileError`."""
        board = self.board
        require_counts("registers", saved.registers, len(self.world.motors), *board.register_range)
        if not 0 <= saved.inputs < 1 << board.input_bits:
            raise unfit(f"the saved board has {board.input_bits} inputs, not {saved.inputs:b}")
        board.count_from(saved.registers)
        board.inputs_set, board.powered = saved.inputs, saved.powered
        board.recall_known(known)
        # Boards are built as just after power-on, and some have their motors on then.
        self.world.energised &= saved.powered

    # Time.

    def _advance(self, now_s: float) -> None:
        """Process everything due up to now, each event at its own time."""
        board = self.board
        while True:
            own_s = board.due_s() if board.powered else math.inf
            due_s = min(own_s, self._agenda.next_s)
            if due_s > now_s:
                break
            board.now_s = max(board.now_s, due_s)
            # First the arm: what happens now, a power cut say, must find it where it is by now.
            board.drive.follow(board.now_s)
            if own_s <= due_s:
                board.happen()
            else:
                self._agenda.pop()()
        if board.now_s < now_s:
            board.now_s = now_s
            board.drive.follow(now_s)


# --- Settings that a person or a test may choose by name -----------------------------------------
# They are a frozen dataclass: `setting` declares each field that can be chosen. Values are numbers,
# texts, true or false. On the command line they are written NAME=VALUE.

Value: TypeAlias = bool | int | float | str
K = TypeVar("K")
_FLAGS = {"yes": True, "true": True, "on": True, "1": True}
_FLAGS |= {"no": False, "false": False, "off": False, "0": False}


@dataclass(frozen=True, slots=True)
class NoSettings:
    """The settings of a device that has none."""


def settings_of(kind: type[Any]) -> dict[str, Field[Any]]:
    """Return the fields of a dataclass that can be chosen, by name: those that are explained."""
    return {each.name: each for each in fields(kind) if rule_of(each).help}


def chosen(kind: type[K], values: Mapping[str, Value]) -> K:
    """Return settings with these values; all others have their defaults. Raises `BadRequest`."""
    for name in values:
        _row(kind, name)
    try:
        return section_of(kind, values, whole=False)
    except ArmFileError as error:
        raise BadRequest(str(error)) from None


def parse_settings(kind: type[Any], words: Iterable[str]) -> dict[str, Value]:
    """Parse NAME=VALUE words for `chosen`. Raises `BadRequest` with the nearest known name."""
    values: dict[str, Value] = {}
    for word in words:
        name, equals, text = word.partition("=")
        if not equals:
            raise BadRequest(f"write a setting as NAME=VALUE, not {word!r}")
        row = _row(kind, name.strip().replace("-", "_"))
        values[row.name] = _parsed(row, text.strip())
    return values


def speed_error(means: str) -> Any:
    """Declare how much longer motions last than the board assumes: 0.2 is a fifth longer."""
    return setting(0.0, means, low=-0.95, high=100.0)


def _row(kind: type[Any], name: str) -> Field[Any]:
    rows = settings_of(kind)
    if name in rows:
        return rows[name]
    known = f"known are {', '.join(rows)}" if rows else "this device has none"
    hint = did_you_mean(name, rows, known)
    raise BadRequest(f"the simulated device has no setting {name!r}; {hint}")


def _parsed(row: Field[Any], text: str) -> Value:
    """Return what a person has typed as the type of the default, or as it is for `chosen`."""
    if isinstance(row.default, bool):
        if text.lower() not in _FLAGS:
            raise BadRequest(f"{row.name} must be yes or no, not {text!r}")
        return _FLAGS[text.lower()]
    kind: type[Any] = type(row.default)
    value: Value = text
    with contextlib.suppress(ValueError):
        value = kind(text)
    return value


# --- The report: the whole state, physical and commanded, for people and programs ----------------

_DIGITS = 3


def state_json(device: SimDevice) -> dict[str, Json]:
    """Return the state as plain data; lengths in mm, angles in degrees, forces in N."""
    world, scene = device.world, device.world.scene
    return {
        "powered": device.powered,
        "energised": world.energised,
        "moving": device.moving,
        "busy": device.busy,
        "registers": list(device.registers),
        "motors": list(world.motors),
        "joints_deg": {name: round(angle, _DIGITS) for name, angle in world.joints.deg.items()},
        "pose": plain(pose_view(world.pose)),
        "opening_mm": round(world.opening_mm, _DIGITS),
        "grip_force_n": round(world.grip_force_n, _DIGITS),
        "inputs": device.inputs,
        **device.board.details(),
        "stalled": [motor + 1 for motor in sorted(world.stalled)],
        "held": scene.held,
        "blocks": plain([*scene.blocks.values()]),
        "incidents": plain(world.incidents),
    }


def state_line(device: SimDevice) -> str:
    """Return the state as one line of text."""
    world = device.world
    words = [
        f"power {'on' if device.powered else 'off'}",
        f"current {'on' if world.energised else 'off'}",
        "moving" if device.moving else "still",
        str(world.pose),
        f"fingers {mm_text(world.opening_mm)} apart",
        f"grip {world.grip_force_n:.1f} N",
        f"registers {','.join(map(str, device.registers))}",
    ]
    held, blocks = world.scene.held, world.scene.blocks
    words += [f"holds {held}"] if held else []
    words += [f"blocks {', '.join(blocks)}"] if blocks else []
    words += [f"incidents {len(world.incidents)}"] if world.incidents else []
    return "; ".join(words)
