"""The controller box of a simulated TeachMover: what it does with each command, until power is cut.

One command is unanswered at a time. A motion's end answers it (`motion_ended`), the pendant can
(`stop_key`, `give_back`), and everything else is answered at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.errors import StateFileError
from armdrive.sim.device import DeviceBox, DeviceClock
from armdrive.sim.mechanics.motors import DEFAULT_RATES, CoordinatedDrive, RateTable, rate_hz
from armdrive.sim.world.saved import MEND, Json, Saved
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

MEMORY_ROWS = 50
CLOSE_RATE_HZ = 277.0
"""Closing over the full 76 mm takes about 4 s."""
STILL = (0, 0, 0, 0, 0, 0)
_MOVE_KIND = 1
_WORD = 1 << 16
_HALF = 1 << 15


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


class ControllerBox(DeviceBox):
    """Commands in, answers out, motors turned: everything that is forgotten without power.

    Answers are appended to `said`; `inputs_set` tells the input bits as they are set from outside.
    """

    _drive: CoordinatedDrive

    def __init__(
        self,
        drive: CoordinatedDrive,
        clock: DeviceClock,
        settings: TwinSettings,
        said: bytearray,
        inputs_set: Callable[[], int],
    ) -> None:
        self.clock = clock
        self.settings = settings
        self.said = said
        self.memory: dict[int, ProgramRow] = {}
        self._inputs_set = inputs_set
        self._drive = drive
        self._rows: deque[ProgramRow] = deque()
        self.forget()

    def forget(self) -> None:
        """Lose the program, the outputs and whatever is unanswered."""
        self.memory.clear()
        self.last_key = Key.NONE
        self.outputs = 0
        self.byte_gap_s = 0.0
        self.lost_bytes = 0
        self._codec = Device()
        self._rows.clear()

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered."""
        return self._codec.unanswered is not None

    @property
    def registers(self) -> Motors:
        """The position registers: signed 16 bit, wrapping."""
        return Motors(signed(count) for count in self._drive.counts)

    @property
    def inputs(self) -> int:
        """The input byte: what was set from outside, and the grip switch."""
        grip = 1 << self.settings.grip_bit
        return self._inputs_set() & ~grip | (grip if self._drive.world.grip_switch else 0)

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

    def known(self) -> dict[str, Json]:
        """Return the key pressed last, the outputs and the program."""
        return {
            "key": int(self.last_key),
            "outputs": self.outputs,
            "memory": [list(self.memory[number].words) for number in sorted(self.memory)],
        }

    def recall_known(self, saved: Saved) -> None:
        """Know what `known` wrote; raises `StateFileError`."""
        key = Key(saved.whole("key", 0, max(Key)))
        outputs = saved.whole("outputs", 0, _BYTE)
        rows = [_row(item) for item in saved.items("memory")]
        self.last_key, self.outputs = key, outputs
        self.memory.update((row.number, row) for row in rows)

    def stop_key(self) -> None:
        """End a motion, a program or the pendant's control where it is."""
        if self.busy:
            self._drive.stop(self.clock.now_s)
            self._rows.clear()
            self._answer(Status.STOPPED)
            self._serve()

    def give_back(self) -> bool:
        """End the pendant's control; False where the pendant has none."""
        if not isinstance(self._codec.unanswered, Set):
            return False
        self._answer(Status.DONE)
        self._serve()
        return True

    def _serve(self) -> None:
        while (request := self._codec.next_event()) is not None:
            self._do(request)

    def _do(self, request: Request) -> None:
        match request:
            case Step(speed, steps, output):
                self.outputs = self.outputs if output is None else output
                self._drive.start(steps, self._rate_hz(speed), self.clock.now_s)
            case Close(speed):
                self._close(speed)
            case Run():
                self._run()
            case Set() | Ignored():
                pass  # the pendant answers the one in its own time, nobody the other
            case Read() | QDump():
                self._tell(request)
            case Reset():
                self._drive.set_counts(STILL, self.clock.now_s)
                self._drive.world.cut_current(self.clock.now_s)
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
        self._drive.start(self._drive.world.steps_to_trip(), rate, self.clock.now_s)

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
        self._drive.start(steps, self._rate_hz(row.speed), self.clock.now_s)

    def _tell(self, request: Read | QDump) -> None:
        self._answer(Status.DONE)
        if isinstance(request, Read):
            self.said += self._codec.send(Registers(self.registers, self.last_key, self.inputs))
        else:
            for number in sorted(self.memory):
                self.said += self._codec.send(self.memory[number])

    def _keep(self, row: ProgramRow) -> bool:
        if row.number not in self.memory and len(self.memory) >= MEMORY_ROWS:
            return False
        self.memory[row.number] = row
        return True

    def _answer(self, status: Status) -> None:
        self.said += self._codec.send(status)

    def _rate_hz(self, speed: int) -> float:
        return rate_hz(self.settings.speed_table, speed, self.settings.speed_error)


def signed(count: int) -> int:
    """Wrap a count as a signed 16-bit register does."""
    return (count + _HALF) % _WORD - _HALF


_LARGEST_WORD = (1 << 16) - 1
_BYTE = 255
_ROW_WORDS = 8


def _row(words: object) -> ProgramRow:
    row = Saved({"words": words}, "program").wholes("words", _ROW_WORDS, 0, _LARGEST_WORD)
    try:
        return ProgramRow.from_words(row)
    except ProtocolError as error:
        raise StateFileError(f"a saved program row cannot be read: {error}; {MEND}") from None
