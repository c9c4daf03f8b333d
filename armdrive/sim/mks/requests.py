"""What a simulated MKS drive does with each request, and what it answers to each reading."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import cast

from armdrive.sim.mks.motion import AGAINST_A_STOP, begin, give_up, homing_of
from armdrive.sim.mks.node import MksNode
from firmware_protocol.mks import (
    ANGLE_ERROR_PER_TURN,
    COUNTS_PER_TURN,
    MOTION_CODES,
    SETTING_CODES,
    Ability,
    AngleErrorRead,
    ArmSynchronous,
    Asked,
    Calibrate,
    ClearStall,
    Code,
    EmergencyStop,
    Enable,
    EnabledRead,
    EncoderRead,
    GoSynchronous,
    GoToZero,
    Home,
    HomingRead,
    HomingState,
    InputsRead,
    Mode,
    MotorState,
    MoveAbsoluteAxis,
    Outcome,
    PulsesRead,
    RawEncoderRead,
    Reading,
    ReadSetting,
    ReportByItself,
    Restart,
    SetCurrent,
    SetMode,
    Setting,
    SettingRead,
    SetZero,
    SpeedRead,
    StallRead,
    StateRead,
    Stop,
    VersionRead,
)

# --- Readings, and what the drive reports without being asked ------------------------------------

BOARD = 2
"""A SERVO42D on CAN."""


def answer(node: MksNode, asked: Asked, now_s: float) -> None:
    """Answer a read."""
    request = asked.request
    if isinstance(request, ReadSetting):
        setting = node.flash.get(request.setting)
        value = None if setting is None else setting.payload
        node.say(node.device.answer(asked, SettingRead(request.setting, value)))
    else:
        node.say(node.device.answer(asked, reading(node, request.code, now_s)))


def report(node: MksNode, now_s: float) -> None:
    """Say by itself what is due."""
    for code, (period_s, due_s) in node.reports.items():
        if due_s <= now_s:
            node.reports[code] = (period_s, due_s + period_s)
            node.say(node.device.report(reading(node, code, now_s)))


def reading(node: MksNode, code: Code, now_s: float) -> Reading:
    """Return what a drive reads of itself."""
    return _READINGS[code](node, now_s)


def state(node: MksNode, now_s: float) -> MotorState:
    """Return what the drive says that its motor does."""
    if not node.searching:
        return node.point.state(now_s)
    calibrates = node.under_way is not None and node.under_way.request.code is Code.CALIBRATE
    return MotorState.CALIBRATING if calibrates else MotorState.HOMING


def _error(node: MksNode, now_s: float) -> int:
    return node.point.at(now_s) - node.shaft


def _speed(node: MksNode, now_s: float) -> SpeedRead:
    stands = abs(_error(node, now_s)) >= node.quirks.stall_counts
    return SpeedRead(0 if stands else round(node.point.rpm(now_s)))


def _pulses(node: MksNode, now_s: float) -> PulsesRead:
    return PulsesRead(round((node.point.at(now_s) - node.zero) / node.counts_per_pulse))


def _angle_error(node: MksNode, now_s: float) -> AngleErrorRead:
    return AngleErrorRead(round(_error(node, now_s) * ANGLE_ERROR_PER_TURN / COUNTS_PER_TURN))


def _homing(node: MksNode, _: float) -> HomingRead:
    """Return how homing stands: one that has never been asked for has failed."""
    if Ability.HOMING_BY_COMMAND_READ not in node.device.abilities:
        return HomingRead(HomingState.FAILED)
    found = HomingState.FAILED if node.homing is None else node.homing
    return HomingRead(HomingState.FAILED, found)


def _version(node: MksNode, _: float) -> VersionRead:
    return VersionRead(node.calibrated, BOARD, bytes(node.firmware)[-node.quirks.version_bytes :])


_READINGS: Mapping[Code, Callable[[MksNode, float], Reading]] = MappingProxyType(
    {
        Code.ENCODER: lambda node, _: EncoderRead(node.counts),
        Code.RAW_ENCODER: lambda node, _: RawEncoderRead(node.shaft - node.power_on_zero),
        Code.SPEED: _speed,
        Code.PULSES: _pulses,
        Code.ANGLE_ERROR: _angle_error,
        Code.INPUTS: lambda node, _: InputsRead(int(node.switch.pressed)),
        Code.ENABLED: lambda node, _: EnabledRead(node.enabled),
        Code.STALL: lambda node, _: StallRead(node.stalled),
        Code.STATE: lambda node, now_s: StateRead(state(node, now_s)),
        Code.HOMING_STATE: _homing,
        Code.VERSION: _version,
    }
)


def obey(node: MksNode, asked: Asked, now_s: float) -> None:
    """Do what was asked, as far as the drive does such a thing now, and say so."""
    request = asked.request
    match request:
        case Stop():
            _stop(node, asked, now_s)
        case Home() | GoToZero() | Calibrate():
            _search(node, asked, now_s)
        case EmergencyStop():
            give_up(node, now_s)
            node.point.hold(node.point.at(now_s))
            node.tell(asked, Outcome.DONE)
        case Enable():
            _enable(node, asked, on=request.on, now_s=now_s)
        case ArmSynchronous():
            node.armed, node.stored = request.on, None
            node.tell(asked, Outcome.DONE)
        case GoSynchronous():
            _go(node, now_s)
        case SetZero():
            _zero(node, asked, now_s)
        case ClearStall():
            _clear(node, asked, now_s)
        case Restart():
            node.tell(asked, Outcome.DONE)
            said = list(node.said)
            node.restart(now_s)
            node.said += said
        case ReportByItself():
            _report(node, request, now_s)
            node.tell(asked, Outcome.DONE)
        case _ if request.code in MOTION_CODES:
            _move(node, asked, now_s)
        case _ if request.code in SETTING_CODES:
            _set(node, asked, now_s)
        case _:
            answer(node, asked, now_s)


def _move(node: MksNode, asked: Asked, now_s: float) -> None:
    if not node.can_move:
        node.refuse(asked)
    elif node.armed:
        node.stored = asked
        node.tell(asked, Outcome.STORED)
    elif not node.point.moving(now_s):
        begin(node, asked, now_s)
        node.tell(asked, Outcome.STARTED)
    elif _gives_way(node, asked):
        _supersede(node, asked, now_s)
    else:
        node.refuse(asked)


def _gives_way(node: MksNode, asked: Asked) -> bool:
    """Tell whether what is under way is replaced by what is asked for now."""
    before = None if node.under_way is None else node.under_way.request.code
    if asked.request.code is Code.SPEED_MODE:
        return before in (None, Code.SPEED_MODE)
    able = isinstance(asked.request, MoveAbsoluteAxis) and Ability.RETARGET in node.device.abilities
    return able and before in (None, Code.ABSOLUTE_AXIS)


def _supersede(node: MksNode, asked: Asked, now_s: float) -> None:
    before, says = node.under_way, node.quirks.superseded
    says = says if before is not None and isinstance(before.request, MoveAbsoluteAxis) else ""
    if before is not None and says == "first":
        node.tell(before, Outcome.FAILED)
    begin(node, asked, now_s)
    node.tell(asked, Outcome.STARTED)
    if before is not None and says == "last":
        node.tell(before, Outcome.FAILED)


def _stop(node: MksNode, asked: Asked, now_s: float) -> None:
    give_up(node, now_s)
    begin(node, asked, now_s)
    node.tell(asked, Outcome.STARTED)


def _search(node: MksNode, asked: Asked, now_s: float) -> None:
    unknown = isinstance(asked.request, Home) and homing_of(node).method > AGAINST_A_STOP
    if not node.can_move or node.point.moving(now_s) or unknown:
        node.refuse(asked)
        return
    begin(node, asked, now_s)
    node.tell(asked, Outcome.STARTED)


def _go(node: MksNode, now_s: float) -> None:
    """Begin what is stored; nobody is told that it began."""
    asked, node.stored = node.stored, None
    node.armed = node.armed and node.quirks.stays_armed
    if asked is not None and node.can_move:
        begin(node, asked, now_s)


def _enable(node: MksNode, asked: Asked, *, on: bool, now_s: float) -> None:
    if not node.mode.on_bus or (on and node.stalled):
        node.refuse(asked)
        return
    if not on:
        give_up(node, now_s)
    node.set_enabled(on, now_s)
    node.tell(asked, Outcome.DONE)


def _zero(node: MksNode, asked: Asked, now_s: float) -> None:
    if node.point.moving(now_s):
        node.refuse(asked)
        return
    node.zero = node.shaft
    node.tell(asked, Outcome.DONE)


def _clear(node: MksNode, asked: Asked, now_s: float) -> None:
    if node.stalled:
        node.stalled = False
        node.set_enabled(True, now_s)
    node.tell(asked, Outcome.DONE)


def _report(node: MksNode, request: ReportByItself, now_s: float) -> None:
    period_s = request.period_ms / 1000
    if period_s:
        node.reports[request.reading] = (period_s, now_s + period_s)
    else:
        node.reports.pop(request.reading, None)


def _set(node: MksNode, asked: Asked, now_s: float) -> None:
    request = asked.request
    if isinstance(request, SetMode) and request.mode is not Mode.BUS_FOC:
        give_up(node, now_s)
        node.point.hold(node.point.at(now_s))
    if isinstance(request, SetCurrent):
        request = replace(request, keep=True)
    node.flash.put(cast(Setting, request))
    node.tell(asked, Outcome.DONE)
