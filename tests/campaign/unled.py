"""What the others do while one drive obeys no more: motors are coupled, and nobody knows at once.

A drive in another mode stands, and says so to the next order that it is given. Until then the
others go on, and a joint that two motors turn together may leave the way, and its limit. What is
excused is that way alone: of the joints which that motor turns, until all could be at rest. The
same holds where a program dies between the orders that it gives to one drive after the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from armdrive.dialects.bus.ledger import REJECTION_LIMIT, START_WINDOW_S
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.mks.settings import MksSettings

from .stage import Stage

ORDER_PERIODS = 2.0
"""A drive in motion is given an order after so many periods of steering, at the latest."""
SHOWN_PERIODS = 3.0
"""What a drive is shows at the SYNC behind the one at which it became so, and is looked at then."""
ASKED_S = 0.01
"""Three questions and their answers take so long on the bus, and then a stop."""


@dataclass(slots=True)
class Unled:
    """A drive that obeys nobody for a while. Seconds; angles in rad."""

    joints: frozenset[str]
    """Those that its motor turns."""
    ends_s: float
    known_s: float
    """So long after the arm's first motion without it, all may go on."""
    _until_s: float = math.inf

    def begin(self) -> None:
        """Hear that another command begins: it has to find out for itself."""
        self._until_s = math.inf

    def excuses(self, time_s: float) -> bool:
        """Tell whether a motion is one of which nobody can know that it goes astray."""
        if math.isinf(self._until_s) and time_s <= self.ends_s:
            self._until_s = time_s + self.known_s
        return math.isfinite(self._until_s) and time_s <= self._until_s

    def let_pass(self, allowed: dict[str, float], beyond: Mapping[str, float]) -> None:
        """Have joints be as far beyond their limits as they have come: no farther, later."""
        for joint in self.joints & beyond.keys():
            allowed[joint] = max(allowed.get(joint, 0.0), beyond[joint])


def unled(stage: Stage, motor: int, for_s: float) -> Unled:
    """Return the excuse of a drive, its motor counted from 0, that obeys no more from now on."""
    rows = zip(stage.world.joints.names, stage.world.body.transmission.inverse, strict=False)
    turned = frozenset(name for name, row in rows if row[motor])
    return Unled(turned, stage.now_s + for_s, _known_s(stage))


def half_told(stage: Stage) -> Unled | None:
    """Return the excuse of drives of which some were given their orders as the program died.

    Each is ordered by a frame of its own, and goes to the end of its order: a joint that several
    turn is where it should be once all have theirs. None where one frame has all of them act.
    """
    if not isinstance(stage.config.device, MksSettings) or stage.arm is None:
        return None
    return half_heard(stage, 0.0)


def cut_off(stage: Stage) -> None:
    """Excuse drives that are cut off while frames overtake each other.

    An order that waits to be overtaken never comes then, and its drive ends at the one before.
    """
    if stage.now_s < stage.late_orders_until_s and (excuse := half_told(stage)) is not None:
        stage.watch.unled = excuse


def half_heard(stage: Stage, for_s: float) -> Unled | None:
    """Return the excuse of drives each of which may miss what it is told for so long.

    None while no program is connected: then none of them turns.
    """
    if stage.arm is None:
        return None
    rows = zip(stage.world.joints.names, stage.world.body.transmission.inverse, strict=False)
    shared = frozenset(name for name, row in rows if sum(map(bool, row)) > 1)
    ends_s = for_s + stage.arm.status.silent_time_s
    return Unled(shared, stage.now_s + ends_s, ends_s)


def _known_s(stage: Stage) -> float:
    """Return how long a motion goes on without one drive, until all stand."""
    settings = stage.config.device
    if isinstance(settings, Cia402Settings):  # each tells its mode with every SYNC
        return SHOWN_PERIODS * settings.period_ms / 1000.0 + settings.quick_stop_s + ASKED_S
    assert isinstance(settings, MksSettings)
    notice_s = ORDER_PERIODS * settings.segment_s + REJECTION_LIMIT * START_WINDOW_S + ASKED_S
    brakes_s = 0.0 if stage.arm is None else getattr(stage.arm.core.controller, "ramp_s", 0.0)
    return notice_s + brakes_s
