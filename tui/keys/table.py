"""The keys and the screens of the desk, a table each: for bindings, footer, help, docs, tests.

What the keys are on the keyboard at hand, and how they are shown, is keyboard.py's.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.spaces import JOINT_NAMES
from tui.keys.rows import DESK_KEYS as DESK_KEYS
from tui.keys.rows import (
    DIALOG_KEYS,
    LOG_DIALOG_KEYS,
    LOG_KEYS,
    MODEL_KEYS,
    MOVE_KEYS,
    POINT_KEYS,
    PROGRAM_KEYS,
    SETUP_KEYS,
    THEORY_KEYS,
    VIEW_KEYS,
    WATCH_KEYS,
)
from tui.keys.rows import STOP as STOP
from tui.keys.rows import DeskKey as DeskKey

# The screens of the desk: function keys, palette and help are made from this table. Which class
# shows which of them is the desk's to say: a `DeskScreen` (screens.py says what that needs).


@dataclass(frozen=True, slots=True)
class KeyEntry:
    """One screen: its key, what it is called, and what it is for in a few words."""

    id: str
    key: str
    title: str
    summary: str


SCREENS = (
    KeyEntry("jog", "f2", "jog", "Move the arm by hand, joint by joint or the tip along a line."),
    KeyEntry("move", "f3", "move", "Type a goal, see what the motion would be, then move."),
    KeyEntry("points", "f4", "points", "Name places, go back to them, step through sequences."),
    KeyEntry("setup", "f5", "set-up", "Find an arm, describe it in a file, and check its motors."),
    KeyEntry(
        "theory", "f6", "theory", "Matrices, Jacobian, singularities of the arm as it stands."
    ),
    KeyEntry("log", "f7", "log", "What passes between the arm and this program, in words."),
    KeyEntry("program", "f8", "program", "Choose a program, rehearse it, run it, step through it."),
)
"""The first one is shown first."""


def summary_of(screen: str) -> str:
    """Say which screen this is and what it is for; nothing of one that stands in no table."""
    found = (f"{entry.title}: {entry.summary}" for entry in SCREENS if entry.id == screen)
    return next(found, "")


def titled(screen: str) -> str:
    """Return what a screen is called; its id where it stands in no table (dialogs)."""
    return next((entry.title for entry in SCREENS if entry.id == screen), screen)


JOG_KEYS = (
    DeskKey(
        "arm",
        ("enter",),
        "arm_keys",
        "arm",
        "Arm the jog keys; they disarm after 60 s idle.",
        "jog",
    ),
    DeskKey(
        "mode",
        ("m",),
        "adjustments.switch_mode",
        "mode",
        "Switch between joint and Cartesian mode.",
        "jog",
    ),
    DeskKey(
        "finer",
        ("left_square_bracket",),
        "adjustments.finer",
        "finer",
        "Make the step smaller: degrees in joint mode, mm in Cartesian mode.",
        "jog",
    ),
    DeskKey(
        "coarser",
        ("right_square_bracket",),
        "adjustments.coarser",
        "coarser",
        "Make the step larger: degrees in joint mode, mm in Cartesian mode.",
        "jog",
    ),
    DeskKey("slower", ("minus",), "adjustments.slower", "slower", "Jog more slowly.", "jog"),
    DeskKey(
        "faster", ("plus", "equals_sign"), "adjustments.faster", "faster", "Jog faster.", "jog"
    ),
    DeskKey(
        "grasp",
        ("G",),
        "fingers.grasp",
        "grasp",
        "While armed: close the fingers on what is between them, until the grip switch closes.",
        "jog",
        also="grip gripper hold",
    ),
    *(
        DeskKey(
            f"grip-{word}",
            (key,),
            f"fingers.preset({share})",
            "",
            f"While armed: {does}.",
            "jog",
            also="grip gripper fingers",
        )
        for key, word, share, does in (
            ("1", "open", 1.0, "open the fingers"),
            ("2", "half", 0.5, "bring the fingers half open"),
            ("3", "closed", 0.0, "close the fingers"),
        )
    ),
    DeskKey(
        "park",
        ("K",),
        "park",
        "park",
        "Show the park posture, and go there after a question.",
        "jog",
        also="parking rest",
    ),
    DeskKey(
        "details",
        ("D",),
        "details",
        "details",
        "Show or hide the details: motors, inputs, and what goes over the wire.",
        "jog",
        also="wire bytes motors inputs",
    ),
    DeskKey(
        "frame",
        ("F",),
        "adjustments.next_frame",
        "frame",
        "In Cartesian mode, whose x, y and z are meant: the base's, the tool's, or those of a "
        "frame of the arm file.",
        "jog",
    ),
)

SCREEN_KEYS = tuple(
    DeskKey(
        f"screen-{entry.id}",
        (entry.key,),
        f"show_screen('{entry.id}')",
        entry.title,
        entry.summary,
    )
    for entry in SCREENS
)


@dataclass(frozen=True, slots=True)
class JogPair:
    """Two keys that move one axis, up and down: a joint in joint mode, else a task axis.

    The keys go by what they are in the table, wherever a file of keys has put them.
    """

    plus: str
    minus: str
    joint: str
    cartesian: str

    def axis(self, *, cartesian: bool) -> str:
        """Return the axis that the pair moves in this mode."""
        return self.cartesian if cartesian else self.joint


LETTERS = (("q", "a"), ("w", "s"), ("e", "d"), ("r", "f"), ("t", "g"), ("y", "h"), ("u", "j"))
"""The keys of the screen's rows, from the base to the gripper."""

ARROWS = (("left", "right", "base", "y"), ("up", "down", "shoulder", "z"))
"""The arrows repeat two rows: the first two joints, and the axes that they look like."""

TASK_AXES = ("x", "y", "z", "pitch", "roll")
GRIPPER = "gripper"
MM_AXES = ("x", "y", "z", GRIPPER)
"""Axes that are jogged by mm; all others turn, by degrees."""


def jog_pairs(joints: Sequence[str], *, has_yaw: bool = False) -> tuple[JogPair, ...]:
    """Return the pairs of an arm with these joints: a row for each, the gripper's last."""
    axes = (*TASK_AXES, *(("yaw",) if has_yaw else ()))
    rows = zip(LETTERS, (*joints, GRIPPER), (*axes, GRIPPER), strict=False)
    letters = (JogPair(*keys, joint, axis) for keys, joint, axis in rows)
    arrows = (
        JogPair(plus, minus, joint, axis)
        for (plus, minus, _, axis), joint in zip(ARROWS, joints, strict=False)
    )
    return (*letters, *arrows)


JOG_PAIRS = jog_pairs(JOINT_NAMES)
"""The pairs of an arm of the Mini-mover's build."""

ALL_JOG_KEYS = tuple(key for pair in (*LETTERS, *ARROWS) for key in pair[:2])
"""Every key that jogs on some arm."""

_WAYS = ("plus", "minus")

AXIS_KEYS = tuple(
    DeskKey(
        f"axis-{number}-{way}",
        (key,),
        f"jog('{key}')",
        "",
        f"Jog row {number} of the joints, {way}; in Cartesian mode that axis of the tip.",
        "jog",
    )
    for number, keys in enumerate(LETTERS, 1)
    for way, key in zip(_WAYS, keys, strict=True)
) + tuple(
    DeskKey(
        f"arrow-{key}",
        (key,),
        f"jog('{key}')",
        "",
        f"Jog the {joint}, {way}; in Cartesian mode {axis}.",
        "jog",
    )
    for *keys, joint, axis in ARROWS
    for way, key in zip(_WAYS, keys, strict=True)
)

TABLE = (
    *DESK_KEYS,
    *SCREEN_KEYS,
    *JOG_KEYS,
    *MOVE_KEYS,
    *POINT_KEYS,
    *PROGRAM_KEYS,
    *SETUP_KEYS,
    *THEORY_KEYS,
    *LOG_KEYS,
    *LOG_DIALOG_KEYS,
    *MODEL_KEYS,
    *VIEW_KEYS,
    *WATCH_KEYS,
    *DIALOG_KEYS,
    *AXIS_KEYS,
)
"""Every key of the desk. Ids are for good: files of keys go by them."""


def words(axis: str) -> str:
    """Return an axis as people write it."""
    return axis.replace("_", " ")


def spoken(text: str, axes: Sequence[str]) -> str:
    """Return a sentence with these axes as people write them; `wrist_pitch_deg` is left alone."""
    for axis in (each for each in axes if "_" in each):
        text = re.sub(rf"\b{re.escape(axis)}\b", words(axis), text)
    return text
