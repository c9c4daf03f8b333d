"""The keys of the desk, in one table: bindings, footer, help and tests are made from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from kinematics import JOINT_NAMES


@dataclass(frozen=True, slots=True)
class DeskKey:
    """One thing to do, and the keys that do it, named as the framework names them.

    `everywhere` keys work on every screen and in every dialog, before anything else.
    """

    id: str
    keys: tuple[str, ...]
    action: str
    description: str
    tooltip: str
    everywhere: bool = False


@dataclass(frozen=True, slots=True)
class JogPair:
    """Two keys that move one axis, up and down: a joint in joint mode, else a task axis."""

    plus: str
    minus: str
    joint: str
    cartesian: str

    def axis(self, *, cartesian: bool) -> str:
        """Return the axis that the pair moves in this mode."""
        return self.cartesian if cartesian else self.joint


KEYS = (
    DeskKey(
        "stop",
        ("space", "escape", "ctrl+c"),
        "stop_arm",
        "STOP",
        "Stop, disarm, close any dialog; works everywhere. Space is 0.1 s quicker than Esc.",
        everywhere=True,
    ),
    DeskKey("arm", ("enter",), "arm_keys", "arm", "Arm the jog keys; they disarm after 60 s idle."),
    DeskKey("help", ("question_mark",), "help", "help", "Show all keys."),
    DeskKey(
        "quit",
        ("ctrl+q",),
        "leave",
        "quit",
        "Stop the arm and leave the desk.",
        everywhere=True,
    ),
    DeskKey("mode", ("m",), "mode", "mode", "Switch between joint and Cartesian mode."),
    DeskKey(
        "reference",
        ("H",),
        "reference",
        "reference",
        "Show the reference posture, and say that the arm stands in it. A simulated arm is "
        "led; one with switches homes by itself, after a question.",
    ),
    DeskKey(
        "confirm",
        ("C",),
        "confirm",
        "confirm",
        "Show the posture that the last program left, and say that the arm stands in it.",
    ),
    DeskKey("finer", ("left_square_bracket",), "finer", "finer", "Make the increment smaller."),
    DeskKey(
        "coarser", ("right_square_bracket",), "coarser", "coarser", "Make the increment larger."
    ),
    DeskKey("slower", ("minus",), "slower", "slower", "Jog more slowly."),
    DeskKey("faster", ("plus", "equals_sign"), "faster", "faster", "Jog faster."),
    DeskKey(
        "motors",
        ("P",),
        "motors",
        "motors",
        "Switch the motor current on; or off, after a question, since the arm sags then.",
    ),
    DeskKey(
        "reconnect",
        ("L",),
        "reconnect",
        "link",
        "Look for a lost link once, now. Moves nothing; what was under way is not taken up again.",
    ),
    DeskKey(
        "frame",
        ("F",),
        "frame",
        "frame",
        "In Cartesian mode, whose x, y and z are meant: the base's, the tool's, or those of a "
        "frame of the arm file.",
    ),
    DeskKey("reset", ("R",), "reset", "reset", "Leave error-stop. Moves nothing."),
    DeskKey(
        "estop",
        ("X",),
        "estop",
        "e-stop",
        "Stop and latch error-stop: nothing moves until a reset.",
    ),
)

LETTERS = (("q", "a"), ("w", "s"), ("e", "d"), ("r", "f"), ("t", "g"), ("y", "h"), ("u", "j"))
"""The keys of the screen's rows, from the base to the gripper."""

ARROWS = (("left", "right", "base", "y"), ("up", "down", "shoulder", "z"))
"""The arrows repeat two rows: the first two joints, and the axes that they look like."""

TASK_AXES = ("x", "y", "z", "pitch", "roll")
GRIPPER = "gripper"


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

_LABELS: Mapping[str, str] = MappingProxyType(
    {
        "escape": "Esc",
        "question_mark": "?",
        "left_square_bracket": "[",
        "right_square_bracket": "]",
        "minus": "-",
        "plus": "+",
        "equals_sign": "=",
    }
)


def label(key: str) -> str:
    """Return what is printed on a key."""
    return _LABELS.get(key, key)


def words(axis: str) -> str:
    """Return an axis as people write it."""
    return axis.replace("_", " ")


def footer(width: int) -> str:
    """Return as much of the key line as fits whole, the stop first."""
    line = ""
    for entry in KEYS:
        item = f"{label(entry.keys[0])} {entry.description}"
        longer = f"{line}  {item}" if line else item
        if len(longer) > width:
            break
        line = longer
    return line


def help_lines(pairs: Sequence[JogPair] = JOG_PAIRS) -> Iterator[str]:
    """Yield one line for each row of the table, jog keys last."""
    for entry in KEYS:
        keys = " ".join(label(key) for key in entry.keys)
        yield f"{keys:<17} {entry.tooltip}"
    yield ""
    yield "Jog keys, while armed: tap for one increment, hold to keep moving."
    for pair in pairs:
        moves = f"{words(pair.joint)} (Cartesian mode: {pair.cartesian})"
        yield f"{label(pair.plus) + ' ' + label(pair.minus):<17} {moves} + and -"
