"""A simulated Armdroid: the serial driver sketch on a simulated physical arm.

Observed: the unchanged sketch (Armdroid/Armdroid-Arduino-Library, SerialDriver, with Arduino's AVR
core 1.8.7) on a simulated processor of an Uno and of a Leonardo: `BOARDS` says how they differ.
Both are given the buffer of an Uno, because the native USB of a Leonardo loses nothing.

What the interface does at a reset is a guess, the harsher one: the motors are released. The sketch
leaves the latches of the coils as they are. Not simulated: it then begins with its first coil
pattern, so the next `1t` or step turns each motor by up to two steps; and a step after `0t`
switches on only the motors that make it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.device import Board, speed_error
from armdrive.sim.mechanics.motors import MotorDrive, MotorRack
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from armdrive.sim.world.saved import Json
from armdrive.text.toml import setting
from firmware_protocol.armdroid import (
    RPM_DEFAULT,
    ArgumentsReported,
    Device,
    DriveAll,
    DriveOne,
    HomeToOffsets,
    OffsetsReported,
    ReportArguments,
    Request,
    SetSpeed,
    SpeedReported,
    Torque,
    TorqueReported,
    Version,
    VersionReported,
    Welcome,
    ZeroOffsets,
)
from firmware_protocol.armdroid import ReportOffsets as _Report
from firmware_protocol.fields import INT16_MAX, INT16_MIN, wrapped16
from kinematics.spaces import Motors

BAUD = 9600
# The channel of each motor: base, shoulder, elbow, right and left wrist, gripper.
CHANNELS = (6, 5, 4, 3, 2, 1)
MINUTE_MS, TURN_STEPS = 60_000, 48
# The time between two steps of all six motors when the sketch does not wait, as observed.
AT_ONCE_S = 0.00045
# The interval that an AVR computes from a division by zero: the largest 32-bit number, in ms.
#
# As observed, the motion makes no step, and nothing is answered until a reset.
NEVER_S = 4_294_967.295


# What the receive buffer of an Uno holds: a ring of 64 bytes, of which one stays empty.
ROOM_BYTES = 63
# The duration of a reset.
BOOT_S = 1.6
LEONARDO, UNO = "leonardo", "uno"


@dataclass(frozen=True, slots=True)
class ArmdroidQuirks:
    """What differs between boards.

    A board with `native_usb` greets the program that opens its port; others reset instead. It takes
    `character_s` to process a character.
    """

    board: str = setting(LEONARDO, "leonardo, with native USB, or uno", words=(LEONARDO, UNO))
    speed_error: float = speed_error("0.2: motors a fifth slower than the sketch says")
    character_s: float = 0.010
    native_usb: bool = True

    def interval_s(self, rpm: int) -> float:
        """Return the time between two steps: whole milliseconds, by integer division."""
        interval_s = NEVER_S
        if rpm:
            interval_s = max(MINUTE_MS // TURN_STEPS // (rpm % (1 << 32)) / 1000.0, AT_ONCE_S)
        return interval_s * (1.0 + self.speed_error)


# The boards, as observed. The harsher one is the usual one.
BOARDS: Mapping[str, ArmdroidQuirks] = MappingProxyType(
    {
        LEONARDO: ArmdroidQuirks(LEONARDO),
        UNO: ArmdroidQuirks(UNO, character_s=0.0, native_usb=False),
    }
)


def by_channel(by_motor: Sequence[int]) -> tuple[int, ...]:
    """Return counts in channel order."""
    return tuple(by_motor[CHANNELS.index(channel)] for channel in range(1, len(CHANNELS) + 1))


def by_motor(by_channel: Sequence[int]) -> tuple[int, ...]:
    """Return counts in the order of the arm's motors."""
    return tuple(by_channel[channel - 1] for channel in CHANNELS)


@dataclass(frozen=True, slots=True)
class SavedArmdroid:
    """What is saved of the board."""

    rpm: int = setting(low=INT16_MIN, high=INT16_MAX)


class ArmdroidBoard(Board):
    """The board with its sketch, and the arm."""

    title: ClassVar[str] = "Armdroid"
    input_bits = 0
    saved_as = SavedArmdroid
    drive: MotorDrive[MotorRack]

    def __init__(
        self,
        world: World | None = None,
        quirks: ArmdroidQuirks | None = None,
        *,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        super().__init__(world, MotorDrive(world, MotorRack((0,) * len(world.motors))), baud)
        self.quirks = quirks or ArmdroidQuirks()
        self.lost_bytes = 0
        self.rpm = RPM_DEFAULT
        """The speed set last."""
        self._codec = Device()
        self._waiting = bytearray()
        self._turn_s = 0.0
        self._deaf_until_s = 0.0
        self._greeting = False

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered or characters wait."""
        return self._codec.unanswered is not None or bool(self._waiting)

    @property
    def registers(self) -> Motors:
        """The offsets in the order of the arm's motors: signed, 16 bits, wrapping."""
        return Motors(wrapped16(count) for count in self.drive.counts)

    @property
    def offsets(self) -> tuple[int, ...]:
        """The offsets in the order of the board's channels."""
        return by_channel(self.registers)

    def details(self) -> dict[str, Json]:
        """Return the speed, its error, and the arguments that a stray `D` would execute."""
        kept: list[Json] = [*self._codec.arguments]
        return {"rpm": self.rpm, "speed_error": self.quirks.speed_error, "kept": kept}

    # Actions of a person.

    def set_input(self, bit: int, on: bool) -> None:  # noqa: ARG002
        """Refuse: the board has no inputs."""
        raise BadRequest("the simulated Armdroid has no input bits")

    def opened(self) -> None:
        """Open the port, as every connecting program does.

        A board that greets does not notice during a motion (observed on a Leonardo).
        """
        if not self.quirks.native_usb:
            self.reset()
        elif self._codec.unanswered is None:
            self._greeting, self._turn_s = True, self.now_s

    def reset(self) -> None:
        """Press the reset button: motion stops dead, offsets and speed are lost, motors are off."""
        self.drive.lose_power(self.now_s)
        self.forget()
        self.boot()

    # How the board handles characters and time.

    def receive(self, data: bytes) -> None:
        """Receive as many characters as fit the buffer; none while the board starts."""
        taken = b"" if self.now_s < self._deaf_until_s else data
        taken = taken[: ROOM_BYTES - len(self._waiting)]
        self.lost_bytes += len(data) - len(taken)
        if taken and not self._waiting:
            self._turn_s = max(self._turn_s, self.now_s + self.quirks.character_s)
        self._waiting += taken

    def due_s(self) -> float:
        """Return when the board takes its next character, or a motion ends."""
        if self._codec.unanswered is not None:
            return self.drive.done_s
        return self._turn_s if self._waiting or self._greeting else self.drive.done_s

    def happen(self) -> None:
        """End a motion, send the greeting, or take the next character."""
        if self.drive.moving:
            super().happen()
        elif self._greeting:
            self._greeting = False
            self.outgoing += self._codec.send(Welcome())
        else:
            self._codec.receive_data(bytes([self._waiting.pop(0)]))
            if (event := self._codec.next_event()) is not None:
                self._do(event)
            self._turn_s = self.now_s + self.quirks.character_s

    def motion_ended(self) -> None:
        """Answer with the offsets."""
        self._answer(OffsetsReported(self.offsets))

    def _do(self, event: Request) -> None:
        match event:
            case DriveAll(steps):
                self._turn(steps)
            case DriveOne(motor, steps):
                self._turn(tuple(steps if channel == motor else 0 for channel in range(1, 7)))
            case HomeToOffsets():
                self._turn(tuple(-offset for offset in self.offsets))
            case _:
                self._tell(event)

    def _tell(self, event: Request) -> None:
        """Execute a command that takes no time, and answer."""
        match event:
            case SetSpeed(rpm):
                self.rpm = rpm
                self._answer(SpeedReported(rpm))
            case Torque(on):
                if on:
                    self.drive.energise()
                else:
                    self.world.cut_current(self.now_s)
                self._answer(TorqueReported(on))
            case ZeroOffsets():
                self.drive.set_counts((0,) * len(self.world.motors), self.now_s)
                self._answer(OffsetsReported(self.offsets))
            case _Report():
                self._answer(OffsetsReported(self.offsets))
            case ReportArguments():
                self._answer(ArgumentsReported(self._codec.arguments, self._codec.accumulator))
            case Version():
                self.outgoing += self._codec.send(VersionReported())

    def _turn(self, steps: Sequence[int]) -> None:
        if any(steps):
            self.drive.energise()
        interval_s = self.quirks.interval_s(self.rpm)
        self.drive.rack.start(by_motor(steps), interval_s, self.now_s, in_proportion=False)

    def _answer(
        self, answer: OffsetsReported | SpeedReported | TorqueReported | ArgumentsReported
    ) -> None:
        self.outgoing += self._codec.send(answer)
        self._turn_s = self.now_s + self.quirks.character_s

    def boot(self) -> None:
        """Start the sketch: it ignores input for a while, then greets."""
        self._deaf_until_s = self.now_s + BOOT_S
        self._greeting, self._turn_s = self.quirks.native_usb, self._deaf_until_s

    def forget(self) -> None:
        """Clear the speed and any partly received command."""
        self._codec.forget()
        self._waiting.clear()
        self.rpm, self._greeting = RPM_DEFAULT, False


def _make(config: ArmConfig, world: World, chosen: ArmdroidQuirks) -> ArmdroidBoard:
    """Make the board as a program finds it that has just opened the port."""
    quirks = replace(BOARDS[chosen.board], speed_error=chosen.speed_error)
    board = ArmdroidBoard(world, quirks, baud=config.connection.baud)
    if quirks.native_usb:
        board.opened()
    return board


KIND = SimDeviceKind(ArmdroidBoard, _make, ArmdroidQuirks)
