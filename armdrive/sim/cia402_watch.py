"""What a simulated CiA 402 drive does by itself when its time has come, and when that is."""

from __future__ import annotations

import math

from armdrive.sim.cia402_errors import LIMIT_REACHED, TOO_FAR_BEHIND, report
from armdrive.sim.cia402_homing import watch_switch
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_reacting import forsake
from armdrive.sim.cia402_states import command, fault, watch_end
from armdrive.sim.cia402_status import behind
from armdrive.sim.cia402_talk import tell_changes
from firmware_protocol.canopen import (
    FOLLOWING_ERROR_TIMEOUT_MS,
    FOLLOWING_ERROR_WINDOW,
    Command,
    DriveState,
)

_UNWATCHED = 0xFFFF_FFFF
_OBEYING = (DriveState.ENABLED, DriveState.QUICK_STOP)


def due_s(node: Node) -> float:
    """Tell when it next does something by itself, apart from looking at its shaft."""
    if not node.powered:
        return math.inf
    if node.booting:
        return min(node.boots_s, _motion_s(node))
    due = min(node.beat_s, node.silent_s, _motion_s(node))
    if not node.nmt.takes("pdo"):
        return due
    return min((due, *(pdo.due_s for pdo in node.pdos.transmitted)))


def live(node: Node, now_s: float) -> None:
    """Do whatever is due by now."""
    if not node.powered:
        return
    if node.booting and node.boots_s <= now_s:
        node.boots_s = -math.inf
        node.say((node.nmt.booted(),))
        for code in sorted(node.ailing):
            fault(node, code, now_s)
    _watch_beats(node, now_s)
    _watch_shaft(node, now_s)
    _watch_switch(node, now_s)
    watch_end(node, now_s)
    tell_changes(node, now_s)


def _motion_s(node: Node) -> float:
    end_s = node.point.end_s if node.ends and not node.waits else math.inf
    return min(end_s, node.switch_s, node.astray_s + _patience_s(node))


def _patience_s(node: Node) -> float:
    return node.number_of(FOLLOWING_ERROR_TIMEOUT_MS, 0) / 1000


def _watch_beats(node: Node, now_s: float) -> None:
    if node.beat_s <= now_s:
        node.beat_on(node.beat_s)
        node.say((node.nmt.heartbeat.frame,))
    if node.silent_s <= now_s:
        node.silent_s = math.inf
        forsake(node, now_s)


def _watch_shaft(node: Node, now_s: float) -> None:
    """Fail where the shaft has been too far from where it was told to be, for too long."""
    window = node.number_of(FOLLOWING_ERROR_WINDOW, _UNWATCHED)
    watches = node.holding and node.state in _OBEYING and window != _UNWATCHED
    if not watches or abs(behind(node, now_s)) <= window:
        node.astray_s = math.inf
        return
    node.astray_s = min(node.astray_s, now_s)
    if now_s >= node.astray_s + _patience_s(node):
        node.astray_s, node.astray = math.inf, True
        fault(node, TOO_FAR_BEHIND, now_s)


def _watch_switch(node: Node, now_s: float) -> None:
    if node.switch_s <= now_s:
        node.switch_s = math.inf
    if node.homing.searches:
        watch_switch(node)
    elif _runs_into_limit(node, now_s):
        report(node, LIMIT_REACHED)
        command(node, Command.QUICK_STOP, now_s)


def _runs_into_limit(node: Node, now_s: float) -> bool:
    minds = node.habits.limits and node.enabled and node.switch.pressed
    return minds and node.point.rate(now_s) * node.switch.way > 0
