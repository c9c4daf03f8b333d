"""A simulated TeachMover: the device side of its dialect on a simulated physical arm.

Where the behaviour of the real arm is unknown, this device takes the harsher option: bytes that
arrive while a command is unanswered are lost, the program memory does not survive a loss of power,
and after power-on the motors have no current until the first motion.

Only one command is unanswered at a time. The end of a motion answers it (`motion_ended`), the
pendant may answer it (`press`, `return_control`), and everything else is answered
at once.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.dialects.teachmover.settings import TeachMoverSettings
from armdrive.errors import BadRequest
from armdrive.sim.device import Board, speed_error
from armdrive.sim.mechanics.motors import CoordinatedDrive
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from armdrive.sim.world.saved import Json, unfit
from armdrive.text.toml import setting
from firmware_protocol.errors import ProtocolError, RemoteProtocolError
from firmware_protocol.events import Unreadable
from firmware_protocol.fields import wrapped16
from firmware_protocol.lines import LineSplitter
from firmware_protocol.teachmover import (
    ATTENTION,
    Close,
    Command,
    Key,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Run,
    Set,
    Status,
    Step,
)
from firmware_protocol.teachmover.messages import (
    CR,
    MOVE_KIND,
    NOISE,
    decode_command,
    encode_reply,
)
from kinematics.spaces import Motors

BAUD = 9600

# Public sources say that the memory holds about 50 points.
MEMORY_ROWS = 50
# At this rate, closing over the full 76 mm takes about 4 s.
CLOSE_RATE_HZ = 277.0
STILL = (0, 0, 0, 0, 0, 0)


# The real rates, from SP to half-steps a second. Deliberately independent of the driver's table: if
# the two differ, the driver has to notice.

# Unverified: the real table was never published. Straight lines between the points.
RATES_HZ = ((0, 30.0), (140, 150.0), (190, 250.0), (240, 470.0))


def rate_hz(speed: int, error: float) -> float:
    """Return half-steps per second; an `error` of 0.2 means a fifth slower, -0.2 a fifth faster.

    A speed beyond the end of the table has the rate of that end.
    """
    for (low, slow), (high, fast) in itertools.pairwise(RATES_HZ):
        if speed <= high:
            return (slow + (fast - slow) * (speed - low) / (high - low)) / (1.0 + error)
    return RATES_HZ[-1][1] / (1.0 + error)


@dataclass(frozen=True, slots=True)
class TeachMoverQuirks:
    """What is unverified about the real arm, or differs between arms.

    `grip_bit` is the input bit of the grip switch, by the arm file; the rest can be chosen.
    """

    speed_error: float = speed_error("0.2: motors a fifth slower than the driver's table says")
    grip_bit: int = 0


class StoredProgram:
    """The rows of the program memory, and those that a run has yet to execute."""

    def __init__(self, rows: Iterable[ProgramRow] = ()) -> None:
        self.rows = {row.number: row for row in rows}
        self._left: deque[ProgramRow] = deque()

    @property
    def in_order(self) -> list[ProgramRow]:
        """The rows ordered by number."""
        return [self.rows[number] for number in sorted(self.rows)]

    def keep(self, row: ProgramRow) -> bool:
        """Store a row; return False if the memory is full."""
        if row.number not in self.rows and len(self.rows) >= MEMORY_ROWS:
            return False
        self.rows[row.number] = row
        return True

    def start(self) -> None:
        """Begin a run: the rows that are moves, ordered by number."""
        self._left = deque(row for row in self.in_order if row.kind == MOVE_KIND)

    def next_row(self) -> ProgramRow | None:
        """Return the next row of the run; None after the last."""
        return self._left.popleft() if self._left else None

    def stop(self) -> None:
        """End the run."""
        self._left.clear()


@dataclass(frozen=True, slots=True)
class SavedTeachMover:
    """What is saved of the controller; `memory` holds the words of each row."""

    key: Key
    memory: tuple[tuple[int, ...], ...]
    outputs: int = setting(low=0, high=255)


class TeachMoverBoard(Board):
    """The controller box with its pendant, and the arm.

    Everything it stores is lost with the power.
    """

    title: ClassVar[str] = "TeachMover"
    saved_as = SavedTeachMover
    drive: CoordinatedDrive

    def __init__(
        self,
        world: World | None = None,
        quirks: TeachMoverQuirks | None = None,
        *,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        super().__init__(world, CoordinatedDrive(world), baud)
        self.quirks = quirks or TeachMoverQuirks()
        self.forget()

    def forget(self) -> None:
        """Clear the program, the outputs and any unanswered command."""
        self.memory = StoredProgram()
        self.key = Key.NONE
        """The pendant key pressed last."""
        self.outputs = 0
        self.lost_bytes = 0
        self.unanswered: Command | None = None
        """The command that is being carried out."""
        self._lines = LineSplitter(CR)

    # The saved world.

    def known(self) -> SavedTeachMover:
        """Return the key, the outputs and the program."""
        rows = tuple(row.words for row in self.memory.in_order)
        return SavedTeachMover(self.key, rows, self.outputs)

    def recall_known(self, saved: SavedTeachMover) -> None:
        """Restore what `known` returned. Raises `StateFileError`."""
        self.key, self.outputs = saved.key, saved.outputs
        try:
            self.memory = StoredProgram(map(ProgramRow.from_words, saved.memory))
        except ProtocolError as error:
            raise unfit(f"the words of a saved program row cannot be read: {error}") from None

    # Observable state.

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered."""
        return self.unanswered is not None

    @property
    def registers(self) -> Motors:
        """The position registers: signed, 16 bits, wrapping."""
        return Motors(wrapped16(count) for count in self.drive.counts)

    @property
    def inputs(self) -> int:
        """The input byte: bits set from outside, and the grip switch."""
        grip = 1 << self.quirks.grip_bit
        return self.inputs_set & ~grip | (grip if self.world.grip_switch else 0)

    def details(self) -> dict[str, Json]:
        """Return the pendant's key, the outputs and the speed error."""
        error = self.quirks.speed_error
        return {"key": self.key.name, "outputs": self.outputs, "speed_error": error}

    # Actions of a person.

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit. The grip switch's own bit follows only the fingers."""
        if bit == self.quirks.grip_bit:
            raise BadRequest(f"input {bit + 1} is the grip switch, which the fingers close")
        super().set_input(bit, on)

    def press_named(self, name: str) -> None:
        """Press a key of the pendant by its name, in any case. Raises `BadRequest`."""
        names = [key.name for key in Key if key is not Key.NONE]
        if name.upper() not in Key.__members__:
            raise BadRequest(f"the pendant has no key {name!r}; it has {', '.join(names)}")
        self.press(Key[name.upper()])

    def press(self, key: Key) -> None:
        """Press a key of the pendant. STOP ends a motion, a program and the pendant's control."""
        if self.powered:
            self.key = key
            if key is Key.STOP and self.busy:
                self.drive.stop(self.now_s)
                self.memory.stop()
                self._answer(Status.STOPPED)

    def return_control(self) -> bool:
        """Answer the host's @SET. Returns False if the host has control already."""
        waits = isinstance(self.unanswered, Set)
        if waits:
            self._answer(Status.DONE)
        return waits

    # How the controller handles commands.

    def receive(self, data: bytes) -> None:
        """Receive bytes. Those that arrive while a command is unanswered are lost."""
        for line in data.splitlines(keepends=True):
            if self.busy:
                self.lost_bytes += len(line)
            else:
                self._lines.feed(line)
                self._serve()

    def motion_ended(self) -> None:
        """Continue the running program, or answer."""
        if not self._begin_next_row():
            self._answer(Status.DONE)

    def _serve(self) -> None:
        while (line := self._lines.next_line()) is not None:
            command = self._read(line)
            if isinstance(command, Status):
                self._answer(command)
            elif command is not None:
                self.unanswered = command
                self._do(command)

    def _read(self, line: bytes | Unreadable) -> Command | Status | None:
        """Return the command of a line, or a refusal; None if the line is for no TeachMover.

        That a real arm ignores lines without its attention character is unverified.
        """
        text = (line.data if isinstance(line, Unreadable) else line).lstrip(NOISE)
        if not text.startswith(ATTENTION.encode("ascii")):
            return None
        if isinstance(line, Unreadable):
            return Status.FAILED
        try:
            return decode_command(text[1:])
        except RemoteProtocolError:
            return Status.FAILED

    def _do(self, command: Command) -> None:
        match command:
            case Step(speed, steps, output):
                self.outputs = self.outputs if output is None else output
                self.drive.start(steps, self._rate_hz(speed), self.now_s)
            case Close(speed):
                slow = CLOSE_RATE_HZ / (1.0 + self.quirks.speed_error)
                rate = slow if speed is None else self._rate_hz(speed)
                self.drive.start(self.world.steps_to_trip(), rate, self.now_s)
            case Run():
                self.memory.start()
                if not self._begin_next_row():
                    self._answer(Status.FAILED)
            case Set():
                pass  # the pendant answers later
            case Read() | QDump():
                self._tell(command)
            case Reset():
                self.drive.set_counts(STILL, self.now_s)
                self.world.cut_current(self.now_s)
                self._answer(Status.DONE)
            case QWrite(row):
                self._answer(Status.DONE if self.memory.keep(row) else Status.FAILED)

    def _begin_next_row(self) -> bool:
        """Begin the next row of the program; return False if none is left."""
        row = self.memory.next_row()
        if row is not None:
            places = zip(row.positions, self.registers, strict=True)
            steps = [wrapped16(goal - at) for goal, at in places]
            self.drive.start(steps, self._rate_hz(row.speed), self.now_s)
        return row is not None

    def _tell(self, command: Read | QDump) -> None:
        self._answer(Status.DONE)
        if isinstance(command, Read):
            self.outgoing += encode_reply(Registers(self.registers, self.key, self.inputs))
        else:
            for row in self.memory.in_order:
                self.outgoing += encode_reply(row)

    def _answer(self, status: Status) -> None:
        self.outgoing += encode_reply(status)
        self.unanswered = None

    def _rate_hz(self, speed: int) -> float:
        return rate_hz(speed, self.quirks.speed_error)


def _make(config: ArmConfig, world: World, quirks: TeachMoverQuirks) -> TeachMoverBoard:
    device: TeachMoverSettings = config.device
    quirks = replace(quirks, grip_bit=device.grip_bit)
    return TeachMoverBoard(world, quirks, baud=config.connection.baud)


KIND = SimDeviceKind(TeachMoverBoard, _make, TeachMoverQuirks)
