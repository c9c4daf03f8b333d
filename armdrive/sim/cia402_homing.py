"""How a simulated CiA 402 drive finds its home: by the methods 18, 35 and 37 of object 6098.

18 goes up to the limit switch, and slowly back until that opens; 35 and 37 take the place where the
drive stands. Home is where the position is the offset of 607C from then on.
"""

from __future__ import annotations

import math

from armdrive.sim.cia402_course import brake, forget_targets
from armdrive.sim.cia402_habits import Homing
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_places import (
    HOME_OFFSET,
    HOMING_ACCELERATION,
    HOMING_CREEP,
    HOMING_METHOD,
    HOMING_SPEED,
)

AT_UPPER_SWITCH = 18
IN_PLACE = (35, 37)
METHODS = frozenset((0, AT_UPPER_SWITCH, *IN_PLACE))
_USUAL_SLOPE = 100_000
_USUAL_SPEED = 1000


def begin(node: Node, now_s: float) -> None:
    """Go home, by the method that is set."""
    forget_targets(node)
    method = node.number_of(HOMING_METHOD, 0)
    if method in IN_PLACE:
        _found(node, node.shaft)
    elif method == AT_UPPER_SWITCH:
        (_leave if node.switch.pressed else _seek)(node, now_s)
    else:
        node.homing = Homing.FAILED


def give_up(node: Node, now_s: float) -> None:
    """Break a search off, slowing down."""
    if node.homing.searches:
        node.homing, node.switch_s = Homing.NONE, math.inf
        brake(node, _slope(node), now_s)


def watch_switch(node: Node) -> None:
    """Do what is due at the switch: turn back there, or be home."""
    now_s = node.drive.rack.now_s
    if node.homing is Homing.SEEKING and node.switch.pressed:
        _leave(node, now_s)
    elif node.homing is Homing.LEAVING and not node.switch.pressed:
        _found(node, node.point.at(now_s))


def _seek(node: Node, now_s: float) -> None:
    node.homing = Homing.SEEKING
    _run(node, node.switch.way * _speed(node, fast=True), now_s)
    node.switch_s = node.point.passes_s(node.switch.at, node.switch.way, now_s)


def _leave(node: Node, now_s: float) -> None:
    node.homing = Homing.LEAVING
    way = -node.switch.way
    _run(node, way * _speed(node, fast=False), now_s)
    node.switch_s = node.point.passes_s(node.switch.at + way, way, now_s)


def _run(node: Node, rate: float, now_s: float) -> None:
    node.point.go_at(rate, _slope(node), now_s)
    node.ends = False


def _found(node: Node, at: int) -> None:
    node.point.hold(at)
    node.goal = node.number_of(HOME_OFFSET, 0)
    node.zero = at - node.goal
    node.homing, node.switch_s, node.ends = Homing.DONE, math.inf, False


def _speed(node: Node, *, fast: bool) -> float:
    return float(max(node.number_of(HOMING_SPEED if fast else HOMING_CREEP, _USUAL_SPEED), 1))


def _slope(node: Node) -> float:
    return float(max(node.number_of(HOMING_ACCELERATION, _USUAL_SLOPE), 1))
