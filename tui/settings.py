"""What the operator has set on the jog and move screens, and what is remembered until next time."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from armdrive.errors import BadRequest
from armdrive.motion.frames import BASE
from armdrive.moves import Jog, Space
from armdrive.storage import files as places
from armdrive.storage.files import DISK, replace_file
from tui.keys.table import JOG_PAIRS, JogPair

INCREMENTS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Sizes of one increment, in degrees for angles and mm for the rest."""

SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0)
"""Fractions of the joint speed limits, for jogging and for planned motion."""


@dataclass(frozen=True, slots=True)
class JogSettings:
    """Mode, increment and speed. Every change gives new settings; the ends of a row hold.

    `pairs` are the jog keys of the arm, `frames` the frames it knows.
    """

    space: Space = Space.JOINT
    increment_index: int = INCREMENTS.index(2.0)
    speed_index: int = SPEEDS.index(0.25)
    pairs: tuple[JogPair, ...] = JOG_PAIRS
    frames: tuple[str, ...] = (BASE,)
    frame: str = BASE

    @property
    def cartesian(self) -> bool:
        """Whether keys move the finger tips rather than joints."""
        return self.space is Space.CARTESIAN

    @property
    def increment(self) -> float:
        """One increment, in degrees or mm."""
        return INCREMENTS[self.increment_index]

    @property
    def speed(self) -> float:
        """The fraction of the speed limits."""
        return SPEEDS[self.speed_index]

    def other_mode(self) -> JogSettings:
        """Switch between joint and Cartesian mode."""
        return replace(self, space=Space.JOINT if self.cartesian else Space.CARTESIAN)

    def with_next_frame(self) -> JogSettings:
        """Go on to the next frame, from the last one to the first."""
        place = self.frames.index(self.frame) + 1
        return replace(self, frame=self.frames[place % len(self.frames)])

    def with_increment(self, steps: int) -> JogSettings:
        """Go along the row of increments."""
        index = min(max(self.increment_index + steps, 0), len(INCREMENTS) - 1)
        return replace(self, increment_index=index)

    def with_speed(self, steps: int) -> JogSettings:
        """Go along the row of speeds."""
        return replace(self, speed_index=min(max(self.speed_index + steps, 0), len(SPEEDS) - 1))

    def increment_of(self, key: str) -> Jog:
        """Return the jog of one tap on a jog key: a distance."""
        return self._jog(key, self.increment)

    def direction_of(self, key: str) -> Jog:
        """Return the jog of a held jog key: a direction."""
        return self._jog(key, 1.0)

    @property
    def rows(self) -> tuple[JogPair, ...]:
        """The pairs that have a row of the screen: those of letters."""
        return tuple(pair for pair in self.pairs if len(pair.plus) == 1)

    def pair_of(self, key: str) -> JogPair | None:
        """Return the pair that a key belongs to, None where this arm has no such axis."""
        return next((pair for pair in self.pairs if key in (pair.plus, pair.minus)), None)

    def _jog(self, key: str, amount: float) -> Jog:
        pair = self.pair_of(key)
        if pair is None:
            raise BadRequest(f"no axis of this arm is moved by the key {key}")
        sign = 1.0 if key == pair.plus else -1.0
        frame = self.frame if self.cartesian else BASE
        return Jog(self.space, ((pair.axis(cartesian=self.cartesian), sign * amount),), frame)


@dataclass(frozen=True, slots=True)
class Manner:
    """How goals are given and gone to: what is kept from one form, or one desk, to the next."""

    cartesian: bool = True
    speed: float = 0.5


# What the desk remembers until the next time. None of it moves anything: the keys begin disarmed
# whatever was left.

MOST_BYTES = 65536


@dataclass(frozen=True, slots=True)
class DeskMemory:
    """What was left. Empty words and noughts where nothing is known."""

    screen: str = ""
    look: str = ""
    mode: str = ""
    frame: str = ""
    increment: float = 0.0
    speed: float = 0.0
    instructed: bool = False
    """Whether somebody has read the first screen."""
    move_mode: str = ""
    move_speed: float = 0.0


def memory_file() -> Path:
    """Return the file that is remembered in."""
    return places.states() / "desk.json"


def recall(path: Path) -> DeskMemory:
    """Return what was left; whatever cannot be read or makes no sense is forgotten."""
    try:
        found = json.loads(DISK.read_own(path, MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return DeskMemory()
    if not isinstance(found, dict):
        return DeskMemory()
    known: dict[str, Any] = {
        field.name: found[field.name]
        for field in fields(DeskMemory)
        if field.name in found and _fits(found[field.name], field.default)
    }
    return DeskMemory(**known)


def remember(path: Path, what: DeskMemory) -> None:
    """Replace what is remembered. Raises `OSError`."""
    replace_file(path, json.dumps(asdict(what), indent=1))


def set_as(settings: JogSettings, what: DeskMemory) -> JogSettings:
    """Return the settings as they were left, as far as they exist for this arm."""
    if what.mode in [space.value for space in Space]:
        settings = replace(settings, space=Space(what.mode))
    if what.frame in settings.frames:
        settings = replace(settings, frame=what.frame)
    if what.increment in INCREMENTS:
        settings = replace(settings, increment_index=INCREMENTS.index(what.increment))
    if what.speed in SPEEDS:
        settings = replace(settings, speed_index=SPEEDS.index(what.speed))
    return settings


def manner_of(what: DeskMemory) -> Manner:
    """Return how goals were given and gone to at the move screen, as far as that makes sense."""
    manner = Manner()
    if what.move_mode in [space.value for space in Space]:
        manner = replace(manner, cartesian=what.move_mode == Space.CARTESIAN.value)
    if what.move_speed in SPEEDS:
        manner = replace(manner, speed=what.move_speed)
    return manner


def left_at(
    settings: JogSettings, manner: Manner, screen: str, look: str, *, instructed: bool
) -> DeskMemory:
    """Return what is to be remembered of a desk."""
    move_space = Space.CARTESIAN if manner.cartesian else Space.JOINT
    return DeskMemory(
        screen=screen,
        look=look,
        mode=settings.space.value,
        frame=settings.frame,
        increment=settings.increment,
        speed=settings.speed,
        instructed=instructed,
        move_mode=move_space.value,
        move_speed=manner.speed,
    )


def _fits(value: object, like: object) -> bool:
    if isinstance(like, bool) or isinstance(value, bool):
        return isinstance(value, bool) and isinstance(like, bool)
    if isinstance(like, float):
        return isinstance(value, int | float)
    return isinstance(value, str)
