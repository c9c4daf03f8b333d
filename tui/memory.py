"""What the desk remembers until the next time: where it was, and how it was set.

Nothing of it moves anything: the keys begin disarmed whatever was left.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from armdrive.moves import Space
from armdrive.storage import files as places
from armdrive.storage.files import DISK, replace_file
from tui import goal_form
from tui.goal_form import Manner
from tui.settings import INCREMENTS, SPEEDS, Settings

MOST_BYTES = 65536


@dataclass(frozen=True, slots=True)
class Remembered:
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


def recall(path: Path) -> Remembered:
    """Return what was left; whatever cannot be read or makes no sense is forgotten."""
    try:
        found = json.loads(DISK.read_own(path, MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return Remembered()
    if not isinstance(found, dict):
        return Remembered()
    known: dict[str, Any] = {
        field.name: found[field.name]
        for field in fields(Remembered)
        if field.name in found and _fits(found[field.name], field.default)
    }
    return Remembered(**known)


def remember(path: Path, what: Remembered) -> None:
    """Replace what is remembered. Raises `OSError`."""
    replace_file(path, json.dumps(asdict(what), indent=1))


def set_as(settings: Settings, what: Remembered) -> Settings:
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


def manner_of(what: Remembered) -> Manner:
    """Return how goals were given and gone to at the move screen, as far as that makes sense."""
    manner = Manner()
    if what.move_mode in [space.value for space in Space]:
        manner = replace(manner, cartesian=what.move_mode == Space.CARTESIAN.value)
    if what.move_speed in goal_form.SPEEDS:
        manner = replace(manner, speed=what.move_speed)
    return manner


def left_at(
    settings: Settings, manner: Manner, screen: str, look: str, *, instructed: bool
) -> Remembered:
    """Return what is to be remembered of a desk."""
    move_space = Space.CARTESIAN if manner.cartesian else Space.JOINT
    return Remembered(
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
