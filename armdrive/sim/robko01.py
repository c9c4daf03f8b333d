"""A simulated Robko 01: the arm's end of its SUPER protocol on a simulated physical arm.

It reproduces everything observed on the AVR firmware, and what public sources say about the ESP32
retrofit. Where the behaviour is unknown, this device takes the harsher option: after power-on the
motors are off; motors that are switched off in mid-motion go on counting although nothing turns;
and `Clear` stops a motion dead.

Requests are answered one at a time, each after a short delay. Invalid frames, and requests that the
firmware lists but does not implement, are dropped silently.
"""

from __future__ import annotations

import contextlib
import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.sim.device import Board, speed_error
from armdrive.sim.mechanics.accelstepper import UncoordinatedRack
from armdrive.sim.mechanics.motors import MotorDrive
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from armdrive.sim.world.saved import Json
from armdrive.text.toml import setting
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.fields import wrapped16
from firmware_protocol.robko01 import (
    AXES,
    PAYLOAD_MAX,
    Acknowledged,
    Answer,
    Axes,
    Busy,
    Clear,
    Disable,
    Enable,
    Inputs,
    InputsRead,
    IsMoving,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Moving,
    Op,
    Outputs,
    OutputsSet,
    Ping,
    Pong,
    Position,
    Positions,
    Request,
    Status,
    Stop,
)
from firmware_protocol.robko01.frames import (
    SENTINEL,
    Kind,
    SuperFrame,
    check_bytes,
    frame_bytes,
)
from firmware_protocol.robko01.messages import decode_request, encode_answer
from kinematics.spaces import Motors

BAUD = 115_200

# --- The firmware's frame reader, with its faults ------------------------------------------------
# The codec's `Device` finds every valid frame. The firmware's reader does not, and the driver has
# to cope with that, so a simulated board reads its bytes as the firmware does (`SUPER.cpp`,
# read_frame).

# The possible values of the length byte: the operation and its payload.
LENGTHS = range(1, PAYLOAD_MAX + 2)
# How many payload bytes an operation reads, whatever was sent; other operations read none.
PAYLOAD_BYTES = {
    Op.MOVE_RELATIVE: 24,
    Op.MOVE_ABSOLUTE: 24,
    Op.MOVE_SPEED: 24,
    Op.OUTPUTS: 1,
}

_KNOWN = frozenset(Op)
_HEADER, _CHECK = 4, 2


class FirmwareReader:
    """Turns bytes into whole requests, and silently drops what it cannot read.

    Two quirks, both observed on the ARDN_Operation example on an atmega328p in an AVR simulator:

    - **It loses the next frame** after a frame with a length of 0 and after a doubled 0xAA. A byte
      that does not fit resets the reader to waiting for 0xAA without being examined again, so an
      0xAA among the leftover bytes is taken for the start of a frame.
    - **Short payloads use stale bytes.** The payload is copied into a buffer that is never
      cleared, and an operation reads its full length from there. (What `MoveSpeed` reads after a
      short payload was not observed; the same is assumed.) Excess bytes are ignored.
    """

    def __init__(self) -> None:
        self._frame = bytearray()
        self._payload = bytearray(PAYLOAD_MAX)

    def read(self, data: bytes) -> Iterator[bytes]:
        """Yield each request that the firmware acts on, with the payload as it reads it."""
        for byte in data:
            if not self._frame and byte != SENTINEL:
                continue
            self._frame.append(byte)
            if not self._fits():
                self._frame.clear()
            elif len(self._frame) > _HEADER and len(self._frame) == self._whole():
                frame = bytes(self._frame)
                self._frame.clear()
                checked = frame[-_CHECK:] == check_bytes(frame[:-_CHECK])
                if checked and frame[1] == Kind.REQUEST:
                    yield self._request(frame[_HEADER - 1], frame[_HEADER:-_CHECK])

    def _fits(self) -> bool:
        """Return whether the last byte of the header is valid in its place."""
        match len(self._frame):
            case 2:
                return self._frame[1] in (Kind.REQUEST, Kind.ANSWER)
            case 3:
                return self._frame[2] in LENGTHS
            case _:
                return True

    def _whole(self) -> int:
        return _HEADER - 1 + self._frame[2] + _CHECK

    def _request(self, op: int, payload: bytes) -> bytes:
        self._payload[: len(payload)] = payload
        if op != Op.PING and op in _KNOWN:  # a ping is echoed, whatever its length
            payload = bytes(self._payload[: PAYLOAD_BYTES.get(Op(op), 0)])
        return frame_bytes(Kind.REQUEST, op, payload)


# A ping of eight bytes took 5 ms there and back, of which the line accounts for the rest.
THINKS_S = 0.0025
# How long after an accepted move `IsMoving` may still report that nothing moves.
EARLY_ZERO_S = 0.010
AVR, ESP32 = "avr", "esp32"
AS_THE_ARM_FILE = "file"


# How often a motor may step. The AVR board serves eight addresses, one every millisecond and a
# little more: 400 steps at full speed came 8.048 ms apart on the ARDN_Operation example in an AVR
# simulator.
GRIDS_S = {AVR: 0.00804, ESP32: 0.0}
ACCELERATIONS_STEPS_S2 = {AVR: 700.0, ESP32: 75.0}
# The top speed of an axis after power-on: DEFAULT_SPEED of `Robko01.h`, and M1_MAX_SPEED to
# M6_MAX_SPEED of the retrofit's `ApplicationConfiguration.h`.
TOP_SPEEDS_HZ = {AVR: 5000.0, ESP32: 100.0}


@dataclass(frozen=True, slots=True)
class RobkoQuirks:
    """What differs between boards.

    With `grid_s`, a motor can step only at these intervals. Silence for `watchdog_s` switches the
    motors off (0 means no watchdog).

    Quirks of the AVR board, all observed on the ARDN_Operation example on an atmega328p in an AVR
    simulator:

    - **Operation 6 ignores its speed**, and ramps up to the axis's top speed: `top_speed_hz` after
      power-up, then that of operation 7 (`absolute_sets_top`). With a top speed of 0 it leaves the
      axis hanging: one step, then reported as moving. Operation 7 is then refused as busy, and
      operation 2 has no effect. Operation 12 with all speeds 0 frees the axis, and so does a reset.
    - **A resting axis twitches**: an axis that is already at its goal and is given a speed makes
      one step forward and, 40 ms later, one back, unless its top speed was 0.
    - **Operation 2 does not stop operation 12**: the axis runs on, at 25 steps/s. It hardly stops
      operation 6 either: it slows down over as many steps as from 5000 steps/s.
    - The quirks of the reader are listed in `FirmwareReader`.

    The retrofit sets no top speed, and operation 7 leaves axes that are at their goals alone. This
    was read in its `main.cpp`, not observed.
    """

    board: str = setting(
        AS_THE_ARM_FILE, "avr, esp32, or the arm file's", words=(AS_THE_ARM_FILE, AVR, ESP32)
    )
    acceleration: float = setting(
        0.0, "steps/s^2 of every axis; 0: 700 of avr, 75 of esp32", low=0.0
    )
    grid_s: float = GRIDS_S[AVR]
    speed_error: float = speed_error("0.2: motors a fifth slower than they should be")
    watchdog_s: float = setting(
        0.0, "seconds without ping, inputs or position; 0: no watchdog", low=0.0
    )
    top_speed_hz: float = TOP_SPEEDS_HZ[AVR]

    @property
    def absolute_sets_top(self) -> bool:
        """Whether operation 7 obeys its speed, which then becomes the axis's top speed."""
        return self.board == AVR


class RobkoDrive(MotorDrive[UncoordinatedRack]):
    """Axes that move independently. Without current the counts go on and the arm does not move."""

    def __init__(self, world: World, quirks: RobkoQuirks) -> None:
        stretch = 1.0 + quirks.speed_error
        rack = UncoordinatedRack(
            (0,) * len(world.motors),
            acceleration_hz_s=quirks.acceleration / stretch**2,
            top_hz=quirks.top_speed_hz / stretch,
            grid_s=quirks.grid_s * stretch,
            stagger_s=quirks.grid_s * stretch / 8,
        )
        super().__init__(world, rack)
        self._stretch, self._absolute_sets_top = stretch, quirks.absolute_sets_top

    def run_at(self, axes: Axes, now_s: float) -> None:
        """Run every axis at a speed until the next command: operation 12."""
        for axis, speed in enumerate(axes.speeds_steps_s):
            self.rack.run(axis, speed / self._stretch, now_s)

    def move_by(self, axes: Axes, now_s: float) -> None:
        """Move every axis by a distance: operation 6."""
        here = self.rack.positions(now_s)
        ways = zip(axes.positions_steps, axes.speeds_steps_s, strict=True)
        for axis, (steps, speed) in enumerate(ways):
            self.rack.move_to(axis, here[axis] + steps, speed / self._stretch, now_s)

    def move_to(self, axes: Axes, now_s: float) -> None:
        """Send every axis to its goal: operation 7."""
        here = self.rack.positions(now_s)
        goals = zip(axes.positions_steps, axes.speeds_steps_s, strict=True)
        for axis, (steps, speed) in enumerate(goals):
            if self._absolute_sets_top:
                self.rack.move_at(axis, steps, speed / self._stretch, now_s)
            elif steps != here[axis]:
                self.rack.move_to(axis, steps, speed / self._stretch, now_s)

    def reported(self, now_s: float) -> Axes:
        """Return positions and speeds as reported: in 16 bits."""
        speeds = (wrapped16(round(speed)) for speed in self.rack.speeds(now_s))
        return Axes(tuple(wrapped16(count) for count in self.counts), tuple(speeds))

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn motors by hand. Motors that were off are off again afterwards."""
        held = self.world.energised
        super().turn(steps, now_s)
        self.world.energised = held

    def _turn(self, steps: Motors, now_s: float) -> None:
        if self.world.energised:
            super()._turn(steps, now_s)


@dataclass(frozen=True, slots=True)
class SavedRobko:
    """What is saved of the board."""

    enabled: bool
    outputs: int = setting(low=0, high=255)


class SimRobkoBoard(Board):
    """The board and the arm; `RobkoQuirks` lists the differences between boards."""

    title: ClassVar[str] = "Robko 01"
    saved_as = SavedRobko
    drive: RobkoDrive

    def __init__(
        self,
        world: World | None = None,
        *,
        quirks: RobkoQuirks | None = None,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        self.quirks = quirks or RobkoQuirks(AVR, ACCELERATIONS_STEPS_S2[AVR])
        world.energised = False
        super().__init__(world, RobkoDrive(world, self.quirks), baud)
        self._begin()

    def _begin(self) -> None:
        self.enabled = False
        self.outputs = 0
        self._reader = FirmwareReader()
        self._requests: deque[Request] = deque()
        """The requests to be answered, one after the other."""
        self._answer_s = math.inf
        self._accepted_s = -math.inf
        self._fed_s = -math.inf

    @property
    def busy(self) -> bool:
        """Whether a request is unanswered or a motion under way."""
        return bool(self._requests) or self.drive.moving

    @property
    def registers(self) -> Motors:
        """The positions as reported: in 16 bits."""
        return Motors(wrapped16(count) for count in self.drive.counts)

    def due_s(self) -> float:
        """Return when a motion ends, a reply is due, or the watchdog expires."""
        return min(super().due_s(), self._own_due_s())

    def _own_due_s(self) -> float:
        watched = self.quirks.watchdog_s and self.enabled
        return min(self._answer_s, self._fed_s + self.quirks.watchdog_s if watched else math.inf)

    def forget(self) -> None:
        """Restart the firmware."""
        self.drive.rack.restart()
        self._begin()

    def recall_known(self, saved: SavedRobko) -> None:
        """Restore what `known` returned: without its motors on, the arm has no current."""
        super().recall_known(saved)
        self.world.energised = self.enabled

    def details(self) -> dict[str, Json]:
        """Return the board type, its outputs, and whether its motors are on."""
        return {"board": self.quirks.board, "enabled": self.enabled, "outputs": self.outputs}

    def reset(self) -> None:
        """Restart the firmware: motion stops dead, positions become zero, and the motors go off."""
        if self.powered:
            self.drive.lose_power(self.now_s)
            self.outgoing.clear()
            self.forget()

    def receive(self, data: bytes) -> None:
        """Receive bytes; each request takes a while to process."""
        for frame in self._reader.read(data):
            with contextlib.suppress(RemoteProtocolError):  # an operation that it does not have
                self._requests.append(decode_request(SuperFrame(frame, 0)))
        self._take_up(self.now_s)

    def happen(self) -> None:
        """End a motion, reply, or act on the watchdog, whichever is due."""
        super().happen()
        now_s = self.now_s
        if self._answer_s <= now_s:
            self._answer_s = math.inf
            self._reply(self._requests.popleft(), now_s)
            self._take_up(now_s)
        # The reply goes first, because its request may feed the watchdog; if it does not, this is
        # called again at once.
        elif self._own_due_s() <= now_s:
            self._switch(False, now_s)

    def _take_up(self, now_s: float) -> None:
        if self._requests and math.isinf(self._answer_s):
            self._answer_s = now_s + THINKS_S

    def _reply(self, request: Request, now_s: float) -> None:
        if isinstance(request, Ping | Inputs | Position):
            self._fed_s = now_s
        self.outgoing += encode_answer(self._do(request, now_s))

    def _do(self, request: Request, now_s: float) -> Answer:
        match request:
            case Ping(payload):
                return Pong(payload)
            case Inputs():
                return InputsRead(self.inputs_set)
            case IsMoving():
                early = now_s < self._accepted_s + EARLY_ZERO_S
                return Moving(0 if early else self.drive.rack.mask(now_s))
            case Position():
                return Positions(self.drive.reported(now_s))
            case MoveRelative() | MoveAbsolute() | MoveSpeed() if not self.enabled:
                return Acknowledged(request.op, Status.ERROR)
            case MoveRelative() | MoveAbsolute() if mask := self.drive.rack.mask(now_s):
                return Busy(request.op, mask)
            case MoveRelative(axes):
                self.drive.move_by(axes, now_s)
                self._accepted_s = now_s
                return Acknowledged(request.op)
            case MoveAbsolute(axes):
                self.drive.move_to(axes, now_s)
                self._accepted_s = now_s
                return Acknowledged(request.op)
            case MoveSpeed(axes):
                self.drive.run_at(axes, now_s)
                return Acknowledged(request.op)
            case Outputs(value):
                self.outputs = value
                return OutputsSet(value)
            case _:
                self._command(request, now_s)
                return Acknowledged(request.op)

    def _command(self, request: Request, now_s: float) -> None:
        match request:
            case Stop():
                self.drive.rack.ramp_down(now_s)
            case Enable():
                self._switch(True, now_s)
            case Disable():
                self._switch(False, now_s)
            case Clear():
                self.drive.set_counts((0,) * AXES, now_s)

    def _switch(self, on: bool, now_s: float) -> None:
        self.enabled = on
        if on:
            self._fed_s = max(self._fed_s, now_s)
            self.drive.energise()
        else:
            self.world.cut_current(now_s)


def _make(config: ArmConfig, world: World, chosen: RobkoQuirks) -> SimRobkoBoard:
    board = config.device.board if chosen.board == AS_THE_ARM_FILE else chosen.board
    quirks = replace(
        chosen,
        board=board,
        acceleration=chosen.acceleration or ACCELERATIONS_STEPS_S2[board],
        grid_s=GRIDS_S[board],
        top_speed_hz=TOP_SPEEDS_HZ[board],
    )
    return SimRobkoBoard(world, quirks=quirks, baud=config.connection.baud)


KIND = SimDeviceKind(SimRobkoBoard, _make, RobkoQuirks)
