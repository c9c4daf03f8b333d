"""What the operator has set: how keys move the arm, how the desk looks; and what is remembered."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from textual.theme import Theme

from armdrive.errors import BadRequest
from armdrive.moves import BASE_FRAME, Jog, Space
from armdrive.status import Status
from armdrive.storage import files as places
from armdrive.storage.files import DISK, replace_file
from tui.keys.table import JOG_PAIRS, MM_AXES, JogPair

Number = TypeVar("Number", int, float)

# Sizes of one step, in degrees for angles and mm for the rest.
INCREMENTS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)

# Fractions of the joint speed limits, for jogging and for planned motion.
SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0)

# The jog speed on an arm that this desk has not seen before: a real one starts slowly.
SIMULATED_SPEED, REAL_SPEED = 0.25, 0.1


@dataclass(slots=True)
class JogSettings:
    """Mode, steps and speed of the jog keys.

    `pairs` are the jog keys of the arm, `frames` the frames it knows.
    """

    cartesian: bool = False
    """Whether keys move the finger tips rather than joints."""
    step_deg: float = 2.0
    step_mm: float = 2.0
    speed: float = SIMULATED_SPEED
    pairs: tuple[JogPair, ...] = JOG_PAIRS
    frames: tuple[str, ...] = (BASE_FRAME,)
    frame: str = BASE_FRAME

    def switch_mode(self) -> None:
        """Switch between joint and Cartesian mode."""
        self.cartesian = not self.cartesian

    def next_frame(self) -> None:
        """Go on to the next frame, from the last one to the first."""
        self.frame = self.frames[(self.frames.index(self.frame) + 1) % len(self.frames)]

    def change_step(self, by: int) -> None:
        """Change the step of the present mode: in degrees for joints, in mm for the tip."""
        if self.cartesian:
            self.step_mm = neighbour(INCREMENTS, self.step_mm, by)
        else:
            self.step_deg = neighbour(INCREMENTS, self.step_deg, by)

    def change_speed(self, by: int) -> None:
        """Go faster or more slowly."""
        self.speed = neighbour(SPEEDS, self.speed, by)

    def increment_of(self, key: str) -> Jog:
        """Return the jog of one tap on a jog key: a distance, in mm or in degrees."""
        direction = self.direction_of(key)
        ((axis, sign),) = direction.axes
        step = self.step_mm if axis in MM_AXES else self.step_deg
        return replace(direction, axes=((axis, sign * step),))

    def direction_of(self, key: str) -> Jog:
        """Return the jog of a held jog key: a direction."""
        pair = self.pair_of(key)
        if pair is None:
            raise BadRequest(f"this arm has no axis for the key {key}")
        axes = ((pair.axis(cartesian=self.cartesian), 1.0 if key == pair.plus else -1.0),)
        if self.cartesian:
            return Jog(Space.CARTESIAN, axes, self.frame)
        return Jog(Space.JOINT, axes)

    @property
    def rows(self) -> tuple[JogPair, ...]:
        """The pairs that have a row of the screen: those of letters."""
        return tuple(pair for pair in self.pairs if not pair.is_arrow)

    def pair_of(self, key: str) -> JogPair | None:
        """Return the pair that a key belongs to, None where this arm has no such axis."""
        return next((pair for pair in self.pairs if key in (pair.plus, pair.minus)), None)


@dataclass(slots=True)
class MoveSettings:
    """How the move screen and the points screen reach a goal, and how it is typed."""

    cartesian: bool = True
    speed: float = 0.5
    line: bool = False
    """Whether the tip follows a straight line; else the joints move in proportion."""

    @property
    def way(self) -> str:
        """How a goal is reached, in words."""
        return "straight line" if self.line else "joint motion"

    def switch_line(self) -> None:
        """Switch between a straight line and a joint motion."""
        self.line = not self.line

    def change_speed(self, by: int) -> None:
        """Go to goals faster or more slowly."""
        self.speed = neighbour(SPEEDS, self.speed, by)


def neighbour(values: tuple[Number, ...], value: Number, by: int) -> Number:
    """Return the value `by` places further up or down a table; beyond its ends nothing changes."""
    further: list[Number] = [n for n in values if (n > value if by > 0 else n < value)]
    further.sort(reverse=by < 0)
    return further[min(abs(by), len(further)) - 1] if further else value


# How an app looks: its themes. The layout is in desk.tcss. No theme is needed to understand the
# desk: whatever has a colour has a word or a mark as well.

# White on black, and black or white on whatever is filled: 7 to 1 at least.
HIGH_CONTRAST = Theme(
    name="high-contrast",
    primary="#00ffff",
    secondary="#ffffff",
    accent="#ffff00",
    warning="#ffff00",
    error="#c00000",
    success="#00ff00",
    foreground="#ffffff",
    background="#000000",
    surface="#000000",
    panel="#000000",
    boost="#000000",
    dark=True,
    luminosity_spread=0.0,
    text_alpha=1.0,
)


# The framework's theme of each look by the name people choose it by, and what it is for.
LOOKS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "dark": ("textual-dark", "Light on dark."),
        "light": ("textual-light", "Dark on light, for a bright room or a projector."),
        "high-contrast": (HIGH_CONTRAST.name, "White on black, few and strong colours."),
        "terminal": ("ansi-dark", "The sixteen colours that your terminal has, on its own ground."),
    }
)

# With NO_COLOR set: the only one that sends no colours at all.
COLOURLESS = "terminal"


# What the desk remembers until the next time, for each arm by itself: what was set on a simulated
# arm says nothing about a real one. None of it moves anything: the keys begin disarmed.

MOST_BYTES = 65536  # of some four hundred arms; a larger file is nonsense, and begun again


@dataclass(frozen=True, slots=True)
class DeskMemory:
    """How the desk was left: look, layout of the keyboard, first screen read, each arm's settings.

    `arms` has the arm seen last at its end. All of it may stand in a file that a person edits.
    """

    look: str = ""
    instructed: bool = False
    arms: Mapping[str, object] = field(default_factory=dict)
    layout: str = ""


def arm_key(status: Status) -> str:
    """Return the name under which an arm is remembered; a simulated one is another arm."""
    return f"{'simulated' if status.simulated else 'real'} {status.arm}"


def memory_file() -> Path:
    """Return the file that the desk remembers in."""
    return places.states() / "desk.json"


KINDS: Mapping[str, type] = {"look": str, "instructed": bool, "arms": dict, "layout": str}


def recall(path: Path) -> DeskMemory:
    """Return the remembered settings, without any that cannot be read."""
    try:
        found = json.loads(DISK.read(path, MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return DeskMemory()
    if not isinstance(found, dict):
        return DeskMemory()
    known = {name: found[name] for name, kind in KINDS.items() if isinstance(found.get(name), kind)}
    return DeskMemory(**known)


def chosen_layout(layout: str | None) -> str:
    """Return the keyboard layout to use: this one, which is remembered, or the remembered one."""
    left = recall(memory_file())
    if layout is None:
        return left.layout
    with contextlib.suppress(OSError):  # losing it does no harm
        remember(memory_file(), replace(left, layout=layout))
    return layout


def remember(path: Path, what: DeskMemory) -> None:
    """Replace what is remembered. Raises `OSError`."""
    replace_file(path, json.dumps(asdict(what), indent=1))


# What is remembered of an arm's desk: a part, its field, and the values that make sense.
REMEMBERED: Mapping[str, tuple[str, str, Sequence[object]]] = {
    "cartesian": ("jog", "cartesian", (False, True)),
    "step_deg": ("jog", "step_deg", INCREMENTS),
    "step_mm": ("jog", "step_mm", INCREMENTS),
    "speed": ("jog", "speed", SPEEDS),
    "frame": ("jog", "frame", ()),
    "move_cartesian": ("move", "cartesian", (False, True)),
    "move_speed": ("move", "speed", SPEEDS),
}


class DeskSettings:
    """What is set on the desk of one arm: as it was left the last time, and kept for the next one.

    Without a file nothing was left, and nothing is kept.
    """

    def __init__(
        self, file: Path | None, status: Status, pairs: tuple[JogPair, ...], frames: tuple[str, ...]
    ) -> None:
        """`pairs` are the jog keys of the arm, `frames` the frames it knows."""
        self._file = file
        self._found = DeskMemory(instructed=True) if file is None else recall(file)
        speed, move_speed = (SIMULATED_SPEED, 0.5) if status.simulated else (REAL_SPEED, 0.25)
        self.jog = JogSettings(pairs=pairs, frames=frames, speed=speed)
        """How jog keys move the arm."""
        self.move = MoveSettings(speed=move_speed)
        """How the arm goes to goals of the move screen."""
        self.look = self._found.look
        """The look that the desk had."""
        self.instructed = self._found.instructed
        """Whether a user has read the first screen."""
        left = self._found.arms.get(arm_key(status))
        for name, (part, attribute, choices) in REMEMBERED.items():
            for each in choices or frames:
                if isinstance(left, dict) and each == left.get(name):
                    setattr(getattr(self, part), attribute, each)

    def keep(self, status: Status, look: str) -> None:
        """Keep what is set now for the next time."""
        if self._file is None:
            return
        key, before = arm_key(status), self._found
        left = {
            name: getattr(getattr(self, part), attribute)
            for name, (part, attribute, _) in REMEMBERED.items()
        }
        arms = {**before.arms, key: left}
        with contextlib.suppress(OSError):  # losing these settings does no harm
            remember(self._file, replace(before, look=look, instructed=self.instructed, arms=arms))
