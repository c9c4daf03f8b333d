"""What masters may write into the objects of a simulated CiA 402 drive, and what that changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

from armdrive.sim.cia402.motion import METHODS, follow, set_mode
from armdrive.sim.cia402.node import Cia402Node
from armdrive.sim.cia402.objects import (
    ERROR_COUNT,
    HOMING_METHOD,
    PDO_PARAMETERS,
    PERIOD,
    PERIOD_POWER,
)
from armdrive.sim.cia402.states import control
from firmware_protocol.canopen import (
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    FAULT_REACTION_OPTION,
    HEARTBEAT_REACTION,
    MODE,
    NODE_MAX,
    PRODUCER_HEARTBEAT_MS,
    PROFILE_ACCELERATION,
    PROFILE_DECELERATION,
    QUICK_STOP_DECELERATION,
    QUICK_STOP_OPTION,
    TARGET_POSITION,
    AbortCode,
    HeartbeatWatch,
    NodeState,
    OperationMode,
    Place,
    QuickStopOption,
    Value,
)

_RANGES: Mapping[Place, Collection[int]] = MappingProxyType(
    {
        QUICK_STOP_OPTION: frozenset(QuickStopOption),
        HEARTBEAT_REACTION: range(4),
        FAULT_REACTION_OPTION: range(5),
        HOMING_METHOD: METHODS,
        PERIOD: range(1, 256),
        PERIOD_POWER: range(-4, 1),
        PROFILE_ACCELERATION: range(1, 1 << 32),
        PROFILE_DECELERATION: range(1, 1 << 32),
        QUICK_STOP_DECELERATION: range(1, 1 << 32),
        ERROR_COUNT: range(1),
    }
)


def refusal(node: Cia402Node, place: Place, value: Value) -> AbortCode | None:
    """Return why an object may not become a value that is one of its type; None where it may."""
    if not isinstance(value, int):
        return None
    if place == MODE:
        return None if value in (OperationMode.NONE, *node.quirks.modes) else AbortCode.VALUE
    if place in _RANGES:
        return None if value in _RANGES[place] else AbortCode.VALUE
    if place == CONSUMER_HEARTBEAT:
        return None if value >> 16 <= NODE_MAX else AbortCode.VALUE
    if place.index in PDO_PARAMETERS:
        if node.nmt.state is NodeState.OPERATIONAL:
            return AbortCode.DEVICE_STATE
        return node.pdos.refusal(place, value)
    return None


def written(node: Cia402Node, places: Collection[Place], now_s: float) -> None:
    """Do what follows from objects that have been written together."""
    followed, due = _follows(node), _due_of(tuple(places))
    for act in due.acts:
        act(node, now_s)
    if _follows(node) and (due.aims or not followed):
        follow(node, now_s)
    if due.rebuilds:
        node.pdos.rebuild()


def watched(node: Cia402Node) -> HeartbeatWatch | None:
    """Return whose silence it minds, and when."""
    return HeartbeatWatch.of(node.number_of(CONSUMER_HEARTBEAT, 0))


def _mode(node: Cia402Node, now_s: float) -> None:
    set_mode(node, node.number_of(MODE, 0), now_s)


def _follows(node: Cia402Node) -> bool:
    """Tell whether it goes wherever its target is: also to an old one, when that begins."""
    cyclic = node.mode == OperationMode.CYCLIC_POSITION
    return cyclic and node.enabled and not node.machine.points.halted


def _beat(node: Cia402Node, now_s: float) -> None:
    node.beat_on(now_s)


def _watch(node: Cia402Node, now_s: float) -> None:  # noqa: ARG001
    """Begin to watch anew, with the first heartbeat that comes."""
    node.silent_s, node.forsaken = math.inf, False


def _quick_stop(node: Cia402Node, now_s: float) -> None:  # noqa: ARG001
    node.machine.quick_stop = QuickStopOption(node.number_of(QUICK_STOP_OPTION, 2))


_ACTS: Mapping[Place, Callable[[Cia402Node, float], None]] = MappingProxyType(
    {
        QUICK_STOP_OPTION: _quick_stop,
        PRODUCER_HEARTBEAT_MS: _beat,
        CONSUMER_HEARTBEAT: _watch,
        MODE: _mode,
        CONTROLWORD: control,
    }
)
"""In the order in which what came together is acted on: the mode before the controlword."""


@dataclass(frozen=True, slots=True)
class _Due:
    """What objects ask for that have been written together."""

    acts: tuple[Callable[[Cia402Node, float], None], ...]
    aims: bool
    """Whether there is a target among them."""
    rebuilds: bool
    """Whether a PDO is another one with them."""


@lru_cache(maxsize=512)
def _due_of(places: tuple[Place, ...]) -> _Due:
    """Work it out once: PDOs bring the same objects over and over."""
    return _Due(
        tuple(act for place, act in _ACTS.items() if place in places),
        TARGET_POSITION in places,
        any(place.index in PDO_PARAMETERS for place in places),
    )
