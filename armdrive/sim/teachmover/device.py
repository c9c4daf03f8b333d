"""A TeachMover that is not there: the device side of its dialect on a simulated physical arm.

Where the real arm's habit is unknown the harsher one is built: bytes that come in while a command
is unanswered are lost, the program memory is lost with the power, and after power-up the motors
are without current until the first motion.

One command is unanswered at a time. A motion's end answers it (`motion_ended`), the pendant can
(`press`, `pendant_returns`), and everything else is answered at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from armdrive.config.arm import ArmConfig
from armdrive.dialects.teachmover.controller import TeachMoverSettings
from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.device import Board, Option, Options
from armdrive.sim.mechanics.motors import (
    DEFAULT_RATES,
    CoordinatedDrive,
    RateTable,
    checked_error,
    rate_hz,
)
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import BYTE, MEND, Form, Json, Saved
from firmware_protocol.errors import ProtocolError
from firmware_protocol.teachmover import (
    Arm,
    Close,
    Delay,
    Device,
    Ignored,
    Key,
    Malformed,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Request,
    Reset,
    Run,
    Set,
    Status,
    Step,
)
from kinematics.spaces import Motors

BAUD = 9600

MEMORY_ROWS = 50
CLOSE_RATE_HZ = 277.0
"""Closing over the full 76 mm takes about 4 s."""
STILL = (0, 0, 0, 0, 0, 0)
_MOVE_KIND = 1
_WORD = 1 << 16
_HALF = 1 << 15
_LARGEST_WORD = _WORD - 1
_ROW_WORDS = 8


@dataclass(frozen=True, slots=True)
class TwinSettings:
    """What is unverified of the real arm, or differs between arms.

    `speed_table` and `speed_error` say how fast the motors really turn (an error of 0.2: a fifth
    longer); `delay_unit_s` is what one count of @DELAY is worth; `grip_bit` is the grip switch's
    input bit. Bytes that come in while a command is unanswered are lost unless
    `keeps_input_while_moving`.
    """

    speed_table: RateTable = DEFAULT_RATES
    speed_error: float = 0.0
    keeps_input_while_moving: bool = False
    delay_unit_s: float = 0.001
    grip_bit: int = 0

    def __post_init__(self) -> None:
        checked_error(self.speed_error)


def _rows_json(memory: dict[int, ProgramRow]) -> Json:
    return [list(memory[number].words) for number in sorted(memory)]


def _saved_rows(saved: Saved, key: str) -> dict[int, ProgramRow]:
    rows = [_row(item) for item in saved.items(key)]
    return {row.number: row for row in rows}


def _row(words: object) -> ProgramRow:
    row = Saved({"words": words}, "program").wholes("words", _ROW_WORDS, 0, _LARGEST_WORD)
    try:
        return ProgramRow.from_words(row)
    except ProtocolError as error:
        raise StateFileError(f"a saved program row cannot be read: {error}; {MEND}") from None


class TeachMoverBoard(Board):
    """The controller box with its pendant, and the arm. What is known is forgotten without power.

    `memory` are the rows of the program by their numbers.
    """

    title: ClassVar[str] = "TeachMover"
    remembered: ClassVar[Mapping[str, Form]] = {
        "key": Form(lambda saved, key: Key(saved.whole(key, 0, max(Key))), int),
        "outputs": BYTE,
        "memory": Form(_saved_rows, _rows_json),
    }
    drive: CoordinatedDrive

    def __init__(
        self,
        world: World | None = None,
        settings: TwinSettings | None = None,
        *,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        super().__init__(world, CoordinatedDrive(world), baud)
        self.settings = settings or TwinSettings()
        self.memory: dict[int, ProgramRow] = {}
        self._rows: deque[ProgramRow] = deque()
        self.forget()

    def forget(self) -> None:
        """Lose the program, the outputs and whatever is unanswered."""
        self.memory.clear()
        self.key = Key.NONE
        self.outputs = 0
        self.byte_gap_s = 0.0
        self.lost_bytes = 0
        self._codec = Device()
        self._rows.clear()

    # What can be seen.

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered."""
        return self._codec.unanswered is not None

    @property
    def registers(self) -> Motors:
        """The position registers: signed 16 bit, wrapping."""
        return Motors(signed(count) for count in self.drive.counts)

    @property
    def inputs(self) -> int:
        """The input byte: what was set from outside, and the grip switch."""
        grip = 1 << self.settings.grip_bit
        return self.shared.inputs_set & ~grip | (grip if self.world.grip_switch else 0)

    @property
    def speed_error(self) -> float:
        """By which share motions last longer than the speed table says."""
        return self.settings.speed_error

    def details(self) -> dict[str, Json]:
        """Return the pendant's key, the outputs, and how wrong the speed is."""
        return {"key": self.key.name, "outputs": self.outputs, "speed_error": self.speed_error}

    # What a person can do.

    def key_names(self) -> tuple[str, ...]:
        """Name the pendant's keys."""
        return tuple(key.name for key in Key if key is not Key.NONE)

    def press_named(self, name: str) -> None:
        """Press a key of the pendant by its name, in capitals or not."""
        wanted = name.upper()
        if wanted not in Key.__members__:
            raise BadRequest(
                f"the pendant has no key {name!r}; it has {', '.join(self.key_names())}"
            )
        self.press(Key[wanted])

    def press(self, key: Key) -> None:
        """Press a key of the pendant: STOP ends a motion, a program and the pendant's control."""
        if not self.shared.powered:
            return
        self.key = key
        if key is Key.STOP and self.busy:
            self.drive.stop(self.now_s)
            self._rows.clear()
            self._answer(Status.STOPPED)
            self._serve()

    def pendant_returns(self) -> bool:
        """Give control back to the host, answering its @SET; False where it has control."""
        if not isinstance(self._codec.unanswered, Set):
            return False
        self._answer(Status.DONE)
        self._serve()
        return True

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit; the grip switch's own bit follows the fingers alone."""
        grip = self.settings.grip_bit
        if not 0 <= bit < self.input_bits or bit == grip:
            raise BadRequest(f"input bits are 0 to 7 without {grip}, the grip switch; not {bit}")
        super().set_input(bit, on)

    def set_speed_error(self, error: float) -> None:
        """Make motions that begin from now on last longer (0.2: a fifth) or shorter (negative)."""
        self.settings = replace(self.settings, speed_error=error)

    # What the controller does with each command.

    def hear(self, data: bytes) -> None:
        """Take bytes; what comes while a command is unanswered is lost, or waits."""
        for line in data.splitlines(keepends=True):
            if self.busy and not self.settings.keeps_input_while_moving:
                self.lost_bytes += len(line)
            else:
                self._codec.receive_data(line)
                self._serve()

    def motion_ended(self) -> None:
        """Go on with the program that runs, or answer."""
        if self._rows:
            self._next_row()
        else:
            self._answer(Status.DONE)
            self._serve()

    def _serve(self) -> None:
        while (request := self._codec.next_event()) is not None:
            self._do(request)

    def _do(self, request: Request) -> None:
        match request:
            case Step(speed, steps, output):
                self.outputs = self.outputs if output is None else output
                self.drive.start(steps, self._rate_hz(speed), self.now_s)
            case Close(speed):
                self._close(speed)
            case Run():
                self._run()
            case Set() | Ignored():
                pass  # the pendant answers the one in its own time, nobody the other
            case Read() | QDump():
                self._tell(request)
            case Reset():
                self.drive.set_counts(STILL, self.now_s)
                self.world.cut_current(self.now_s)
                self._answer(Status.DONE)
            case QWrite(row):
                self._answer(Status.DONE if self._keep(row) else Status.FAILED)
            case Delay(count):
                self._answer(Status.DONE)
                self.byte_gap_s = count * self.settings.delay_unit_s
            case Arm():
                self._answer(Status.DONE)
            case Malformed():
                self._answer(Status.FAILED)

    def _close(self, speed: int | None) -> None:
        slow = CLOSE_RATE_HZ / (1.0 + self.settings.speed_error)
        rate = slow if speed is None else self._rate_hz(speed)
        self.drive.start(self.world.steps_to_trip(), rate, self.now_s)

    def _run(self) -> None:
        """Begin the program: its rows in the order of their numbers, those that are moves."""
        rows = (self.memory[number] for number in sorted(self.memory))
        self._rows.extend(row for row in rows if row.kind == _MOVE_KIND)
        if self._rows:
            self._next_row()
        else:
            self._answer(Status.FAILED)

    def _next_row(self) -> None:
        row = self._rows.popleft()
        steps = [signed(goal - at) for goal, at in zip(row.positions, self.registers, strict=True)]
        self.drive.start(steps, self._rate_hz(row.speed), self.now_s)

    def _tell(self, request: Read | QDump) -> None:
        self._answer(Status.DONE)
        if isinstance(request, Read):
            self.shared.said += self._codec.send(Registers(self.registers, self.key, self.inputs))
        else:
            for number in sorted(self.memory):
                self.shared.said += self._codec.send(self.memory[number])

    def _keep(self, row: ProgramRow) -> bool:
        if row.number not in self.memory and len(self.memory) >= MEMORY_ROWS:
            return False
        self.memory[row.number] = row
        return True

    def _answer(self, status: Status) -> None:
        self.shared.said += self._codec.send(status)

    def _rate_hz(self, speed: int) -> float:
        return rate_hz(self.settings.speed_table, speed, self.settings.speed_error)


def signed(count: int) -> int:
    """Wrap a count as a signed 16-bit register does."""
    return (count + _HALF) % _WORD - _HALF


def _make(config: ArmConfig, world: World, options: Options) -> TeachMoverBoard:
    device: TeachMoverSettings = config.device
    settings = TwinSettings(grip_bit=device.grip_bit, **options.values)
    return TeachMoverBoard(world, settings, baud=config.connection.baud)


KIND = SimDeviceKind(
    title="TeachMover",
    board=TeachMoverBoard,
    make=_make,
    options=(
        Option("speed_error", 0.0, "0.2: motors a fifth slower than the driver's table says"),
        Option("keeps_input_while_moving", False, "keeps what comes in during a motion"),
        Option("delay_unit_s", 0.001, "seconds that one count of @DELAY is worth"),
    ),
)
