"""The driver's end of the GRBL dialect: neutral requests to lines, reports to replies.

    a request   `script` picks the collaborator that carries it out, after contact was made
    bytes       the codec reads events; the running script gets each from `GrblExchange.listen`, or
                `unasked` where none runs or waits; both have `BoardState` learn from it first
    a stop      `stop_asked` is set; the script that moves the arm sees it and asks `GrblStops`
    time        the script goes on when what it waits for has not come by then

Sources: gnea/grbl doc/markdown/interface.md, commands.md, jogging.md, settings.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import ScriptRunner, StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.dialects.exchange import BITS_A_BYTE
from armdrive.dialects.grbl.board import BoardState
from armdrive.dialects.grbl.contact import GrblContact
from armdrive.dialects.grbl.exchange import Answering, GrblExchange, refusal
from armdrive.dialects.grbl.motion import GrblHoming, GrblMotion
from armdrive.dialects.grbl.planner import MotionBounds
from armdrive.dialects.grbl.settings import BoardAxes, Comparison, GrblSettings, idle_key
from armdrive.dialects.grbl.stops import GrblOutputs, GrblStops
from armdrive.errors import Refused
from armdrive.tasks import (
    ClearFault,
    DeviceSettings,
    DropCurrent,
    HomeDevice,
    MendSetting,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadProgram,
    ReadSettings,
    Request,
    RequestRejected,
    SetGripper,
    SetOutputs,
    SwitchOn,
    WriteRow,
)
from firmware_protocol.grbl import Acknowledged, Dialect, Host, Line, QuerySettings, Sleep
from firmware_protocol.grbl.host import Event as HostEvent

TRIES = 3
"""How often the settings are read, where what came was incomplete."""
EEPROM_S = 2.0
"""Within this, a board has written a setting and answers."""


class GrblController(ScriptRunner[HostEvent]):
    """One board of the GRBL family, seen from the driver: hands each request to a collaborator.

    `limits` are what the axes can do: by the arm file, until the board's settings are read.
    """

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: GrblSettings = config.device
        axes = BoardAxes.of(config)
        host = Host(
            Dialect(  # a board without outputs, or homing by axis, refuses their words itself
                axes=axes.board(), ring_bytes=None, outputs=True, single_axis_homing=True
            )
        )
        super().__init__(replace(abilities, motors=len(axes.letters)), host)
        self.settings = settings
        self.axes = axes
        self.limits = axes.expected(settings)
        self.byte_s = BITS_A_BYTE / config.connection.baud
        self.board = board = BoardState(host, settings, axes)
        self.exchange = exchange = GrblExchange(self.io, host, board, settings, self.byte_s)
        self.outputs = GrblOutputs(exchange, settings, config.gripper.kind)
        stops = GrblStops(self.io, exchange, board, self.outputs, settings)
        self.contact = GrblContact(self.io, exchange, board, stops, self.outputs, settings)
        self.motion = GrblMotion(self.io, exchange, board, stops, settings, axes)
        self.homing = GrblHoming(self.io, exchange, board, self.contact, settings, axes.letters)

    # -- what happens -------------------------------------------------------------------------

    def script(self, request: Request) -> Answering:
        """Carry out a request; the first one makes contact with the board before it."""
        match request:
            case SetOutputs(bits):
                self.outputs.check(bits)
            case SetGripper():
                self.outputs.check_gripper()
            case MendSetting(line) if not line.startswith("$"):
                raise Refused(f"`{line}` is no setting of a GRBL board")
        return self._carry_out(request)

    def _carry_out(self, request: Request) -> Answering:
        if not self.board.contacted and (hindrance := (yield from self.contact.make())) is not None:
            return hindrance
        if isinstance(request, MoveBy):
            request = MoveAlong(iter((request,)), math.inf)
        match request:
            case MoveAlong():
                if (hindrance := (yield from self.contact.prepare())) is not None:
                    return hindrance
                return (yield from self.motion.drive(request, self.bounds))
            case ReadPosition():
                return (yield from self.exchange.read_position())
            case ReadSettings():
                return (yield from self._compare())
            case MendSetting(line):
                return (yield from self.exchange.carry_out(Line(line), EEPROM_S))
            case SetOutputs(bits):
                return (yield from self.outputs.set(bits))
            case SetGripper(share):
                return (yield from self.outputs.set_gripper(share))
            case DropCurrent():
                self.board.modes_set = False
                return (yield from self.exchange.carry_out(Sleep(), self.settings.answer_s))
            case HomeDevice(groups):
                return (yield from self.homing.home(groups))
            case SwitchOn() | ClearFault():
                return (yield from self.contact.clear())
            case ReadProgram() | WriteRow():
                return RequestRejected("a GRBL board keeps no program of its own", moved=False)

    def _compare(self) -> Answering:
        """Read the settings until they are all there, and learn what the axes can really do."""
        heard: HostEvent | None = None
        told, answer_s = self.board.told, self.settings.answer_s
        for _ in range(TRIES):
            told.clear()
            heard = yield from self.exchange.ask(QuerySettings(), answer_s)
            key = idle_key(self.settings, self.board.variant, told)
            if isinstance(heard, Acknowledged) and isinstance(key, str) and key not in told:
                yield from self.exchange.ask(Line(f"${key}"), answer_s)
            if isinstance(heard, Acknowledged) and key in told:
                break
        if not isinstance(heard, Acknowledged):
            return refusal(heard, "the settings could not be read")
        found = Comparison(self.settings, self.axes, self.board.letters, dict(told), key)
        self.limits = found.limits()
        firmware = f"{self.board.variant} {self.board.firmware}".strip()
        return DeviceSettings(tuple(found.differences()), firmware)

    def unasked(self, heard: HostEvent) -> None:
        """Learn from what no script was waiting for."""
        self.exchange.take(heard)

    def give_up(self) -> None:
        """Forget unanswered lines and half a message."""
        self.exchange.give_up()

    # -- numbers ------------------------------------------------------------------------------

    @property
    def underruns(self) -> int:
        """How often the board stood still although more of its motion was to come."""
        return self.motion.underruns

    @property
    def bounds(self) -> MotionBounds:
        """What motion the board can do, by all that is known of it now."""
        return MotionBounds(self.limits, self.axes.most_hz, self.board.segment_buffer, self.byte_s)

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate itself, within what the board can do without pauses between steps."""
        return self.bounds.usable_rate_hz(rate_hz)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the slowest axis takes for so many steps, from rest to rest."""
        return self.bounds.duration_s(steps, rate_hz)

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound how long motion goes on."""
        return self.bounds.stopping(burst_s, parts)


DRIVER = Driver(GrblSettings, GrblController)
