"""A held jog: the next leg of its course, decided at the last moment, while it is held."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from armdrive.budget import segment_s
from armdrive.errors import ArmError
from armdrive.flow import Flow
from armdrive.flows.jog_aims import require_audit, wish_of
from armdrive.flows.motion import next_share, paced_move
from armdrive.flows.streaming import Way, stream_held
from armdrive.intents import Space
from armdrive.jog_bounds import Ended
from kinematics import KinematicsError

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire
    from armdrive.intents import Hold
    from armdrive.jog_course import JogCourse, Proposal
    from armdrive.whereabouts import Coordinates

SHORTER_TRIES = 3
"""How often a line's burst is solved anew: by then a share of its joint motion is as straight."""


def is_held(wire: Wire) -> bool:
    """Tell whether somebody holds a jog now."""
    hold = wire.core.hold
    return hold is not None and hold.until_s > wire.now_s and not wire.core.tempo.paused


def held_burst(wire: Wire, course: JogCourse) -> Flow[bool]:
    """Go on with the held jog for a burst; False where a bound leaves nowhere to go.

    A device that queues segments is driven for as long as the jog is held.
    """
    core = wire.core
    if core.controller.abilities.queued_segments:
        held = _Held(wire, course)
        ahead_s = core.config.motion.jog_burst_s
        let_go = lambda: not is_held(wire) or bool(core.nudges)  # noqa: E731
        yield from stream_held(wire, held.ways(), ahead_s, let_go)
        held.end()
        return is_held(wire)
    hold = core.hold
    found = None if hold is None else _fitting(wire, course, hold)
    if found is None:
        return False
    course.take(found, wire.now_s)
    leg = found.leg
    yield from paced_move(wire, leg.end, leg.duration_s, lambda: not is_held(wire))
    return True


class _Held:
    """The points of a held jog that is queued, and the hold that has led to a bound.

    What leads to the bound is driven to its end, so that the hold is given up only behind it.
    """

    def __init__(self, wire: Wire, course: JogCourse) -> None:
        self._wire = wire
        self._course = course
        self._ended: Hold | None = None

    def ways(self) -> Iterator[Way]:
        """Give points, each from where the one before has led."""
        wire, core = self._wire, self._wire.core
        here = core.coordinates
        part_s = segment_s(core.config.motion.jog_burst_s)
        while not wire.stopping and is_held(wire) and core.hold is not None:
            hold = core.hold
            found = _proposed(wire, self._course, hold, here, part_s)
            if found is None:
                self._ended = hold
                return
            self._course.take(found, wire.now_s)
            here = found.leg.end
            yield here, found.leg.duration_s

    def end(self) -> None:
        """Give up the hold that led to a bound, unless somebody holds another by now."""
        self._course.stand()
        if self._ended is not None:
            _give_up(self._wire, self._ended)


def _fitting(wire: Wire, course: JogCourse, hold: Hold) -> Proposal | None:
    """Return a leg that this device ends within a burst; None where the jog ends here.

    A long line that takes too long is asked for anew, for a shorter time: a share of its joint
    motion would not be straight.
    """
    core, tries = wire.core, SHORTER_TRIES
    longest_s = time_s = core.config.motion.jog_burst_s
    while (found := _proposed(wire, course, hold, core.coordinates, time_s)) is not None:
        share, tries = next_share(wire, found.leg, longest_s, 0.0), tries - 1
        if share >= 1.0 or not tries or hold.jog.space is Space.JOINT:
            return found.shortened(share)
        time_s *= share
    _give_up(wire, hold)
    return None


def _proposed(
    wire: Wire, course: JogCourse, hold: Hold, start: Coordinates, time_s: float
) -> Proposal | None:
    """Return the next leg of the held jog; None where it ends, with the reason as the notice."""
    core = wire.core
    try:
        found = course.propose(wish_of(core, hold), start, time_s, wire.now_s)
        if isinstance(found, Ended):
            tell(wire, found)
            course.note = found.note
            return None
        require_audit(core, found.leg)
    except (ArmError, KinematicsError) as refusal:
        core.notify(str(refusal), refusal)
        return None
    if found.note != course.note:  # also of nothing any more, as when it leads back
        core.notice = course.note = found.note
    return found


def tell(wire: Wire, ended: Ended) -> None:
    """Have the status say why a jog has ended, where there is a reason."""
    if ended.cause is not None:
        wire.core.notify(ended.note, ended.cause)
    elif ended.note:
        wire.core.notice = ended.note


def _give_up(wire: Wire, hold: Hold) -> None:
    """Forget a hold and its renewals, but not another that somebody has begun meanwhile."""
    now = wire.core.hold
    if now is not None and now.jog == hold.jog:
        wire.core.hold = None
