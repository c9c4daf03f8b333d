"""Backlash: the lost motion between a motor and its joint, in whole steps.

After a reversal, a motor with a backlash of B steps turns B steps before the joint follows. The
steps *taken up* range from 0, when the motor pushes in its negative direction, to B in its positive
direction. Registers count the motor's steps, positions those of the joint:

    position = registers + offset - taken
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from kinematics.spaces import Motors

# The arithmetic of hysteresis: when a motor turns n steps, taken becomes min(max(taken + n, 0), B),
# and the rest of n drives the joint.


def turned(taken: int, width: int, steps: int) -> tuple[int, int]:
    """Return the steps taken up after a motor has turned, and the steps that drove the joint."""
    after = min(max(taken + steps, 0), width)
    return after, steps - (after - taken)


def to_turn(taken: int, width: int, steps: int) -> int:
    """Return the steps a motor has to turn in order to drive its joint by `steps`."""
    if not steps:
        return 0
    return steps + (width - taken if steps > 0 else -taken)


@dataclass(frozen=True, slots=True)
class TakenUp:
    """The steps one motor has taken up: the assumed value, and its least and greatest value."""

    width: int
    at: int
    least: int
    most: int

    @classmethod
    def unknown(cls, width: int) -> TakenUp:
        """Return an unknown value, assumed to be in the middle."""
        return cls(width, width // 2, 0, width)

    @property
    def sure(self) -> bool:
        """Whether the value is known exactly."""
        return self.least == self.most

    def doubted(self) -> TakenUp:
        """Return the same assumption with unknown limits."""
        return TakenUp(self.width, self.at, 0, self.width)

    def centred(self) -> TakenUp:
        """Return the assumption with the smallest possible error."""
        return replace(self, at=(self.least + self.most) // 2)

    def after(self, steps: int) -> TakenUp:
        """Return the value after the motor has turned."""
        values = (turned(each, self.width, steps)[0] for each in (self.at, self.least, self.most))
        return TakenUp(self.width, *values)


TOLERANCE_STEPS = 1  # motors that turn together deviate this far from the straight line at most
MOST_CORNERS = 512  # corners kept of a motion; no device queues more than half as many segments


@dataclass(frozen=True, slots=True)
class _Corner:
    """A point on the path sent since the last known position.

    `turned` and `driven` are the steps of motors and joints up to here; `taken` is the backlash.
    """

    turned: Motors
    driven: Motors
    taken: tuple[TakenUp, ...]

    @property
    def at(self) -> Motors:
        """The assumed steps taken up at this point."""
        return Motors(each.at for each in self.taken)

    def after(self, steps: Motors) -> _Corner:
        """Return the point after the motors have turned further, each in one direction."""
        each = list(zip(self.taken, steps, strict=True))
        driven = Motors(turned(taken.at, taken.width, one)[1] for taken, one in each)
        further = tuple(taken.after(one) for taken, one in each)
        return _Corner(self.turned + steps, self.driven + driven, further)


class Slack:
    """The backlash of all motors, at the acknowledged position and along the path sent since then.

    A stop may come anywhere on the path, so its corners are kept: after a reversal, the registers
    alone do not show how much of a motor's backlash is taken up.
    """

    def __init__(self, widths: Sequence[int]) -> None:
        self.widths = Motors(widths)
        self.any = bool(self.widths.largest)
        self._still = Motors([0] * len(self.widths))
        self._seen: _Corner | None = None
        self.vague = False
        """Whether the latest registers fit the path both before and after a reversal."""
        self._passed = 0.0
        self._stand(map(TakenUp.unknown, self.widths))

    def _stand(self, each: Iterable[TakenUp]) -> None:
        taken = tuple(each)
        self._way = [_Corner(self._still, self._still, taken)]
        self._here = taken
        self._passed = 0.0

    @property
    def taken(self) -> Motors:
        """The steps taken up at the acknowledged position."""
        return Motors(each.at for each in self._here)

    @property
    def ahead(self) -> Motors:
        """The steps taken up at the end of the path sent so far."""
        return self._way[-1].at

    @property
    def unsure(self) -> tuple[int, ...]:
        """The motors, counted from 0, whose backlash may be taken up differently than assumed."""
        return tuple(n for n, each in enumerate(self._here) if not each.sure)

    # -- motion -------------------------------------------------------------------------------

    def to_send(self, steps: Motors) -> Motors:
        """Return the steps to send so that the joints move by `steps` from the end of the path."""
        if not self.any:
            return steps
        each = zip(self.ahead, self.widths, steps, strict=True)
        return Motors(to_turn(*one) for one in each)

    def sends(self, steps: Motors) -> Motors:
        """Extend the path by steps of the motors; return the steps that drive the joints."""
        if not self.any:
            return steps
        last = self._way[-1]
        self._way.append(last.after(steps))
        driven = self._way[-1].driven - last.driven
        if len(self._way) > MOST_CORNERS:
            del self._way[: MOST_CORNERS // 2]
            self._passed = max(self._passed - MOST_CORNERS // 2, 0.0)
        return driven

    def takes_back(self) -> None:
        """Remove the latest extension of the path, which was not sent."""
        if self.any:
            self._way.pop()

    def stand(self) -> None:
        """Drop a path that is no longer being driven."""
        self._stand(self._here)

    def arrive(self) -> None:
        """Move to the end of the path."""
        self._stand(self._way[-1].taken)

    # -- registers ----------------------------------------------------------------------------

    def see(self, turned: Motors) -> Motors:
        """Take the steps turned since the acknowledged position; return those of the joints."""
        if not self.any:
            return turned
        self._seen = self._at(turned)
        return self._seen.driven

    def believe(self) -> None:
        """Take the latest registers as the position."""
        if self._seen is not None:
            self._stand(self._seen.taken)
            self._seen = None

    def _at(self, turned: Motors) -> _Corner:
        """Return the first point of the path at which the motors have turned this far.

        A motion never goes backwards, so points before the latest known one are excluded. If the
        motors have turned without a path, something else turned them, possibly back and forth.
        """
        last = len(self._way) - 2
        distances = [
            (index, *_distance(self._way[index].turned, self._way[index + 1].turned, turned))
            for index in range(max(min(int(self._passed), last), 0), last + 1)
        ]
        fits = [
            (index, share)
            for index, share, off in distances
            if off <= TOLERANCE_STEPS and index + share >= self._passed
        ]
        if fits:
            self._passed = sum(fits[0])
        nearest = min(distances, key=lambda one: one[2], default=(0,))[0]
        point, *others = [self._beyond(index, turned) for index, _ in fits or [(nearest, 0.0)]]
        # Each fit may be off by `TOLERANCE_STEPS`, so two of one point may differ by twice that.
        self.vague = any((other.driven - point.driven).largest > 2 for other in others)
        if len(self._way) == 1 and turned.largest:
            return replace(point, taken=tuple(each.doubted() for each in point.taken))
        return point

    def _beyond(self, index: int, turned: Motors) -> _Corner:
        """Return the point after a corner at which the motors have turned this far."""
        corner = self._way[index]
        return corner.after(turned - corner.turned)

    # -- references ---------------------------------------------------------------------------

    def doubt(self) -> None:
        """Doubt the backlash: something that no register counts may have moved the arm."""
        self._stand(each.doubted() for each in self._here)
        self._seen = None

    def refer(self) -> None:
        """Start again at a reference."""
        self._stand(each.centred() for each in self._here)
        self._seen = None

    def restore(self, taken: Sequence[int], unsure: Sequence[int]) -> bool:
        """Take up the backlash of a record; return whether it fits the arm."""
        self._seen = None
        if not self.any:
            return True
        fits = len(taken) == len(self.widths) and all(
            0 <= each <= width for each, width in zip(taken, self.widths, strict=True)
        )
        if not fits:
            self._stand(map(TakenUp.unknown, self.widths))
            return False
        known = [
            TakenUp(width, each, each, each) for each, width in zip(taken, self.widths, strict=True)
        ]
        self._stand(each.doubted() if motor in unsure else each for motor, each in enumerate(known))
        return True


def _distance(start: Motors, end: Motors, at: Motors) -> tuple[float, float]:
    """Return the share of a straight segment nearest to a point, and the point's distance."""
    delta, made = end - start, at - start
    busiest = max(range(len(delta)), key=lambda motor: abs(delta[motor]))
    share = min(max(made[busiest] / delta[busiest], 0.0), 1.0) if delta[busiest] else 0.0
    return share, max(abs(n - whole * share) for n, whole in zip(made, delta, strict=True))


def doubt_words(names: Sequence[str], slack: Slack) -> str:
    """Return a notice if a reference was taken while the backlash was on an unknown side."""
    if not slack.unsure:
        return ""
    doubted = ", ".join(names[motor] for motor in slack.unsure)
    return (
        f"it is not known in which direction the backlash of {doubted} is taken up, so the "
        "position may be off by half of it. For a better reference, jog each of these motors "
        "towards the reference posture by more than its backlash, then set the reference again"
    )
