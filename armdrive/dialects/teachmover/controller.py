"""The driver's end of the TeachMover dialect: it turns requests into lines, and reads the answers.

A burst is one `@STEP`. Nothing can end it early, and its answer comes when the motion has ended.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    ScriptRunner,
    StopPart,
    Stopping,
    answer_without_device,
)
from armdrive.dialects.exchange import Script
from armdrive.dialects.speed_table import SpeedMeter, SpeedTable
from armdrive.dialects.teachmover.settings import TeachMoverSettings
from armdrive.tasks import (
    DeviceProgram,
    Done,
    DropCurrent,
    Interrupted,
    MoveBy,
    ReadPosition,
    ReadProgram,
    Registers,
    Reply,
    Request,
    RequestRejected,
    SetOutputs,
    WriteRow,
)
from firmware_protocol.teachmover import (
    MAX_ROWS,
    Command,
    Completed,
    Host,
    Key,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Reset,
    Status,
    Step,
    Stray,
    Unreadable,
)
from firmware_protocol.teachmover import Registers as RegistersRead
from firmware_protocol.teachmover.host import Event as HostEvent
from kinematics.spaces import Motors

# Characters of the longest row of a program; a CR takes the place of the last comma.
LONGEST_ROW = len("-32768," * 8)
# A dump that takes this many times as long as the longest possible one is no dump.
OVERLONG_FACTOR = 2.0

LONGEST_LINE = len("@STEP 245,-32768,-32768,-32768,-32768,-32768,-32768,255\r")
ANSWER = len("1\r")
LONGEST_REGISTERS = len("1\r-32768,-32768,-32768,-32768,-32768,-32768,65535\r")
STILL = (0, 0, 0, 0, 0, 0)

HARMLESS = "a line that moves no arm"
# Makes an Armdroid harmless that was taken for a TeachMover.
#
# An Armdroid reads letters, not lines, and the D of `@READ` would repeat the last motion of five of
# its motors. In this line, `25s` sets a slow speed and clears the Armdroid's accumulator, and the
# first `d` clears its index. The five commas write zeros over the numbers of that motion, so that
# the last `d` moves every motor by zero steps. A TeachMover does not understand the line and
# answers `0`.
HARMLESS_LINE = b"@25sd,,,,,d\r"

# Timeout for the answer to the first line, beyond its time on the wire.
CONTACT_S = 0.25


class TeachMoverController(ScriptRunner[HostEvent]):
    """The driver's view of one TeachMover."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: TeachMoverSettings = config.device
        self._host = Host()
        super().__init__(abilities, self._host)
        self._settings = settings
        self._byte_s = config.connection.byte_s
        self._table = SpeedTable(settings.speed_table)
        self._meter = SpeedMeter(self._table, settings.speed_margin)
        self._outputs: int | None = None
        self._contacted = False

    def script(self, request: Request) -> Script[HostEvent, Reply]:
        """Send one line and wait for its answer."""
        command = self._command(request)
        if isinstance(command, Reply):
            return command
        if not self._contacted:
            yield from self._make_contact()
        if isinstance(command, QDump):
            return (yield from self._dump())
        return (yield from self._answered(command))

    def _answered(self, command: Command) -> Script[HostEvent, Reply]:
        """Send a command and wait for its one answer, for as long as its motion may last."""
        data = self._host.send(command)
        began_s = self.io.now_s
        self.io.write(data, data.decode("ascii").strip())
        motion_s = timeout_s = 0.0
        if isinstance(command, Step):
            busiest = max(map(abs, command.steps))
            motion_s = busiest / self._table.rate_hz(command.speed)
            timeout_s = self._meter.timeout_s(busiest, command.speed)
        answer = LONGEST_REGISTERS if isinstance(command, Read) else ANSWER
        wire_s = (len(data) + answer) * self._byte_s
        until_s = began_s + timeout_s + wire_s + self._settings.answer_margin_s
        message = yield from self.io.wait_for(until_s, lambda event: isinstance(event, Completed))
        if not isinstance(message, Completed):
            self.give_up()
            return self.io.silence(began_s)
        if message.status is Status.STOPPED:
            return Interrupted()
        if message.status is Status.FAILED:
            return RequestRejected()
        if message.registers is not None:
            return self._registers(message.registers)
        return Done(self._plausible(command, motion_s, self.io.now_s - began_s - wire_s))

    def _dump(self) -> Script[HostEvent, Reply]:
        """Read the program in the arm's memory. One unreadable row makes all of it invalid.

        Nothing marks the end of a dump, so it ends when no byte has come for longer than a row
        takes.
        """
        io, host, began_s = self.io, self._host, self.io.now_s
        row_s = LONGEST_ROW * self._byte_s
        pause_s = row_s + self._settings.answer_margin_s
        last_s = began_s + pause_s + MAX_ROWS * row_s * OVERLONG_FACTOR
        data = host.send(QDump())
        io.write(data, data.decode("ascii").strip())
        events: list[HostEvent] = []
        while not any(isinstance(each, Completed) for each in events):
            until_s = min(max(io.heard_s, began_s) + pause_s, last_s)
            if io.now_s >= until_s:
                break
            event = yield until_s
            if event is not None:
                events.append(event)
        if host.dumping:
            events += host.end_dump()
        bad = [each.reason for each in events if isinstance(each, Unreadable)]
        ended = next((each for each in events if isinstance(each, Completed)), None)
        if ended is None:
            self.give_up()
            return io.silence(began_s)
        if bad:
            return RequestRejected(f"the arm's program cannot be read: {bad[0]}", moved=False)
        if ended.status is not Status.DONE:
            return RequestRejected("the arm does not send its program", moved=False)
        return DeviceProgram(tuple(row.words for row in ended.rows))

    def _make_contact(self) -> Script[HostEvent, None]:
        """Send the first line, and wait for its answer: a `0`, or nothing at all."""
        self._contacted = True
        self.io.write(HARMLESS_LINE, HARMLESS)
        until_s = self.io.now_s + (len(HARMLESS_LINE) + len("0\r")) * self._byte_s + CONTACT_S
        yield from self.io.wait_for(until_s, lambda event: isinstance(event, Stray))
        self.give_up()

    def give_up(self) -> None:
        """Give up on the unanswered command."""
        self._host.give_up()
        self._host.discard()

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate of the fastest setting not above `rate_hz`, or of the slowest one."""
        return self._table.rate_hz(self._table.setting(rate_hz))

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long these steps take if the arm is as slow as it may be."""
        return self._meter.longest_s(steps, self._table.setting(rate_hz))

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound the motion after a stop: a line on the wire and its burst, which nothing ends."""
        sent_s = HOST_DELAY_S + LONGEST_LINE * self._byte_s
        return self.whole_burst(burst_s, parts, sent_s)

    def _plausible(self, command: Command, motion_s: float, moved_s: float) -> bool:
        """Learn the arm's speed from a command; return False if its duration is impossible."""
        if not isinstance(command, Step):
            return True
        return not self.io.overdue and self._meter.part(command.speed).learn(motion_s, moved_s)

    def _command(self, request: Request) -> Command | Reply:
        match request:
            case MoveBy(steps, rate_hz):
                return Step(self._table.setting(rate_hz), tuple(steps), self._outputs)
            case ReadPosition():
                return Read()
            case SetOutputs(bits):
                step = Step(self._table.points[0][0], STILL, bits)
                self._outputs = bits
                return step
            case DropCurrent():
                return Reset()
            case ReadProgram():
                return QDump()
            case WriteRow(words):
                return QWrite(ProgramRow.from_words(words))
            case _:  # the next motion switches its motors on
                return answer_without_device(request)

    def _registers(self, read: RegistersRead) -> Registers:
        return Registers(
            Motors(read.positions),
            read.inputs,
            gripping=bool(read.inputs >> self._settings.grip_bit & 1),
            key=read.key.name if isinstance(read.key, Key) else str(read.key),
        )


DRIVER = Driver(TeachMoverSettings, TeachMoverController)
