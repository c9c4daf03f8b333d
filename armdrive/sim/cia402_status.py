"""What a simulated CiA 402 drive says of itself at a moment: statusword and what is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType

from armdrive.sim.cia402_course import arrived
from armdrive.sim.cia402_habits import Homing
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_places import DIGITAL_INPUTS, POSITION_DEMAND, VELOCITY
from firmware_protocol.canopen import (
    FOLLOWING_ERROR,
    MODE_SHOWN,
    POSITION,
    STATUSWORD,
    OperationMode,
    Place,
    StatusBit,
    Statusword,
)

_OF_MODE = StatusBit.REACHED | StatusBit.ACKNOWLEDGED
_OF_MODE_MASK = int(_OF_MODE)
_UPPER_SWITCH = 1
"""The bit of 60FD that is the upper limit switch."""
_WRAP = 1 << 32


def status(node: Node, now_s: float) -> Statusword:
    """Return its statusword."""
    word = node.machine.statusword(_common(node))
    bits = _TOLD.get(node.mode, _told_of_none)(node, word.bits & _OF_MODE, now_s)
    if not node.enabled:
        bits = StatusBit(0) if node.point.moving(now_s) else StatusBit.REACHED
    return Statusword(word.value & ~_OF_MODE_MASK | int(bits))


def read(node: Node, place: Place, now_s: float) -> int:
    """Return what an object that is a number is now."""
    told = LIVE.get(place)
    return node.number_of(place, 0) if told is None else told(node, now_s)


def behind(node: Node, now_s: float) -> int:
    """Return how far the shaft is from where it was told to be; 0 where nothing holds it."""
    return node.point.demand(now_s) - node.shaft if node.holding else 0


def _common(node: Node) -> StatusBit:
    return _common_of(node.astray, node.limited, node.forsaken)


@cache
def _common_of(astray: bool, limited: bool, forsaken: bool) -> StatusBit:
    bits = StatusBit.VOLTAGE
    bits |= StatusBit.FOLLOWING_ERROR if astray else StatusBit(0)
    bits |= StatusBit.LIMITED if limited else StatusBit(0)
    return bits | StatusBit.WARNING if forsaken else bits


def _told_of_profile(node: Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    return bits & ~StatusBit.REACHED if node.withheld else bits


def _told_of_cycle(node: Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    """Return bit 12 while it follows its targets; bit 10 says nothing then."""
    halted = node.machine.points.halted
    return StatusBit(0) if halted else StatusBit.ACKNOWLEDGED


def _told_of_homing(node: Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    if node.homing is Homing.FAILED:
        return StatusBit.FOLLOWING_ERROR | StatusBit.REACHED
    stands = not node.point.moving(now_s) and arrived(node)
    if node.homing.searches or not stands or node.withheld:
        return StatusBit(0)
    home = node.homing is Homing.DONE
    return StatusBit.REACHED | (StatusBit.ACKNOWLEDGED if home else StatusBit(0))


def _told_of_none(node: Node, bits: StatusBit, now_s: float) -> StatusBit:  # noqa: ARG001
    return StatusBit(0) if node.point.moving(now_s) else StatusBit.REACHED


_TOLD: Mapping[int, Callable[[Node, StatusBit, float], StatusBit]] = MappingProxyType(
    {
        OperationMode.PROFILE_POSITION: _told_of_profile,
        OperationMode.CYCLIC_POSITION: _told_of_cycle,
        OperationMode.HOMING: _told_of_homing,
    }
)
LIVE: Mapping[Place, Callable[[Node, float], int]] = MappingProxyType(
    {
        STATUSWORD: lambda node, now_s: status(node, now_s).value,
        MODE_SHOWN: lambda node, _: node.mode,
        POSITION: lambda node, _: _wrapped(node.counts),
        POSITION_DEMAND: lambda node, now_s: _wrapped(node.point.demand(now_s) - node.zero),
        VELOCITY: lambda node, now_s: round(node.point.rate(now_s)),
        FOLLOWING_ERROR: lambda node, now_s: _wrapped(behind(node, now_s)),
        DIGITAL_INPUTS: lambda node, _: node.switch.pressed << _UPPER_SWITCH,
    }
)
"""What is measured when it is asked for."""


def _wrapped(count: int) -> int:
    """Return a count as 32 bits hold it."""
    return (count + _WRAP // 2) % _WRAP - _WRAP // 2
