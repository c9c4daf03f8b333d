"""An Armdroid that is not there: the serial driver sketch on a simulated physical arm.

Sources: Armdroid/Armdroid-Arduino-Library (Armdroid.cpp, SerialDriver) and Arduino's AVR core.
Where boards differ the harsher one is built: it takes 10 ms for a character as one with native USB
does, and has room for no more characters than one with a serial chip. Where the real arm's habit
is unknown too: a reset of the board lets the motors go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

from armdrive.sim.armdroid.board import ArmdroidBoard, LockstepRack, by_channel, by_motor
from armdrive.sim.device import BoxedDevice, DeviceBox, DeviceClock, lacks
from armdrive.sim.mechanics.motors import MotorDrive, checked_error
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json, Saved
from firmware_protocol.armdroid import (
    RPM_DEFAULT,
    STEPS_MAX,
    STEPS_MIN,
    ArgumentsReported,
    Device,
    DriveAll,
    DriveNone,
    DriveOne,
    HomeToOffsets,
    Ignored,
    InterfaceKind,
    InterfaceReported,
    OddSpeed,
    OffsetsReported,
    Overrun,
    ReportArguments,
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
from firmware_protocol.armdroid.device import DeviceEvent
from kinematics.spaces import Motors

BAUD = 9600
_WORD, _SIGN = 1 << 16, 1 << 15
Owed = OffsetsReported | SpeedReported | TorqueReported | ArgumentsReported


class ArmdroidBox(DeviceBox):
    """The board with its sketch: characters in, answers out, motors turned."""

    _drive: MotorDrive[LockstepRack]

    def __init__(
        self,
        drive: MotorDrive[LockstepRack],
        clock: DeviceClock,
        board: ArmdroidBoard,
        said: bytearray,
    ) -> None:
        self.clock = clock
        self.board = board
        self.said = said
        self.lost_bytes = 0
        self._drive = drive
        self._codec = Device()
        self._waiting = bytearray()
        self._rpm = RPM_DEFAULT
        self._turn_s = 0.0
        self._deaf_until_s = 0.0
        self._greeting = False

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered, or characters wait."""
        return self._codec.unanswered is not None or bool(self._waiting)

    @property
    def registers(self) -> Motors:
        """The offsets in the order of the arm's motors: signed 16 bit, wrapping."""
        return Motors((count + _SIGN) % _WORD - _SIGN for count in self._drive.counts)

    @property
    def offsets(self) -> tuple[int, ...]:
        """The same in the order of the board's channels."""
        return by_channel(self.registers)

    @property
    def kept(self) -> tuple[int, ...]:
        """The arguments that a stray `D` would carry out."""
        return self._codec.arguments

    @property
    def rpm(self) -> int:
        """The speed that was set last."""
        return self._rpm

    def greet(self) -> None:
        """Say welcome to whoever opens the port, unless a motion is under way."""
        if self.board.greets and self._codec.unanswered is None:
            self._greeting, self._turn_s = True, self.clock.now_s

    def hear(self, data: bytes) -> None:
        """Take characters, as many as there is room for; none while it starts."""
        heard = b"" if self.clock.now_s < self._deaf_until_s else data
        heard = heard[: self.board.room_bytes - len(self._waiting)]
        self.lost_bytes += len(data) - len(heard)
        if heard and not self._waiting:
            self._turn_s = max(self._turn_s, self.clock.now_s + self.board.character_s)
        self._waiting += heard

    def due_s(self) -> float:
        """Tell when it takes its next character, or a motion ends."""
        if self._codec.unanswered is not None:
            return self._drive.done_s
        return self._turn_s if self._waiting or self._greeting else self._drive.done_s

    def happen(self) -> None:
        """End a motion, say welcome, or take the next character."""
        if self._drive.moving:
            super().happen()
        elif self._greeting:
            self._greeting = False
            self.said += self._codec.send(Welcome())
        else:
            self._codec.receive_data(bytes([self._waiting.pop(0)]))
            if (event := self._codec.next_event()) is not None:
                self._do(event)
            self._turn_s = self.clock.now_s + self.board.character_s

    def motion_ended(self) -> None:
        """Answer with the offsets."""
        self._answer(OffsetsReported(self.offsets))

    def _do(self, event: DeviceEvent) -> None:
        match event:
            case DriveAll(steps):
                self._turn(steps)
            case DriveOne(motor, steps):
                self._turn(tuple(steps if channel == motor else 0 for channel in range(1, 7)))
            case HomeToOffsets():
                self._turn(tuple(-offset for offset in self.offsets))
            case Ignored() | Overrun():
                pass
            case _:
                self._tell(event)

    def _tell(self, event: DeviceEvent) -> None:
        """Do what takes no time, and answer."""
        match event:
            case SetSpeed(rpm) | OddSpeed(rpm):
                self._rpm = rpm
                self._answer(SpeedReported(rpm))
            case Torque(on):
                if on:
                    self._drive.energise()
                else:
                    self._drive.world.cut_current(self.clock.now_s)
                self._answer(TorqueReported(on))
            case ZeroOffsets():
                self._drive.set_counts((0,) * len(self._drive.world.motors), self.clock.now_s)
                self._answer(OffsetsReported(self.offsets))
            case _Report() | DriveNone():
                self._answer(OffsetsReported(self.offsets))
            case ReportArguments():
                self._answer(ArgumentsReported(self.kept, self._codec.accumulator))
            case Version():
                self.said += self._codec.send(VersionReported())
            case InterfaceKind():
                self.said += self._codec.send(InterfaceReported())

    def _turn(self, steps: Sequence[int]) -> None:
        if any(steps):
            self._drive.energise()
        self._drive.rack.start(by_motor(steps), self.board.interval_s(self._rpm), self.clock.now_s)

    def _answer(self, answer: Owed) -> None:
        self.said += self._codec.send(answer)
        self._turn_s = self.clock.now_s + self.board.character_s

    def boot(self) -> None:
        """Begin the sketch: it is deaf for a while, and then says welcome."""
        self._deaf_until_s = self.clock.now_s + self.board.boot_s
        self._greeting, self._turn_s = self.board.greets, self._deaf_until_s

    def forget(self) -> None:
        """Lose the speed, and whatever is half received."""
        self._codec.forget()
        self._waiting.clear()
        self._rpm, self._greeting = RPM_DEFAULT, False

    def known(self) -> dict[str, Json]:
        """Return the speed."""
        return {"rpm": self._rpm}

    def recall_known(self, saved: Saved) -> None:
        """Know the speed that `known` wrote; raises `StateFileError`."""
        self._rpm = saved.whole("rpm", STEPS_MIN, STEPS_MAX)


class SimArmdroid(BoxedDevice):
    """The board with its sketch, the arm, and the person beside them."""

    title: ClassVar[str] = "Armdroid"
    input_bits: ClassVar[int] = 0
    box: ArmdroidBox
    _drive: MotorDrive[LockstepRack]

    def __init__(
        self,
        world: World | None = None,
        board: ArmdroidBoard | None = None,
        *,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        rack = LockstepRack((0,) * len(world.motors))
        super().__init__(world, MotorDrive(world, rack), baud)
        self.box = ArmdroidBox(self._drive, self.clock, board or ArmdroidBoard(), self.said)

    @property
    def speed_error(self) -> float:
        """By which share motions last longer than they should."""
        return self.box.board.speed_error

    def details(self) -> dict[str, Json]:
        """Return the speed, how wrong it is, and what a stray `D` would repeat."""
        return {"rpm": self.box.rpm, "speed_error": self.speed_error, "kept": list(self.box.kept)}

    # What a person can do.

    def set_speed_error(self, error: float) -> None:
        """Make motions that begin from now on last longer (0.2: a fifth) or shorter (negative)."""
        self.box.board = replace(self.box.board, speed_error=checked_error(error))

    def set_input(self, bit: int, on: bool) -> None:  # noqa: ARG002
        """Refuse: the board has no inputs."""
        raise lacks(self, "input bits")

    def opened(self) -> None:
        """Open its port, as every program does that connects; nothing is seen of it in motion."""
        if self.box.board.resets_on_open:
            self.reset()
        else:
            self.box.greet()

    def reset(self) -> None:
        """Press the board's button: motion ends dead, offsets and speed are lost, motors let go."""
        self._drive.set_counts((0,) * len(self.world.motors), self.now_s)
        self.world.cut_current(self.now_s)
        self.box.forget()
        self.box.boot()
