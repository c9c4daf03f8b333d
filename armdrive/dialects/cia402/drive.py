"""One CiA 402 drive as the driver knows it: what it said last, and where it is held."""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.dialects.cia402.master import NodeMessage
from firmware_protocol.canopen import DriveState, NodeState, Statusword


@dataclass(slots=True)
class Cia402Drive:
    """Increments, seconds. `place` is where it holds its motor, or was sent last."""

    node: int
    name: str
    tremble: int
    """By how much less its position may differ while it stands."""
    word: Statusword | None = None
    mode: int = 0
    """The mode that it shows."""
    seen: int = 0
    place: int = 0
    told_s: float = -math.inf
    """When it said so last."""
    heard_s: float = -math.inf
    """When anything was heard of it last."""
    missed: int = 0
    """How many SYNCs ago that was."""
    still_s: float = math.inf
    """Since when it has not turned."""
    still_at: int = 0
    network: NodeState | None = None
    """What its heartbeat said last that it is; None since it was ordered to be something."""
    booted: bool = False
    """Whether it has begun anew since it was set up."""
    error: str = ""
    """What it reported last that is wrong with it."""
    reported: bool = False
    """Whether what is wrong with it has been told."""
    fresh: bool = False
    """Whether it has not been moved since it was found."""

    def __str__(self) -> str:
        return f"drive {self.node} ({self.name})"

    @property
    def state(self) -> DriveState | None:
        """What it says it is; None where nobody knows."""
        return None if self.word is None else self.word.state

    @property
    def holds(self) -> bool:
        """Whether its motor has current, as far as is known."""
        return self.state is not None and self.state.holds

    def tell(self, told: NodeMessage, now_s: float) -> None:
        """Take note of what it says of itself."""
        self.word, self.mode, self.seen = told.word, told.mode, told.position
        self.told_s, self.missed = now_s, 0
        self.network = NodeState.OPERATIONAL  # or it would not have said so
        if abs(told.position - self.still_at) > self.tremble or math.isinf(self.still_s):
            self.still_at, self.still_s = told.position, now_s

    def stands(self, since_s: float, for_s: float) -> bool:
        """Tell whether it has been seen not to turn for so long, all of it after a moment."""
        return self.told_s - max(self.still_s, since_s) >= for_s - 1e-9

    def rest(self) -> None:
        """Take it for being held where it is."""
        self.place, self.fresh = self.seen, False

    def near(self, reach: int) -> bool:
        """Tell whether it is where it should be."""
        return abs(self.seen - self.place) <= reach

    def count(self, reach: int) -> int:
        """Return its position as a register: that of its place where it stands within reach."""
        return self.place if self.near(reach) else self.seen

    def found_near(self, there: int) -> int:
        """Return its register: what it was left at, if it was found to tremble about that."""
        if self.fresh and abs(self.place - there) <= self.tremble:
            self.place = there
        return self.place
