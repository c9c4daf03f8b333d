"""The Armdroid controller: turns the driver's requests into the sketch's commands.

A burst is one `D` command. Nothing ends it early, the board answers when the motion has ended, and
there is no checksum: a lost comma would merge two numbers. So the driver sends the numbers first
and has the board repeat them (`g`); only then does it send the letter that starts the motion. The
driver never sends `h`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from armdrive.abilities import Abilities, Switching
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.armdroid.exchange import BoardExchange
from armdrive.dialects.armdroid.settings import ArmdroidSettings
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    ScriptRunner,
    StopPart,
    Stopping,
    answer_without_device,
)
from armdrive.dialects.exchange import TRIES, Obstructed, Script, ScriptIO, T
from armdrive.dialects.speed_table import SpeedMeter, SpeedTable
from armdrive.tasks import (
    Alert,
    AlertKind,
    ClearFault,
    DeviceSettings,
    Done,
    DropCurrent,
    Halted,
    MoveBy,
    ReadPosition,
    ReadSettings,
    Registers,
    Reply,
    Request,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.armdroid import (
    DriveAll,
    Host,
    OffsetsReported,
    SpeedReported,
    Stray,
    Torque,
    TorqueReported,
    Welcome,
)
from firmware_protocol.armdroid.endpoints import Event as HostEvent
from firmware_protocol.armdroid.messages import encode_answer, encode_command
from firmware_protocol.fields import wrapped16
from kinematics.spaces import Motors

NEW_SESSION = (
    "the Armdroid's board sent its greeting: it was reset, or another program has opened its port"
)
LET_GO = "the Armdroid's board reported its motors off, although no command had switched them off"


@dataclass(frozen=True, slots=True, eq=False)
class ArmdroidMotion:
    """Loads each motion's numbers into the board, starts it, and waits for its end."""

    io: ScriptIO[HostEvent]
    board: BoardExchange
    table: SpeedTable
    meter: SpeedMeter

    def move(
        self, drive: DriveAll, rpm: int, released: Callable[[], bool]
    ) -> Script[HostEvent, Reply]:
        """Make a motion; if a stop is requested before its letter is sent, nothing moves."""
        start = self.board.offsets if self.board.clean else (yield from self.board.look())
        if start is None or not (yield from self.board.set_speed(rpm)):
            return RequestRejected("it does not answer as it should", moved=False)
        letter = yield from self._load(drive, rpm, released)
        if not isinstance(letter, bytes):
            return letter
        sent_s, expected = self.io.now_s, _sum(start, drive.steps)
        self.board.let_loose(letter, encode_command(drive).decode("ascii"))
        timeout_s = self.meter.timeout_s(Motors(drive.steps).largest, rpm)
        came = yield from self.board.offsets_after(expected, timeout_s)
        if came is None:
            return self.io.silence(sent_s)
        if came != expected:
            return RequestRejected(
                f"its offsets went from {start} to {came}, but {expected} was requested"
            )
        took_s = self.io.now_s - sent_s
        moved_s = took_s - self.board.taking_s(len(letter)) - self._answer_s(expected)
        return Done(self._measure(drive, rpm, moved_s))

    def _load(
        self, drive: DriveAll, rpm: int, released: Callable[[], bool]
    ) -> Script[HostEvent, bytes | RequestRejected | Halted]:
        """Load a motion's numbers into the board; return the letter that starts it."""
        understood = None
        for _ in range(TRIES):
            data = self.board.begin_drive(drive)
            understood = yield from self.board.repeated(data[:-1])  # all but the letter
            if self.io.stop_asked or released():
                self.board.give_up()
                return Halted()
            if understood == drive.steps and self.board.rpm == rpm:
                return data[-1:]
            self.board.give_up()
            settled = yield from self.board.settle()
            if settled is None or not (yield from self.board.set_speed(rpm)):
                break
        return RequestRejected(
            f"it repeats {drive.steps} as {understood or 'nothing'}", moved=False
        )

    def _measure(self, drive: DriveAll, rpm: int, moved_s: float) -> bool:
        """Learn the arm's speed; return False if the duration is not plausible.

        The motors make their first step at once, so n steps take n - 1 intervals.
        """
        intervals_s = (Motors(drive.steps).largest - 1) / self.table.rate_hz(rpm)
        return not self.io.overdue and self.meter.part(rpm).learn(intervals_s, moved_s)

    def _answer_s(self, offsets: tuple[int, ...]) -> float:
        """Return how long the answer to a motion is on the wire."""
        return len(encode_answer(OffsetsReported(offsets))) * self.board.byte_s


class ArmdroidController(ScriptRunner[HostEvent]):
    """One Armdroid, seen from the driver."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: ArmdroidSettings = config.device
        if not settings.switches_torque:
            abilities = replace(abilities, current=Switching.NONE)
        abilities = replace(abilities, resets_on_open=settings.boot_s > 0.0)
        host = Host()
        super().__init__(abilities, host)
        self._settings = settings
        self._table = SpeedTable(settings.speed_table, interpolated=False)
        self._meter = SpeedMeter(self._table, settings.speed_margin)
        self._board = BoardExchange(self.io, host, settings, config.connection.byte_s)
        self._motion = ArmdroidMotion(self.io, self._board, self._table, self._meter)

    def script(self, request: Request) -> Script[HostEvent, Reply]:
        """Carry out a request; commands that are safe to repeat are retried."""
        board, switches = self._board, self._settings.switches_torque
        match request:
            case MoveBy(steps, rate_hz):
                drive = DriveAll(_by_channel(self._settings.channels, steps))
                rpm = self._table.setting(rate_hz)
                return (yield from self._motion.move(drive, rpm, request.released))
            case ReadPosition():
                return self._registers((yield from self._answered(board.look())))
            case SwitchOn() if switches:
                yield from self._answered(board.ensure(Torque(on=True)))
                # if the line doubled the `t`, the board has switched the motors off again, which
                # it has reported once it has answered the next question
                yield from self._answered(board.look())
                return Done()
            case DropCurrent() if switches:
                yield from self._answered(board.ensure(Torque(on=False)))
                return Done()
            case ClearFault():
                yield from self._answered(board.settle())
                return Done()
            case ReadSettings():
                if not board.firmware:
                    yield from self._answered(board.settle())
                return DeviceSettings(firmware=board.firmware)
            case _:
                return answer_without_device(request)

    def unsolicited(self, event: HostEvent) -> None:
        """Report an unexpected line; `Welcome` means a restart once the board has answered."""
        if isinstance(event, Welcome) and self._board.firmware:
            self._board.forget_session()
            self.io.notify(Alert(AlertKind.RESTARTED, NEW_SESSION))
        else:
            if isinstance(event, Stray) and isinstance(event.answer, SpeedReported):
                self._board.rpm = event.answer.rpm
            if isinstance(event, Stray) and event.answer == TorqueReported(on=False):
                self.io.notify(Alert(AlertKind.SWITCHED_OFF, LET_GO))
            super().unsolicited(event)

    @property
    def opening_reset(self) -> bool:
        """Whether opening the port may have reset the board: it is deaf after that."""
        return super().opening_reset and self._board.was_deaf

    def give_up(self) -> None:
        """Give up on the unanswered command."""
        self._board.give_up()

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the highest available rate at or below `rate_hz`, or else the lowest one."""
        return self._table.rate_hz(self._table.setting(rate_hz))

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return the longest time that the steps may take, allowing for a slow arm."""
        return self._meter.longest_s(steps, self._table.setting(rate_hz))

    def deviation_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:  # noqa: ARG002
        """Bound each motor's lead over its share of the path.

        All turn at the same rate, so one with few steps ends early, and the path bends.
        """
        most = max(steps.largest, 1)
        return tuple(abs(each) * (1.0 - abs(each) / most) for each in steps)

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Assume a whole burst after its letter: nothing ends it early."""
        sent_s = self._board.taking_s(len(DriveAll.letter)) + HOST_DELAY_S
        return self.whole_burst(burst_s, parts, sent_s)

    # -- scripts ------------------------------------------------------------------------------

    def _answered(self, script: Script[HostEvent, T | None]) -> Script[HostEvent, T]:
        """Return what a script returns. Raises `Obstructed` if the board does not answer."""
        began_s = self.io.now_s
        found = yield from script
        if found is None:
            raise Obstructed(self.io.silence(began_s))
        return found

    def _registers(self, offsets: tuple[int, ...]) -> Registers:
        return Registers(Motors(offsets[channel - 1] for channel in self._settings.channels))


def _sum(offsets: tuple[int, ...], steps: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(wrapped16(at + each) for at, each in zip(offsets, steps, strict=True))


def _by_channel(channels: tuple[int, ...], steps: Motors) -> tuple[int, ...]:
    by_channel = dict(zip(channels, steps, strict=True))
    return tuple(by_channel[channel] for channel in sorted(by_channel))


DRIVER = Driver(ArmdroidSettings, ArmdroidController)
