"""What a simulated MKS drive does with each kind of request."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from armdrive.sim.mks_answers import answer
from armdrive.sim.mks_course import AGAINST_A_STOP, begin, give_up, homing_of
from armdrive.sim.mks_node import Node
from firmware_protocol.mks import (
    MOTION_CODES,
    SETTING_CODES,
    Ability,
    ArmSynchronous,
    Asked,
    Calibrate,
    ClearStall,
    Code,
    EmergencyStop,
    Enable,
    GoSynchronous,
    GoToZero,
    Home,
    Mode,
    MoveAbsoluteAxis,
    Outcome,
    ReportByItself,
    Restart,
    SetCurrent,
    SetMode,
    Setting,
    SetZero,
    Stop,
)


def obey(node: Node, asked: Asked, now_s: float) -> None:
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


def _move(node: Node, asked: Asked, now_s: float) -> None:
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


def _gives_way(node: Node, asked: Asked) -> bool:
    """Tell whether what is under way is replaced by what is asked for now."""
    before = None if node.under_way is None else node.under_way.request.code
    if asked.request.code is Code.SPEED_MODE:
        return before in (None, Code.SPEED_MODE)
    able = isinstance(asked.request, MoveAbsoluteAxis) and Ability.RETARGET in node.device.abilities
    return able and before in (None, Code.ABSOLUTE_AXIS)


def _supersede(node: Node, asked: Asked, now_s: float) -> None:
    before, says = node.under_way, node.habits.superseded
    says = says if before is not None and isinstance(before.request, MoveAbsoluteAxis) else ""
    if before is not None and says == "first":
        node.tell(before, Outcome.FAILED)
    begin(node, asked, now_s)
    node.tell(asked, Outcome.STARTED)
    if before is not None and says == "last":
        node.tell(before, Outcome.FAILED)


def _stop(node: Node, asked: Asked, now_s: float) -> None:
    give_up(node, now_s)
    begin(node, asked, now_s)
    node.tell(asked, Outcome.STARTED)


def _search(node: Node, asked: Asked, now_s: float) -> None:
    unknown = isinstance(asked.request, Home) and homing_of(node).method > AGAINST_A_STOP
    if not node.can_move or node.point.moving(now_s) or unknown:
        node.refuse(asked)
        return
    begin(node, asked, now_s)
    node.tell(asked, Outcome.STARTED)


def _go(node: Node, now_s: float) -> None:
    """Begin what is stored; nobody is told that it began."""
    asked, node.stored = node.stored, None
    node.armed = node.armed and node.habits.stays_armed
    if asked is not None and node.can_move:
        begin(node, asked, now_s)


def _enable(node: Node, asked: Asked, *, on: bool, now_s: float) -> None:
    if not node.mode.on_bus or (on and node.stalled):
        node.refuse(asked)
        return
    if not on:
        give_up(node, now_s)
    node.set_enabled(on, now_s)
    node.tell(asked, Outcome.DONE)


def _zero(node: Node, asked: Asked, now_s: float) -> None:
    if node.point.moving(now_s):
        node.refuse(asked)
        return
    node.zero = node.shaft
    node.tell(asked, Outcome.DONE)


def _clear(node: Node, asked: Asked, now_s: float) -> None:
    if node.stalled:
        node.stalled = False
        node.set_enabled(True, now_s)
    node.tell(asked, Outcome.DONE)


def _report(node: Node, request: ReportByItself, now_s: float) -> None:
    period_s = request.period_ms / 1000
    if period_s:
        node.reports[request.reading] = (period_s, now_s + period_s)
    else:
        node.reports.pop(request.reading, None)


def _set(node: Node, asked: Asked, now_s: float) -> None:
    request = asked.request
    if isinstance(request, SetMode) and request.mode is not Mode.BUS_FOC:
        give_up(node, now_s)
        node.point.hold(node.point.at(now_s))
    if isinstance(request, SetCurrent):
        request = replace(request, keep=True)
    node.flash.put(cast(Setting, request))
    node.tell(asked, Outcome.DONE)
