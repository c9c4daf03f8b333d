"""Lost motion between a motor and what it drives: where every motor is within it, in whole steps.

A motor whose train has a backlash of B steps turns B of them after a reversal before anything
follows. Its *taken* is how far it has gone through them: 0 where it pushes in its negative
direction, B in its positive one. Registers count the motor, positions what it drives:

    position = registers + offset - taken
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from kinematics.spaces import Motors

# Where every motor is within its backlash, and what that is at least and at most, in steps.
#
# Between what a motor turns and what it drives is the arithmetic of hysteresis: when it turns by n
# steps, its taken becomes min(max(taken + n, 0), B), and what is left of n is what has been
# driven.


def turned(taken: int, width: int, steps: int) -> tuple[int, int]:
    """Return taken after a motor has turned by some steps, and the steps that were driven."""
    after = min(max(taken + steps, 0), width)
    return after, steps - (after - taken)


def to_turn(taken: int, width: int, steps: int) -> int:
    """Return how far a motor has to turn so that so many steps are driven."""
    if not steps:
        return 0
    return steps + (width - taken if steps > 0 else -taken)


@dataclass(frozen=True, slots=True)
class TakenUp:
    """Where one motor is within its backlash: what is assumed, and what it is at least and most."""

    width: int
    at: int
    least: int
    most: int

    @classmethod
    def unknown(cls, width: int) -> TakenUp:
        """Return the middle, as nobody knows better."""
        return cls(width, width // 2, 0, width)

    @property
    def sure(self) -> bool:
        """Whether it is known."""
        return self.least == self.most

    def doubted(self) -> TakenUp:
        """Return the same as an assumption."""
        return TakenUp(self.width, self.at, 0, self.width)

    def centred(self) -> TakenUp:
        """Return the assumption that is wrong by least."""
        return replace(self, at=(self.least + self.most) // 2)

    def after(self, steps: int) -> TakenUp:
        """Return this when the motor has turned by some steps."""
        places = (turned(each, self.width, steps)[0] for each in (self.at, self.least, self.most))
        return TakenUp(self.width, *places)


TOLERANCE_STEPS = 1
"""Motors that turn together are so far at most from the straight way between two corners."""

MOST_CORNERS = 512
"""So many pieces of a motion are remembered; no device has more of them ahead than half of it."""


@dataclass(frozen=True, slots=True)
class _Corner:
    """A place on the way since the arm was last known: steps turned and driven, and taken there."""

    turned: Motors
    driven: Motors
    taken: tuple[TakenUp, ...]

    @property
    def at(self) -> Motors:
        """What is taken there."""
        return Motors(each.at for each in self.taken)

    def after(self, steps: Motors) -> _Corner:
        """Return the place at which the motors are when they have turned further, all one way."""
        each = list(zip(self.taken, steps, strict=True))
        driven = Motors(turned(taken.at, taken.width, one)[1] for taken, one in each)
        further = tuple(taken.after(one) for taken, one in each)
        return _Corner(self.turned + steps, self.driven + driven, further)


class Slack:
    """The backlash of all motors: at the acknowledged position, and along what was sent since.

    A stop may come anywhere on that way, so that it is remembered: of a motor that has reversed,
    the registers alone do not tell how its backlash is taken up.
    """

    def __init__(self, widths: Sequence[int]) -> None:
        self.widths = Motors(widths)
        self.any = bool(self.widths.largest)
        self._still = Motors([0] * len(self.widths))
        self._seen: _Corner | None = None
        self.vague = False
        """Whether what was seen last may be before a reversal or behind it, steps apart."""
        self._passed = 0.0
        self._stand(map(TakenUp.unknown, self.widths))

    def _stand(self, each: Iterable[TakenUp]) -> None:
        taken = tuple(each)
        self._way = [_Corner(self._still, self._still, taken)]
        self._here = taken
        self._passed = 0.0

    @property
    def taken(self) -> Motors:
        """What is taken at the acknowledged position."""
        return Motors(each.at for each in self._here)

    @property
    def ahead(self) -> Motors:
        """What is taken where the way leads that has been sent."""
        return self._way[-1].at

    @property
    def unsure(self) -> tuple[int, ...]:
        """The motors, counted from 0, that may push in another direction than is assumed."""
        return tuple(n for n, each in enumerate(self._here) if not each.sure)

    # -- motion -------------------------------------------------------------------------------

    def to_send(self, steps: Motors) -> Motors:
        """Return what motors have to turn for some steps, from where the way leads."""
        if not self.any:
            return steps
        each = zip(self.ahead, self.widths, steps, strict=True)
        return Motors(to_turn(*one) for one in each)

    def sends(self, steps: Motors) -> Motors:
        """Note what motors are about to turn further; return what that drives."""
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
        """Forget what was noted last: it is not sent."""
        if self.any:
            self._way.pop()

    def stand(self) -> None:
        """Forget a way that is no longer driven."""
        self._stand(self._here)

    def arrive(self) -> None:
        """Note that the way was driven to its end."""
        self._stand(self._way[-1].taken)

    # -- what registers show ------------------------------------------------------------------

    def see(self, turned: Motors) -> Motors:
        """Take how far motors have turned since they were acknowledged; return what that drove."""
        if not self.any:
            return turned
        self._seen = self._at(turned)
        return self._seen.driven

    def believe(self) -> None:
        """Take what was seen last for the truth."""
        if self._seen is not None:
            self._stand(self._seen.taken)
            self._seen = None

    def _at(self, turned: Motors) -> _Corner:
        """Return the place on the way at which motors have turned so far: the first that fits.

        A motion only goes on, so that no place fits before one that was seen. Motors that nobody
        has sent anywhere were turned by others, forth and back perhaps.
        """
        last = len(self._way) - 2
        beside = [
            (index, *_beside(self._way[index].turned, self._way[index + 1].turned, turned))
            for index in range(max(min(int(self._passed), last), 0), last + 1)
        ]
        fits = [
            (index, share)
            for index, share, off in beside
            if off <= TOLERANCE_STEPS and index + share >= self._passed
        ]
        if fits:
            self._passed = sum(fits[0])
        nearest = min(beside, key=lambda one: one[2], default=(0,))[0]
        place, *others = [self._behind(index, turned) for index, _ in fits or [(nearest, 0.0)]]
        self.vague = any((other.driven - place.driven).largest > 2 for other in others)
        if len(self._way) == 1 and turned.largest:
            return replace(place, taken=tuple(each.doubted() for each in place.taken))
        return place

    def _behind(self, index: int, turned: Motors) -> _Corner:
        """Return where motors are that have turned so far, all of it since a corner one way."""
        corner = self._way[index]
        return corner.after(turned - corner.turned)

    # -- references ---------------------------------------------------------------------------

    def doubt(self) -> None:
        """Note that something may have turned the arm that no register counts."""
        self._stand(each.doubted() for each in self._here)
        self._seen = None

    def refer(self) -> None:
        """Begin anew at a place that somebody vouches for."""
        self._stand(each.centred() for each in self._here)
        self._seen = None

    def restore(self, taken: Sequence[int], unsure: Sequence[int]) -> bool:
        """Take up what a record says; False where it says nothing that fits."""
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


def _beside(start: Motors, end: Motors, at: Motors) -> tuple[float, float]:
    """Return the share of a straight piece at which a place lies, and how far beside it."""
    delta, made = end - start, at - start
    busiest = max(range(len(delta)), key=lambda motor: abs(delta[motor]))
    share = min(max(made[busiest] / delta[busiest], 0.0), 1.0) if delta[busiest] else 0.0
    return share, max(abs(n - whole * share) for n, whole in zip(made, delta, strict=True))


def doubt_words(names: Sequence[str], slack: Slack) -> str:
    """Return the notice of a reference that was taken with the backlash on an unknown side."""
    if not slack.unsure:
        return ""
    doubted = ", ".join(names[motor] for motor in slack.unsure)
    return (
        f"nobody knows which way the backlash of {doubted} is taken up, so that the position may "
        "be off by half of it: for a better one, come to the reference by jogs of armdrive, each "
        "motor further than its backlash, and refer once more"
    )
