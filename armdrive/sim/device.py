"""The simulated device that every dialect shares, its board, their abilities, options and report.

A `WireDevice` (wire.py) takes and returns bytes on a clock that is handed to it. A `SimDevice` is
that, with the physical arm and the person at the arm. It holds a `Board`, the dialect's controller:
to add a dialect, write a subclass of `Board`. Only some boards have a pendant, limit switches and
so on: each such ability is a protocol, asked of the board by `isinstance`. `lacks` is the refusal
of boards that do not have it.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import Any, ClassVar, Protocol, TypeAlias, runtime_checkable

from armdrive.errors import BadRequest
from armdrive.sim.mechanics.motors import MotorDrive, MotorSpeed
from armdrive.sim.wire import PacedDevice, TimeQueue, WireDevice
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import (
    Form,
    Json,
    Saved,
    block_to_json,
    incident_to_json,
    read,
    world_to_json,
    write,
)
from kinematics.errors import did_you_mean
from kinematics.spaces import Joints, Motors


class TeachPendant(Protocol):
    """A teach pendant, to which the host can hand control over."""

    def press_named(self, name: str) -> None:
        """Press a key by its name. Raises `BadRequest` for a key that the pendant lacks."""

    def return_control(self) -> bool:
        """Give control back to the host; return False where the host has it already."""


@runtime_checkable
class HasPendant(Protocol):
    """A board with a teach pendant."""

    @property
    def pendant(self) -> TeachPendant:
        """The pendant."""


@runtime_checkable
class HasSpeedError(Protocol):
    """A board whose motors can be set to turn faster or slower than it believes."""

    motor_speed: MotorSpeed


@runtime_checkable
class Resettable(Protocol):
    """A board with a reset that leaves the power on: a button, a watchdog, DTR."""

    def reset(self) -> None:
        """Restart the firmware; what that does to position and current depends on the board."""


class SwitchState(Enum):
    """What a limit switch does."""

    FREE = "free"
    """It follows the arm, as it should."""
    OPEN = "open"
    """It is stuck, and never seen pressed."""
    CLOSED = "closed"
    """It is stuck, and always seen pressed."""


@runtime_checkable
class HasSwitches(Protocol):
    """A board with a limit switch on each of its axes."""

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Have the switch of an axis (counted from 0) stick, or free it."""


class DriveControls(Protocol):
    """What can be done to single drives on a bus, counted from 0 as the motors."""

    @property
    def bits_s(self) -> int:
        """The speed of their bus."""

    def mute(self, drive: int, on: bool) -> None:
        """Have a drive send nothing, although it receives and obeys; or send again."""

    def plug(self, drive: int, on: bool) -> None:
        """Plug a drive's CAN cable in, or pull it: then the drive neither receives nor sends."""

    def power(self, drive: int, on: bool) -> None:
        """Take a drive's supply away, and what it holds comes down; or give it back."""

    def reset(self, drive: int) -> None:
        """Have a drive's firmware begin again, in motion or not."""

    def set_id(self, drive: int, node: int) -> int:
        """Give a drive an id, another one's perhaps; return the old. Raises `BadRequest`."""

    def set_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as at its own keys; return the old. Raises `BadRequest`."""

    def withhold_done(self, drive: int, on: bool) -> None:
        """Have a drive not say that a motion is done, or say it again."""


class DrivesOnBus:
    """The interface of a board that sends and receives packed frames."""

    drives: DriveControls
    """What can be done to its drives."""


class DriveErrors(Protocol):
    """What can be wrong with single drives that say error codes by themselves."""

    def ail(self, drive: int, code: int) -> None:
        """Have something be wrong with a drive: it fails, until it is mended and reset."""

    def mend(self, drive: int, code: int) -> None:
        """Have what was wrong with a drive be right again; its fault is to be reset yet."""

    def warn(self, drive: int, code: int) -> None:
        """Have a drive say an error code, and go on."""


@runtime_checkable
class SaysEmergencies(Protocol):
    """A board whose drives say error codes by themselves."""

    def errors(self) -> DriveErrors:
        """Return what can be wrong with its drives."""


def lacks(board: Board, what: str) -> BadRequest:
    """Return the refusal for a board that has no such thing."""
    return BadRequest(f"the simulated {board.title} has no {what}")


# --- The board: what a dialect writes -----------------------------------------------------------


@dataclass(slots=True, eq=False)
class SharedState:
    """What a board and its device both see; the device sets the time, the power and the inputs.

    `outgoing` is what waits to be sent: boards append to it, and never replace it.
    """

    now_s: float = 0.0
    powered: bool = True
    inputs_set: int = 0
    outgoing: bytearray = field(default_factory=bytearray)


class Board(abc.ABC):
    """A dialect's controller: what its electronics and firmware do with bytes and with time.

    A board knows the arm (`world`) and the motors (`drive`), and shares its state with its device.
    `baud` is the pace of its serial line; None where bytes arrive at once, as from a network.
    """

    title: ClassVar[str]
    """What it is, for people: `TeachMover`, say."""
    input_bits: ClassVar[int] = 8
    register_range: ClassVar[tuple[int, int]] = (-(1 << 15), (1 << 15) - 1)
    """The least and the greatest number that a register can hold."""
    remembered: ClassVar[Mapping[str, Form]] = {}
    """What a saved board knows: its attributes, each with its form."""
    byte_gap_s: float = 0.0
    """The pause after each byte that it sends."""

    def __init__(self, world: World, drive: MotorDrive[Any], baud: int | None) -> None:
        self.world = world
        self.drive = drive
        self.baud = baud
        self.shared = SharedState()
        self.line: Callable[[WireDevice], PacedDevice] = partial(PacedDevice, baud=baud)
        """Makes the line to the device that has this board: a serial one at its pace."""

    @property
    def now_s(self) -> float:
        """The present time."""
        return self.shared.now_s

    # What can be seen.

    @property
    @abc.abstractmethod
    def busy(self) -> bool:
        """Whether it is at work on something that the host has asked for."""

    @property
    @abc.abstractmethod
    def registers(self) -> Motors:
        """The positions that it would tell its host: they know only what was commanded."""

    @property
    def inputs(self) -> int:
        """The input bits as the host would read them."""
        return self.shared.inputs_set

    def details(self) -> dict[str, Json]:
        """Return what only this kind of board has to show."""
        return {}

    # The wire and time.

    @abc.abstractmethod
    def hear(self, data: bytes) -> None:
        """Take bytes that have arrived now; called only with power."""

    def due_s(self) -> float:
        """Tell when the board next acts by itself: by default when the motion ends."""
        return self.drive.done_s

    def happen(self) -> None:
        """Do what is due now; afterwards `due_s` must be later, or this comes again."""
        self.drive.settle(self.now_s)
        self.motion_ended()

    def motion_ended(self) -> None:  # noqa: B027 - a host may have to ask
        """Act on the end of a motion, now."""

    # Power.

    def boot(self) -> None:  # noqa: B027 - most boards have nothing to say
        """Do what the firmware does when power comes, a banner say."""

    @abc.abstractmethod
    def forget(self) -> None:
        """Lose what is lost with the power; registers, motion and current are gone already."""

    # What a person does.

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit, which keeps its place through a loss of power."""
        if not 0 <= bit < self.input_bits:
            raise BadRequest(f"input bits are 0 to {self.input_bits - 1}, not {bit}")
        self.shared.inputs_set = self.shared.inputs_set & ~(1 << bit) | on << bit

    def moved_by_hand(self, *, counted: bool) -> None:  # noqa: B027 - most boards see nothing of it
        """Act on a person's having turned motors: at the controls, which counts, or by force."""

    # The saved world.

    def count_from(self, registers: Sequence[int]) -> None:
        """Have the registers stand as a saved controller's did; nothing turns."""
        self.drive.set_counts(registers, self.now_s)

    def known(self) -> dict[str, Json]:
        """Return what the board knows, to be saved together with the world."""
        return write(self, self.remembered)

    def recall_known(self, saved: Saved) -> None:
        """Take all that `known` wrote out of `saved`. Raises `StateFileError`."""
        for name, value in read(saved, self.remembered).items():
            setattr(self, name, value)


# --- The device, which is the same for every board ----------------------------------------------
#
# Times are in seconds on the clock that is handed in. A person acts at the device's present time,
# or through `at` at a stated one. If a thread drives the device, call these methods on that thread
# or under its lock.


Action = Callable[[], None]


class SimDevice:
    """A simulated device on a physical arm: its board, and the person at the arm.

    It keeps the clock, the agenda and the power, takes the bytes to and from the wire, and saves
    all of it. What a board has besides is asked of `board`, by its abilities.
    """

    def __init__(self, board: Board) -> None:
        self.board = board
        self.world = board.world
        self._shared = board.shared
        self._agenda: TimeQueue[Action] = TimeQueue()

    # The wire's side.

    def line(self) -> PacedDevice:
        """Make a line to it."""
        return self.board.line(self)

    @property
    def byte_gap_s(self) -> float:
        """The pause after each byte that it sends."""
        return self.board.byte_gap_s

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that have arrived by now; without power they are lost."""
        self._advance(now_s)
        if self.powered:
            self.board.hear(data)

    def transmit(self, now_s: float) -> bytes:
        """Advance the arm to now and return what the board has sent since the last call."""
        self._advance(now_s)
        if not self._shared.outgoing:
            return b""
        sent = bytes(self._shared.outgoing)
        self._shared.outgoing.clear()
        return sent

    def next_s(self) -> float:
        """Tell when a motion ends or something on the agenda is due; infinity while it waits."""
        return self._shared.now_s if self._shared.outgoing else self._next_event_s()

    # What can be seen.

    @property
    def now_s(self) -> float:
        """The device's present time."""
        return self._shared.now_s

    @property
    def powered(self) -> bool:
        """Whether it is switched on."""
        return self._shared.powered

    @property
    def busy(self) -> bool:
        """Whether it is at work on something that the host has asked for."""
        return self.board.busy

    @property
    def registers(self) -> Motors:
        """The positions that it would tell its host: they know only what was commanded."""
        return self.board.registers

    @property
    def moving(self) -> bool:
        """Whether motors turn."""
        return self.board.drive.moving

    @property
    def inputs(self) -> int:
        """The input bits as the host would read them."""
        return self.board.inputs

    # What a person can do.

    def at(self, time_s: float, action: Action) -> None:
        """Have something done when the device's clock shows this time."""
        self._agenda.put(time_s, action)

    def jog(self, steps: Sequence[int]) -> None:
        """Move by hand of a person at the controls, at once; counted. `BadRequest` in motion."""
        if self.moving or not self.powered:
            raise BadRequest("a person moves the arm only when it is switched on and still")
        self.board.drive.turn(steps, self.now_s)
        self.board.moved_by_hand(counted=True)

    def bring_to(self, joints: Joints, opening_mm: float) -> None:
        """Jog to a physical posture, as an operator does who looks at the arm."""
        goal = self.world.body.transmission.to_motors(joints, opening_mm)
        self.jog(self.world.play.turns_for(goal - self.world.motors))

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force: the registers know nothing of it."""
        self.world.force(steps, self.now_s)
        self.board.moved_by_hand(counted=False)

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit. Raises `BadRequest` for one that the board has not."""
        self.board.set_input(bit, on)

    def power_off(self) -> None:
        """Switch off: motion stops dead, the arm sags, and whatever the board knew is lost."""
        self.board.drive.lose_power(self.now_s)
        self._shared.powered = False
        self._shared.outgoing.clear()
        self.board.forget()

    def power_on(self) -> None:
        """Switch on: registers at zero, as one finds the controller in the morning."""
        self._shared.powered = True
        self.board.boot()

    def set_power(self, on: bool) -> None:
        """Switch on or off, unless it is."""
        if on != self.powered:
            (self.power_on if on else self.power_off)()

    # The saved world.

    def to_json(self) -> dict[str, Json]:
        """Return everything that a standing device needs to be made again.

        A motion under way is not saved: the arm stands where the motion had brought it.
        """
        return {
            "world": world_to_json(self.world),
            "powered": self.powered,
            "registers": list(self.registers),
            "inputs": self._shared.inputs_set,
            **self.board.known(),
        }

    def recall(self, saved: Saved) -> None:
        """Know again what `to_json` wrote, apart from the world. Raises `StateFileError`."""
        board, shared = self.board, self._shared
        board.count_from(saved.wholes("registers", len(self.world.motors), *board.register_range))
        shared.inputs_set = saved.whole("inputs", 0, (1 << board.input_bits) - 1)
        shared.powered = saved.flag("powered")
        board.recall_known(saved)

    # Time.

    def _next_event_s(self) -> float:
        own_s = self.board.due_s() if self._shared.powered else math.inf
        agenda_s = self._agenda.next_s
        return min(agenda_s, own_s)

    def _advance(self, now_s: float) -> None:
        """Live through everything up to now, each thing at its own time."""
        shared, drive = self._shared, self.board.drive
        while (due_s := self._next_event_s()) <= now_s:
            shared.now_s = max(shared.now_s, due_s)
            drive.follow(shared.now_s)
            if self.powered and self.board.due_s() <= due_s:
                self.board.happen()
            else:
                self._agenda.pop()()
        shared.now_s = max(shared.now_s, now_s)
        drive.follow(shared.now_s)


# --- Options that a person or a test may choose by name ------------------------------------------
#
# The values are numbers, texts or true and false. On the command line they are written NAME=VALUE.

Value: TypeAlias = bool | int | float | str
_FLAGS = {"yes": True, "true": True, "on": True, "1": True}
_FLAGS |= {"no": False, "false": False, "off": False, "0": False}


@dataclass(frozen=True, slots=True)
class Option:
    """One setting: its kind is that of its default; `choices` bounds a text."""

    name: str
    default: Value
    summary: str
    choices: tuple[str, ...] = ()

    def parse(self, text: str) -> Value:
        """Read a value as a person types it. Raises `BadRequest`."""
        if isinstance(self.default, bool):
            if text.lower() not in _FLAGS:
                raise BadRequest(f"{self.name} must be yes or no, not {text!r}")
            return _FLAGS[text.lower()]
        if isinstance(self.default, str):
            return self.checked(text)
        whole = isinstance(self.default, int)
        try:
            value = int(text) if whole else float(text)
        except ValueError:
            kind = "a whole number" if whole else "a number"
            raise BadRequest(f"{self.name} must be {kind}, not {text!r}") from None
        return self.checked(value)

    def checked(self, value: Value) -> Value:
        """Return a value of the right kind, or raise `BadRequest`."""
        if isinstance(self.default, float) and type(value) is int:
            value = float(value)
        if type(value) is not type(self.default):
            raise BadRequest(f"{self.name} must be like {self.default!r}, not {value!r}")
        if isinstance(value, float) and not math.isfinite(value):
            raise BadRequest(f"{self.name} must be finite")
        if self.choices and value not in self.choices:
            raise BadRequest(f"{self.name} is one of {', '.join(self.choices)}, not {value!r}")
        return value


class Options:
    """The chosen settings, the rest at their defaults; read with the type that is expected."""

    def __init__(self, table: Iterable[Option], chosen: Mapping[str, Value] | None = None) -> None:
        rows = {row.name: row for row in table}
        self._values = {name: row.default for name, row in rows.items()}
        for name, value in (chosen or {}).items():
            self._values[name] = _row(rows, name).checked(value)

    @classmethod
    def parse(cls, table: Iterable[Option], words: Iterable[str]) -> dict[str, Value]:
        """Read NAME=VALUE words. Raises `BadRequest` with the nearest name."""
        rows = {row.name: row for row in table}
        chosen: dict[str, Value] = {}
        for word in words:
            name, equals, text = word.partition("=")
            if not equals:
                raise BadRequest(f"write a setting as NAME=VALUE, not {word!r}")
            key = name.strip().replace("-", "_")
            chosen[key] = _row(rows, key).parse(text.strip())
        return chosen

    @property
    def values(self) -> dict[str, Any]:
        """Return all of them by their names."""
        return dict(self._values)

    def flag(self, name: str) -> bool:
        """Return a setting that is true or false."""
        return bool(self._values[name])

    def whole(self, name: str) -> int:
        """Return a whole number."""
        return int(self._values[name])

    def number(self, name: str) -> float:
        """Return a number."""
        return float(self._values[name])

    def text(self, name: str) -> str:
        """Return a text."""
        return str(self._values[name])


def _row(rows: Mapping[str, Option], name: str) -> Option:
    if name in rows:
        return rows[name]
    known = f"known are {', '.join(rows)}" if rows else "this device has none"
    hint = did_you_mean(name, rows, known)
    raise BadRequest(f"the simulated device has no setting {name!r}; {hint}")


# --- The report: the whole state, physical and commanded, for people and programs ----------------

_MM_DIGITS = 3
_DEG_DIGITS = 3


def state_json(device: SimDevice) -> dict[str, Json]:
    """Return the state as plain data; lengths in mm, angles in degrees, forces in N."""
    world = device.world
    pose, scene = world.pose, world.scene
    joints: dict[str, Json] = {
        name: round(angle, _DEG_DIGITS) for name, angle in world.joints.deg.items()
    }
    return {
        "powered": device.powered,
        "energised": world.energised,
        "moving": device.moving,
        "busy": device.busy,
        "registers": list(device.registers),
        "motors": list(world.motors),
        "joints_deg": joints,
        "pose": {
            "x_mm": round(pose.x_mm, _MM_DIGITS),
            "y_mm": round(pose.y_mm, _MM_DIGITS),
            "z_mm": round(pose.z_mm, _MM_DIGITS),
            "pitch_deg": round(pose.pitch_deg, _DEG_DIGITS),
            "roll_deg": round(pose.roll_deg, _DEG_DIGITS),
            **({} if pose.yaw_deg is None else {"yaw_deg": round(pose.yaw_deg, _DEG_DIGITS)}),
        },
        "opening_mm": round(world.opening_mm, _MM_DIGITS),
        "grip_force_n": round(world.grip_force_n, _MM_DIGITS),
        "inputs": device.inputs,
        **device.board.details(),
        "stalled": [motor + 1 for motor in sorted(world.stalled)],
        "held": scene.held,
        "blocks": [block_to_json(block) for block in scene.blocks.values()],
        "incidents": [incident_to_json(incident) for incident in world.incidents],
    }


def state_line(device: SimDevice) -> str:
    """Return the state in one line."""
    world = device.world
    words = [
        f"power {'on' if device.powered else 'off'}",
        f"current {'on' if world.energised else 'off'}",
        "moving" if device.moving else "still",
        str(world.pose),
        f"fingers {world.opening_mm:.1f} mm apart",
        f"grip {world.grip_force_n:.1f} N",
        f"registers {','.join(map(str, device.registers))}",
    ]
    held, blocks = world.scene.held, world.scene.blocks
    words += [f"holds {held}"] if held else []
    words += [f"blocks {', '.join(blocks)}"] if blocks else []
    words += [f"incidents {len(world.incidents)}"] if world.incidents else []
    return "; ".join(words)
