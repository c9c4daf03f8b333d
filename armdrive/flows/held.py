"""A held jog: the next leg of it, decided at the last moment, for as long as somebody holds it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from armdrive.core import Coordinates
from armdrive.engine import Flow
from armdrive.errors import ArmError, Refused
from armdrive.flows.jog_aims import allowed, capped, check_jog, displaced, rates_of, runs_on_s
from armdrive.flows.motion import next_share, paced_move
from armdrive.flows.streaming import SEGMENTS_AHEAD, Way, stream_held
from armdrive.planning import Leg
from kinematics import KinematicsError

if TYPE_CHECKING:
    from armdrive.core import Hold
    from armdrive.flows.exchange import Wire
    from armdrive.planning import Speeds

NEARLY = 1e-3
"""So much longer than it should be a leg may last before it is solved anew."""

SHORTER_TRIES = 8
"""How often a held burst is made shorter before it is given up."""


def is_held(wire: Wire) -> bool:
    """Tell whether somebody holds a jog now."""
    hold = wire.core.hold
    return hold is not None and hold.until_s > wire.now_s and not wire.core.tempo.paused


def held_burst(wire: Wire, speeds: Speeds) -> Flow[bool]:
    """Go on with the held jog for a burst; False where a bound leaves nowhere to go.

    A device that queues segments is driven for as long as the jog is held.
    """
    core = wire.core
    if core.controller.abilities.queued_segments:
        ways = _held_ways(wire, speeds)
        ahead_s = core.config.motion.jog_burst_s
        yield from stream_held(wire, ways, ahead_s, lambda: not is_held(wire) or bool(core.nudges))
        return is_held(wire)
    leg = _next_held(wire, speeds, core.coordinates, core.config.motion.jog_burst_s, _fitting)
    if leg is None:
        return False
    yield from paced_move(wire, leg.end, leg.duration_s, lambda: not is_held(wire))
    return True


def _held_ways(wire: Wire, speeds: Speeds) -> Iterator[Way]:
    """Give the points of a held jog, each from where the one before has led."""
    core = wire.core
    here = core.coordinates
    part_s = core.config.motion.jog_burst_s / SEGMENTS_AHEAD
    while not wire.stopping and is_held(wire):
        leg = _next_held(wire, speeds, here, part_s, _in_time)
        if leg is None:
            return
        here = leg.end
        yield leg.end, leg.duration_s


Share = Callable[["Wire", Leg, float], float]
"""How much of a leg fits into a burst of so many seconds."""


def _fitting(wire: Wire, leg: Leg, longest_s: float) -> float:
    return next_share(wire, leg, longest_s, 0.0)


def _in_time(_wire: Wire, leg: Leg, longest_s: float) -> float:
    """Of a device that keeps its own time: only the joints' speeds make a leg last longer."""
    return 1.0 if leg.duration_s <= longest_s * (1.0 + NEARLY) else longest_s / leg.duration_s


def _next_held(
    wire: Wire, speeds: Speeds, start: Coordinates, longest_s: float, share_of: Share
) -> Leg | None:
    """Return the next leg of the held jog, None where it ends: let go, or at a bound."""
    core = wire.core
    hold = core.hold
    if hold is None:
        return None
    try:
        check_jog(core, hold.jog)
        leg = _held_leg(wire, speeds, hold, start, longest_s, share_of)
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        core.hold = None
        return None
    if leg.start == leg.end:
        core.hold = None
        return None
    return leg


def _held_leg(
    wire: Wire, speeds: Speeds, hold: Hold, start: Coordinates, longest_s: float, share_of: Share
) -> Leg:
    """Return what one burst covers; near a guard or the edge of the reach, as much as there is.

    A leg that is too long for a burst on this device is solved anew for a shorter time: a share
    of its joint motion would leave the straight line of a Cartesian jog. An arm that runs on
    while it stops goes slower, so that it would stop before a guard.
    """
    core = wire.core
    speed = capped(core, hold.speed) * core.tempo.override
    rates = rates_of(core, hold.jog, speeds)
    burst_s, further_s = longest_s, runs_on_s(core)
    refused: ArmError | KinematicsError | None = None
    for _ in range(SHORTER_TRIES):
        try:
            there = displaced(core, start, rates, speed * burst_s)
            goal = allowed(core, start, there, further_s / burst_s)
        except (ArmError, KinematicsError) as refusal:
            refused = refused or refusal
            if further_s > 0.0:
                speed /= 2.0
            else:
                burst_s /= 2.0
            continue
        leg = Leg(start, goal, max(speeds.duration_s(start, goal, speed), burst_s))
        share = share_of(wire, leg, longest_s)
        if share >= 1.0:
            return leg
        burst_s *= share
    raise refused or Refused("no burst is short enough for this device: see motion.jog_burst_s")
