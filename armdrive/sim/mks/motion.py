"""How a motion of a simulated MKS drive begins, goes on by itself, and ends."""

from __future__ import annotations

import math

from armdrive.sim.mks.node import MksNode
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    Ability,
    Asked,
    Calibrate,
    Code,
    GoToZero,
    HomingState,
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativeAxis,
    MoveRelativePulses,
    Outcome,
    RunAtSpeed,
    RunFor,
    SetArrival,
    SetHoming,
    SetPositionProtection,
    SetStallProtection,
    Stop,
)

HOMING_ACC = 236
"""A ramp of 1000 rpm a second, where no request says one."""
CALIBRATION_RPM = 30
STALL_S = 0.05
"""For so long a shaft that protection lets go has been too far from its set-point."""
WINDOW_S = 0.015
"""What the window of position protection counts."""
ERROR_PER_TURN = 28_000
"""What its error counts."""
ARRIVAL_PER_TURN = 65_536
AGAINST_A_STOP = 1
"""The way of homing that feels for the end; 0 looks for the switch."""


def begin(node: MksNode, asked: Asked, now_s: float) -> None:
    """Have the set-point do what was asked, whatever it did before."""
    request, point = asked.request, node.point
    node.under_way, node.waits = asked, False
    node.acc = getattr(request, "acc", HOMING_ACC)
    match request:
        case MoveAbsoluteAxis():
            _go(node, node.zero + request.counts, request.speed_rpm, now_s)
        case MoveRelativeAxis():
            _go(node, point.end + request.counts, request.speed_rpm, now_s)
        case MoveAbsolutePulses():
            goal = node.zero + round(request.pulses * node.counts_per_pulse)
            _go(node, goal, request.speed_rpm, now_s)
        case MoveRelativePulses():
            goal = point.end + round(request.pulses * node.counts_per_pulse)
            _go(node, goal, request.speed_rpm, now_s)
        case RunAtSpeed():
            point.run(node.rpm_of(request.speed_rpm), node.acc, now_s)
        case RunFor():
            time_s = request.duration_ms / 1000
            point.run_for(node.rpm_of(request.speed_rpm), node.acc, time_s, now_s)
        case Stop():
            point.run(0.0, request.acc, now_s)
        case GoToZero():
            _go(node, node.zero, homing_of(node).speed_rpm, now_s)
        case Calibrate():
            point.there_and_back(COUNTS_PER_TURN, CALIBRATION_RPM, now_s)
        case _:
            _seek(node, now_s)
    node.switch_s = _switch_s(node, now_s)


def homing_of(node: MksNode) -> SetHoming:
    """Return how it homes."""
    return node.flash.of(SetHoming)


def give_up(node: MksNode, now_s: float) -> None:
    """Forget what is under way and what is stored; the set-point goes on as it does."""
    if node.seeking:
        node.homing = HomingState.FAILED
    node.under_way = node.stored = None
    node.seeking, node.switch_s = 0, math.inf
    if not node.point.moving(now_s):
        node.point.hold(node.point.end)


def due_s(node: MksNode) -> float:
    """Tell when it next does something by itself, apart from looking at its shaft."""
    if not node.powered:
        return math.inf
    if node.booting:
        return node.boots_s
    due = min([due for _, due in node.reports.values()]) if node.reports else math.inf
    if node.under_way is None:
        return due
    silent_s = node.heard_s + node.timeout_s
    if not node.expired and silent_s < node.point.end_s:  # one that stands has nothing to stop
        due = min(due, silent_s)
    return min(due, node.switch_s, math.inf if node.waits else node.point.end_s)


def happen(node: MksNode, now_s: float) -> None:
    """Do whatever is due by now."""
    if node.booting and node.boots_s <= now_s:
        node.begin(now_s)
    if node.awake:
        _watch_silence(node, now_s)
        _watch_shaft(node, now_s)
        _watch_switch(node, now_s)
        _watch_end(node, now_s)


def _go(node: MksNode, goal: int, speed_rpm: int, now_s: float) -> None:
    node.point.move_to(goal, node.rpm_of(max(speed_rpm, 1)), node.acc, now_s)


def _seek(node: MksNode, now_s: float) -> None:
    """Begin to search for the zero: first away from the switch, where that is pressed already."""
    setting = homing_of(node)
    node.seeking = 1 if setting.counter_clockwise else -1
    node.homing = HomingState.UNDER_WAY
    node.backing = setting.method != AGAINST_A_STOP and node.switch.pressed
    way = -node.seeking if node.backing else node.seeking
    node.point.run(way * node.rpm_of(max(setting.speed_rpm, 1)), node.acc, now_s)


def _switch_s(node: MksNode, now_s: float) -> float:
    """Return when the set-point comes to where the switch changes, if it is looked at."""
    switch = node.switch
    if not node.seeking and not homing_of(node).limits:
        return math.inf
    if node.seeking and node.backing:
        return node.point.passes_s(switch.at - switch.way, -switch.way, now_s)
    if switch.pressed:
        return now_s
    return node.point.passes_s(switch.at, switch.way, now_s)


def _watch_silence(node: MksNode, now_s: float) -> None:
    """Stop where the bus has been silent for too long; the drive says nothing of it."""
    moves = node.under_way is not None and node.point.moving(now_s)
    if moves and not node.expired and now_s >= node.heard_s + node.timeout_s:
        give_up(node, now_s)
        node.point.run(0.0, node.acc, now_s)
        node.expired = True
        node.watchdog_stops += 1


def _watch_shaft(node: MksNode, now_s: float) -> None:
    """Let a shaft go that does not follow, where a protection is on."""
    error = abs(node.point.at(now_s) - node.shaft)
    if not error or not node.drive.holding[node.index]:
        node.astray_s = node.off_s = math.inf
        return
    node.astray_s = min(node.astray_s, now_s) if error >= node.quirks.stall_counts else math.inf
    if node.seeking and homing_of(node).method == AGAINST_A_STOP:
        if node.astray_s < math.inf:
            _found(node, node.shaft)
        return
    guarded = node.flash.of(SetStallProtection).on
    if (guarded and now_s >= node.astray_s + STALL_S) or _is_off(node, error, now_s):
        _let_go(node, now_s)


def _is_off(node: MksNode, error: int, now_s: float) -> bool:
    guard = node.flash.of(SetPositionProtection)
    if not guard.on:
        return False
    beyond = error * ERROR_PER_TURN >= guard.error * COUNTS_PER_TURN
    node.off_s = min(node.off_s, now_s) if beyond else math.inf
    return now_s >= node.off_s + guard.window * WINDOW_S


def _let_go(node: MksNode, now_s: float) -> None:
    asked = node.under_way
    give_up(node, now_s)
    node.stalled = True
    node.set_enabled(False, now_s)
    if asked is not None:
        node.tell(asked, Outcome.FAILED)


def _watch_switch(node: MksNode, now_s: float) -> None:
    if node.switch_s <= now_s:
        node.switch_s = math.inf
    if node.seeking:
        _search(node, now_s)
    elif node.under_way is not None and homing_of(node).limits and node.switch.pressed:
        _limit(node, node.under_way, now_s)


def _search(node: MksNode, now_s: float) -> None:
    if homing_of(node).method == AGAINST_A_STOP or node.switch.pressed is node.backing:
        return
    if node.backing:
        node.backing = False
        speed_rpm = node.rpm_of(max(homing_of(node).speed_rpm, 1))
        node.point.run(node.seeking * speed_rpm, node.acc, now_s)
        node.switch_s = _switch_s(node, now_s)
    else:
        _found(node, node.point.at(now_s))


def _found(node: MksNode, at: int) -> None:
    """Stand, call it zero, and say so."""
    node.point.hold(at)
    node.zero = at
    node.homing, node.seeking = HomingState.DONE, 0
    asked = node.under_way
    if asked is not None:
        node.tell(asked, Outcome.DONE)
    node.under_way = None


def _limit(node: MksNode, asked: Asked, now_s: float) -> None:
    """End what leads into the switch; what leads away from it goes on."""
    rpm = node.point.rpm(now_s) or node.point.rpm(now_s + 1e-6)
    if rpm * node.switch.way > 0:
        node.point.hold(node.point.at(now_s))
        node.under_way = None
        if asked.request.code not in (Code.HOME, Code.CALIBRATE):
            node.tell(asked, Outcome.LIMIT_STOP)


def _watch_end(node: MksNode, now_s: float) -> None:
    asked = node.under_way
    if asked is None or node.seeking or node.point.moving(now_s):
        return
    node.waits = abs(node.point.end - node.shaft) > _threshold(node)
    if not node.waits:
        node.tell(asked, Outcome.DONE)
        node.under_way = None


def _threshold(node: MksNode) -> float:
    """Return how near a motion must come to be said done: older firmware does not look at all."""
    setting = node.flash.of(SetArrival)
    if Ability.ARRIVAL_THRESHOLD not in node.device.abilities or not setting.on:
        return math.inf
    return setting.threshold * COUNTS_PER_TURN / ARRIVAL_PER_TURN
