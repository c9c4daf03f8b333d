"""The meaning of a gamepad's sticks and buttons: one table, and the key file that changes it.

[gamepad]
hold = "left-bumper"                        # nothing moves unless it is held
left-x = "axis-1-minus"                     # to the right: as that row of the table of keys
left-y = ["axis-2-minus", "axis-1-minus"]   # down: in joint mode, and in Cartesian mode
dead-zone = 0.2
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from armdrive.errors import KeyFileError
from kinematics.errors import suggestion
from tui.keys.table import AXIS_KEYS

STICKS: Mapping[str, int] = MappingProxyType(
    {"left-x": 0, "left-y": 1, "right-x": 3, "right-y": 4, "dpad-x": 16, "dpad-y": 17}
)
"""Axes by the numbers of Linux's input-event-codes.h; to the right and down are positive."""

BUTTONS: Mapping[str, int] = MappingProxyType(
    {
        "south": 304, "east": 305, "north": 307, "west": 308, "left-bumper": 310,
        "right-bumper": 311, "left-trigger": 312, "right-trigger": 313, "select": 314,
        "start": 315, "left-stick": 317, "right-stick": 318,
    }
)  # fmt: skip
"""Buttons by the numbers of the same file, named by where they are."""

HOLD, STOP = "hold", "stop"
ACTIONS = (HOLD, STOP, "mode", "slower", "faster")
"""The actions of buttons: hold is the dead-man switch, the others are rows of the table of keys."""

GRIPPER_ROWS = ("gripper-plus", "gripper-minus")
"""Stand for the last row of any arm, which has another number on an arm of six joints."""

JOG_ROWS = (*(row.id for row in AXIS_KEYS), *GRIPPER_ROWS)
"""The rows that a stick may be."""

LEAST_DEAD, MOST_DEAD = 0.02, 0.9
DEAD_ZONE = "dead-zone"


@dataclass(frozen=True, slots=True)
class PadMap:
    """Buttons by what they do, and for each stick its rows in joint and in Cartesian mode.

    A stick that is pushed to the right or down does what its row does; the other way, the
    opposite. `dead_zone` is the share of its way within which a stick is at rest.
    """

    buttons: Mapping[str, str] = field(
        default_factory=lambda: {
            HOLD: "left-bumper", STOP: "east", "mode": "north", "slower": "select",
            "faster": "start",
        }
    )  # fmt: skip
    sticks: Mapping[str, tuple[str, str]] = field(
        default_factory=lambda: {
            "left-x": ("axis-1-minus", "axis-2-minus"),
            "left-y": ("axis-2-minus", "axis-1-minus"),
            "right-x": ("axis-5-plus", "axis-5-plus"),
            "right-y": ("axis-3-minus", "axis-3-minus"),
            "dpad-x": ("gripper-plus", "gripper-plus"),
            "dpad-y": ("axis-4-minus", "axis-4-minus"),
        }
    )
    dead_zone: float = 0.15

    def action(self, code: int) -> str:
        """Return what the button of this number does; "" if it is not used."""
        return next((action for action, name in self.buttons.items() if BUTTONS[name] == code), "")

    def rows(self, code: int) -> tuple[str, str] | None:
        """Return the rows of the stick of this number, None where it has none."""
        return next((rows for name, rows in self.sticks.items() if STICKS[name] == code), None)


DEFAULT_PAD = PadMap()
"""The table as it stands."""


def read_pad(table: object, where: str) -> PadMap:
    """Return what a file says in `[gamepad]`; `where` begins the errors. Raises `KeyFileError`."""
    if not isinstance(table, dict):
        raise KeyFileError(f'{where}: gamepad is a table: `[gamepad]`, and below it `hold = "..."`')
    pad = DEFAULT_PAD
    for word, value in table.items():
        setting = f"{where}: gamepad: {word}"
        if word in ACTIONS:
            pad = replace(pad, buttons=_with_button(pad.buttons, word, value, setting))
        elif word in STICKS:
            pad = replace(pad, sticks={**pad.sticks, word: _rows(value, setting)})
        elif word == DEAD_ZONE:
            pad = replace(pad, dead_zone=_dead_zone(value, setting))
        else:
            known = (*ACTIONS, *STICKS, DEAD_ZONE)
            near = suggestion(word, known)
            raise KeyFileError(f"{setting} is not known{near}; known are {', '.join(known)}")
    for action, name in pad.buttons.items():
        others = [each for each, button in pad.buttons.items() if button == name and each != action]
        if others:
            raise KeyFileError(f"{where}: gamepad: {name} would be both {action} and {others[0]}")
    return pad


def _with_button(
    buttons: Mapping[str, str], action: str, value: object, setting: str
) -> dict[str, str]:
    """Return the buttons with this one; an empty word removes one that is not required."""
    others = {each: name for each, name in buttons.items() if each != action}
    if value == "" and action not in (HOLD, STOP):
        return others
    if value not in BUTTONS:
        near = suggestion(str(value), BUTTONS)
        raise KeyFileError(f"{setting} is one of {', '.join(BUTTONS)}, not {value!r}{near}")
    return {**others, action: str(value)}


def _rows(value: object, setting: str) -> tuple[str, str]:
    given = value if isinstance(value, list) else [value, value]
    if len(given) != 2:
        raise KeyFileError(f"{setting} is a row, or two: in joint mode, and in Cartesian mode")
    for row in given:
        if row not in JOG_ROWS:
            near = suggestion(str(row), JOG_ROWS)
            raise KeyFileError(
                f"{setting} is a row of jog keys, like axis-1-plus or gripper-plus, "
                f"not {row!r}{near}"
            )
    return str(given[0]), str(given[1])


def _dead_zone(value: object, setting: str) -> float:
    good = isinstance(value, int | float) and not isinstance(value, bool)
    if not (good and LEAST_DEAD <= float(str(value)) <= MOST_DEAD):
        raise KeyFileError(f"{setting} is a share from {LEAST_DEAD} to {MOST_DEAD}, not {value!r}")
    return float(str(value))


def as_markdown(pad: PadMap = DEFAULT_PAD) -> list[str]:
    """Return the tables as documentation has them."""
    lines = ["| stick | to the right or down, in joint mode | in Cartesian mode |", "|---|---|---|"]
    lines += [f"| `{name}` | `{a}` | `{b}` |" for name, (a, b) in pad.sticks.items()]
    lines += ["", "| does | button |", "|---|---|"]
    return [*lines, *(f"| `{action}` | `{name}` |" for action, name in pad.buttons.items())]
