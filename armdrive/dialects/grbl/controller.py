"""The driver's end of the GRBL dialect: neutral requests to lines, reports to replies.

Sources: gnea/grbl doc/markdown/interface.md, commands.md, jogging.md, settings.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import Abilities, segment_s
from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.dialects.grbl.contact import GrblContact
from armdrive.dialects.grbl.exchange import Answering, refusal
from armdrive.dialects.grbl.in_flight import LAST_STEP_S, SLOWEST_HZ, MotorPath, trapezoid_s
from armdrive.dialects.grbl.motion import GrblMotion
from armdrive.dialects.grbl.settings import BoardAxes, Comparison, GrblSettings, idle_key
from armdrive.dialects.grbl.stops import AGAIN_S, HELD
from armdrive.dialects.grbl.words import RECOGNITION, TALK
from armdrive.errors import Refused as NotPossible
from armdrive.tasks import (
    ClearFault,
    DeviceSettings,
    Done,
    DropCurrent,
    Halted,
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
from firmware_protocol.grbl import (
    Acknowledged,
    AlarmRaised,
    Home,
    Line,
    QuerySettings,
    Refused,
    Restarted,
    Sleep,
)
from firmware_protocol.grbl.events import Event as HostEvent

LATENCY_S = 0.03
"""What a host may be late by."""
LONGEST_LINE = 81
CONFIRMED_S = 0.12
"""Looks at a board that brakes, its reset and its banner."""
KILLED_S = 0.3
"""A board that is reset in motion keeps its motors for $1, 255 ms, and lets go of them then."""
TRIES = 3
"""How often the settings are read, where what came was incomplete."""
TOLD = {"M3", "flood", "mist"}
"""The outputs of which a status report says that they are on (gnea/grbl grbl/report.c)."""
EEPROM_S = 2.0


class GrblController(GrblMotion, GrblContact):
    """One board of the GRBL family, seen from the driver."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: GrblSettings = config.device
        axes = BoardAxes.of(config)
        motors = replace(abilities, motors=len(axes.letters))
        super().__init__(motors, settings, axes, config.connection.baud)
        self._kind = config.gripper.kind
        self.reset_lets_go = self._kind in ("servo", "output")
        outputs = settings.outputs[settings.gripper_output :][:1]
        hangs_on = (settings.servo,) if self._kind == "servo" else outputs
        self.outputs_told = set(hangs_on) <= TOLD

    def script(self, request: Request) -> Answering:
        """Carry out a request; the first one makes contact with the board before it."""
        self._refuse_impossible(request)
        return self._script_of(request)

    def _refuse_impossible(self, request: Request) -> None:
        if isinstance(request, SetOutputs) and request.bits >> len(self.settings.outputs):
            raise NotPossible(
                f"this board has {len(self.settings.outputs)} outputs, {request.bits} needs more: "
                "name them in grbl.outputs"
            )
        if isinstance(request, SetGripper) and self._kind not in ("servo", "output"):
            raise NotPossible("this arm's gripper is driven by a motor, not by a servo or output")
        if isinstance(request, MendSetting) and not request.line.startswith("$"):
            raise NotPossible(f"`{request.line}` is no setting of a GRBL board")

    def _script_of(self, request: Request) -> Answering:
        if not self.contacted and (hindrance := (yield from self.contact())) is not None:
            return hindrance
        match request:
            case MoveBy():
                return (yield from self.drive(MoveAlong(iter((request,)), math.inf)))
            case MoveAlong():
                return (yield from self.drive(request))
            case ReadPosition():
                return (yield from self._read())
            case ReadSettings():
                return (yield from self._compare())
            case MendSetting(line):
                return (yield from self._line(Line(line), EEPROM_S))
            case SetOutputs(bits):
                return (yield from self._set_outputs(bits))
            case SetGripper(share):
                return (yield from self._set_gripper(share))
            case DropCurrent():
                self.modes_set = False
                return (yield from self._line(Sleep(), self.settings.answer_s))
            case HomeDevice(groups):
                return (yield from self._home(groups))
            case SwitchOn() | ClearFault():
                return (yield from self.clear())
            case ReadProgram() | WriteRow():
                return RequestRejected("a GRBL board keeps no program of its own", moved=False)

    # -- reading ------------------------------------------------------------------------------

    def _read(self) -> Answering:
        began_s = self.now_s
        share = 4.0 if self.polls.since_s < self.now_s else 2.0  # the driver asks three times
        if (yield from self.look_position(self.settings.mute_s / share)):
            return self.registers()
        if self.alarm is not None:
            return RequestRejected(self.alarm_words(), moved=False)
        return self.silence(began_s)

    def _compare(self) -> Answering:
        """Read the settings until they are all there, and learn what the axes can really do."""
        heard: HostEvent | None = None
        for _ in range(TRIES):
            self.told.clear()
            heard = yield from self.ask(QuerySettings(), self.settings.answer_s)
            key = idle_key(self.settings, self.variant, self.told)
            if isinstance(heard, Acknowledged) and isinstance(key, str) and key not in self.told:
                yield from self.ask(Line(f"${key}"), self.settings.answer_s)
            if isinstance(heard, Acknowledged) and key in self.told:
                break
        if not isinstance(heard, Acknowledged):
            return refusal(heard, "the settings could not be read")
        board = self._host.dialect.axes
        found = Comparison(self.settings, self.axes, board, dict(self.told), key)
        self.limits = found.limits()
        return DeviceSettings(tuple(found.differences()), f"{self.variant} {self.firmware}".strip())

    # -- what moves nothing -------------------------------------------------------------------

    def _line(self, command: Line | Sleep, patience_s: float) -> Answering:
        heard = yield from self.ask(command, patience_s)
        if isinstance(heard, Acknowledged):
            return Done()
        return refusal(heard, f"`{command.text}` was not carried out")

    def _set_outputs(self, bits: int) -> Answering:
        refused = yield from self.drive_outputs(bits)
        if refused is None:
            self.outputs_on = bits
        return refused or Done()

    def _set_gripper(self, share: float) -> Answering:
        if self._kind == "output":
            bit = 1 << self.settings.gripper_output
            closed = share < 0.5  # the driver asks for 0 or 1 alone
            before = self.outputs_on or 0
            on = closed == self.settings.gripper_closes
            return (yield from self._set_outputs(before | bit if on else before & ~bit))
        refused = yield from self.drive_gripper(share)
        if refused is None:
            self.gripper_share = share
        return refused or Done()

    def _home(self, groups: tuple[tuple[int, ...], ...]) -> Answering:
        """Have the board find its switches, all at once or group after group."""
        yield from self.look(self.settings.answer_s)
        if self.state in HELD:
            return RequestRejected(
                f"the board's state is {self.state}; `reset()` leaves it", moved=False
            )
        yield from self.clean_line()
        for command in self._homings(groups):
            self.speak(command)
            end_s = self.now_s + self.settings.homing_s
            heard: HostEvent | None = None
            while self.now_s < end_s and not self.stop_asked and not answered(heard):
                heard = yield from self.listen(end_s)
            if not answered(heard):
                yield from self.end_homing()
                if not self.stop_hard:
                    yield from self.clear()  # the driver knows that nothing is referenced
                return Halted(kept=False)
            if not isinstance(heard, Acknowledged):
                return refusal(heard, f"`{command.text}`", moved=True)
        return Done()

    def _homings(self, groups: tuple[tuple[int, ...], ...]) -> list[Home]:
        """Return the commands; only some firmwares home several axes that are named together."""
        if not groups:
            return [Home()]
        named = ["".join(self.axes.letters[motor] for motor in group) for group in groups]
        if self.variant.name != "GRBLHAL":
            named = list("".join(named))
        return [Home(letters) for letters in named]

    # -- numbers ------------------------------------------------------------------------------

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate itself, within what the board can do without pauses between steps."""
        return max(min(rate_hz, max(self.limits.rates_hz())), SLOWEST_HZ)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the slowest axis takes for so many steps, from rest to rest."""
        slopes = zip(self.limits.accelerations, self.limits.steps_per_unit, strict=True)
        slowest = min(*self.limits.rates_hz(), rate_hz)
        least = min(slope * per for slope, per in slopes)
        return trapezoid_s(MotorPath(max(steps, 1e-6), (1.0,), slowest, least), 0.0, 0.0)

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound what the board still drives; without a host, what was sent ahead as well.

        The bound allows for one lost byte, which is sent again after `AGAIN_S`. What was sent ahead
        is driven to its end, where its last line brakes: half of that ramp is more than its time.
        """
        wire_s = LATENCY_S + LONGEST_LINE * self.byte_s
        heard_s = wire_s + AGAIN_S
        piece_s = segment_s(burst_s) / 2.0  # a part is cut into equal ones
        brakes_s, held_s = self.ramp_from_s(parts), self.held_longest_s(parts, piece_s)
        held_way_s = self.held_full_speed_s(parts)
        stands_s = heard_s + held_s + brakes_s + LAST_STEP_S
        return Stopping(
            max(stands_s, heard_s + KILLED_S),
            heard_s + held_way_s + brakes_s / 2.0,
            burst_s + wire_s + held_s + brakes_s + LAST_STEP_S,
            burst_s + wire_s + held_way_s,
            max(stands_s + CONFIRMED_S, heard_s + KILLED_S),
        )


def answered(heard: HostEvent | None) -> bool:
    """Tell whether waiting for a line's answer has come to an end."""
    return isinstance(heard, Acknowledged | Refused | Restarted | AlarmRaised)


DRIVER = Driver(GrblSettings, GrblController, TALK, RECOGNITION)
