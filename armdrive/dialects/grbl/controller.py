"""The driver's end of the GRBL dialect: it turns requests into lines and reports into replies.

    a request   `script` makes contact if necessary, and picks the collaborator that carries it out
    bytes       the codec decodes messages; the running script receives each from
                `GrblExchange.listen`, and `unsolicited` the others; both update `BoardState`
    a stop      `stop_asked` is set; the script that moves the arm notices and calls `GrblStops`
    a deadline  the script is resumed without a message

Sources: gnea/grbl doc/markdown/interface.md, commands.md, jogging.md, settings.md.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import BITS_A_BYTE, Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    HomingTime,
    ScriptRunner,
    Search,
    StopPart,
    Stopping,
    in_turn,
)
from armdrive.dialects.exchange import TRIES, Script
from armdrive.dialects.grbl.board import BoardState
from armdrive.dialects.grbl.contact import GrblContact
from armdrive.dialects.grbl.exchange import GrblExchange, refusal
from armdrive.dialects.grbl.motion import GrblHoming, GrblMotion
from armdrive.dialects.grbl.planner import InFlightLines, MotionBounds
from armdrive.dialects.grbl.settings import (
    BoardAxes,
    Comparison,
    GrblSettings,
)
from armdrive.dialects.grbl.stops import GrblOutputs, GrblStops
from armdrive.errors import Refused
from armdrive.tasks import (
    ClearFault,
    DeviceSettings,
    DropCurrent,
    FixSetting,
    HomeDevice,
    MeasureUnits,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadProgram,
    ReadSettings,
    Reply,
    Request,
    RequestRejected,
    SetGripper,
    SetOutputs,
    SwitchOn,
    WriteRow,
)
from firmware_protocol.grbl import (
    Acknowledged,
    Dialect,
    Home,
    Host,
    Line,
    SystemCommand,
    keys,
)
from firmware_protocol.grbl.host import Event as HostEvent

# A line that writes a setting, on FluidNC also by its path. Other lines that begin with $ jog,
# home or store a motion.
SETTING = r"\$([0-9]+|/[a-z0-9_/]+)=[0-9.]+"
# Timeout for writing a setting to the board's EEPROM.
SETTING_WRITE_S = 2.0


class GrblController(ScriptRunner[HostEvent]):
    """The driver's view of one GRBL board; it passes each request to a collaborator.

    `limits` are the limits of the axes: the arm file's until the board's settings have been read.
    `searches_s` are how long each motor homes at most, in s; None if these settings do not say so.
    """

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: GrblSettings = config.device
        axes = BoardAxes.of(config)
        host = Host(Dialect(axes=axes.board()))
        super().__init__(replace(abilities, motors=len(axes.letters)), host)
        self.settings = settings
        self.axes = axes
        self.limits = axes.expected(settings)
        self.searches_s: tuple[float | None, ...] = (None,) * len(axes.letters)
        self.byte_s = BITS_A_BYTE / config.connection.baud
        self.board = board = BoardState(host, settings, axes)
        self.exchange = exchange = GrblExchange(self.io, host, board, settings, self.byte_s)
        self.outputs = GrblOutputs(exchange, config.gripper.kind)
        self.stops = stops = GrblStops(
            self.io, exchange, board, self.outputs, settings, lambda: self.bounds.slowest_stop_s
        )
        self.contact = GrblContact(self.io, exchange, board, stops, settings)
        self.homing = GrblHoming(
            self.io, exchange, board, self.contact, axes.letters, self.homing_time
        )

    # -- what happens -------------------------------------------------------------------------

    def script(self, request: Request) -> Script[HostEvent, Reply]:
        """Carry out a request, making contact with the board first if necessary."""
        match request:
            case SetOutputs(bits):
                self.outputs.check(bits)
            case FixSetting(line) if not re.fullmatch(SETTING, line):
                raise Refused(f"`{line}` is not a GRBL setting: write one like `$100=250`")
        return self._carry_out(request)

    def _carry_out(self, request: Request) -> Script[HostEvent, Reply]:
        if not self.board.contacted:
            yield from self.contact.make()
        if isinstance(request, MoveBy):
            request = MoveAlong(iter((request,)), math.inf)
        match request:
            case MoveAlong():
                yield from self.contact.prepare()
                return (yield from self._motion(request).drive())
            case ReadPosition():
                return (yield from self.exchange.read_position())
            case ReadSettings():
                return (yield from self._compare())
            case FixSetting(line):
                return (yield from self.exchange.carry_out(Line(line), SETTING_WRITE_S))
            case SetOutputs(bits):
                return (yield from self.outputs.set(bits))
            case SetGripper(share):
                return (yield from self.outputs.set_gripper(share))
            case DropCurrent():
                return (yield from self.exchange.carry_out(SystemCommand.SLEEP))
            case HomeDevice(groups):
                return (yield from self.homing.home(groups))
            case SwitchOn() | ClearFault():
                return (yield from self.contact.clear())
            case ReadProgram() | WriteRow() | MeasureUnits():
                words = "a GRBL board has no program memory, and its units are known"
                return RequestRejected(words, moved=False)

    def _motion(self, request: MoveAlong) -> GrblMotion:
        """Return a motion from where the board stands."""
        bounds, settings, board = self.bounds, self.settings, self.board
        start = board.registers().positions
        lines = InFlightLines(start, bounds.limits, settings.following_error_steps, bounds.segments)
        return GrblMotion(
            self.io, self.exchange, board, self.stops, settings, self.axes, bounds, request, lines
        )

    def _compare(self) -> Script[HostEvent, Reply]:
        """Read the settings until they are complete, and learn the axes' actual limits."""
        board, began_s = self.board, self.io.now_s
        reported = board.reported_settings
        unlisted = board.behaviour.unlisted(self.axes.letters if self.settings.homing else "")
        for _ in range(TRIES):
            reported.clear()
            message = yield from self.exchange.ask(SystemCommand.QUERY_SETTINGS)
            if not isinstance(message, Acknowledged):
                continue
            for path in unlisted:
                yield from self.exchange.ask(Line(f"${path}"))
            found = Comparison(
                self.settings, self.axes, board.letters, dict(reported), board.behaviour
            )
            if found.number(keys.IDLE_MS) is not None:
                break
        if message is None:
            return self.io.silence(began_s)
        if not isinstance(message, Acknowledged):
            return refusal(message, "the settings could not be read")
        self.limits, self.searches_s = found.limits(), found.searches_s()
        return DeviceSettings(tuple(found.differences()), self.board.firmware_words())

    def unsolicited(self, message: HostEvent) -> None:
        """Learn from a message that no script waits for."""
        self.exchange.take(message)

    def give_up(self) -> None:
        """Forget unanswered lines and a half-received message."""
        self.exchange.give_up()

    @property
    def opening_reset(self) -> bool:
        """Whether opening the port has reset the board: it greets after that."""
        return self.board.greeted_first

    # -- numbers ------------------------------------------------------------------------------

    @property
    def underruns(self) -> int:
        """How often the board ran out of lines in the middle of a motion."""
        return self.board.underruns

    @property
    def bounds(self) -> MotionBounds:
        """The bounds of the board's motion, as far as they are known now."""
        return MotionBounds(self.limits, self.axes.most_hz, self.board.segment_buffer, self.byte_s)

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate, limited to what the board can do without pausing between steps."""
        return self.bounds.usable_rate_hz(rate_hz)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return the time the slowest axis takes for these steps, from rest to rest."""
        return self.bounds.duration_s(steps, rate_hz)

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound how long motion continues after a stop or after the host falls silent."""
        return self.bounds.stopping(burst_s, parts)

    def search(self, request: HomeDevice) -> Search:
        """Bound the homing command under way: it goes on to its end, whatever the host does."""
        times = list(map(self.homing_time, self.homing.commands(request.groups)))
        return Search(max(times).s + HOST_DELAY_S, lasts=in_turn(times))

    def homing_time(self, command: Home) -> HomingTime:
        """Return how long the homing of one axis lasts."""
        search_s = self.searches_s[self.axes.letters.index(command.axes)]
        if search_s is None:
            return HomingTime(self.settings.homing_s, "grbl.homing_s")
        return HomingTime(search_s)


DRIVER = Driver(GrblSettings, GrblController)
