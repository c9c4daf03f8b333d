"""Questions about a controller whose own section has such keys: axes, units, gripper words.

Which keys a dialect has is read off its settings; no dialect is named here.
"""

from __future__ import annotations

from collections.abc import Callable

from armdrive.dialog.conversation import Reader, WrongAnswer, choice, number, text, whole, yes_or_no
from armdrive.setup.draft import Draft
from armdrive.setup.questions.arm import ArmRow, Fill, fixed, plain
from armdrive.setup.templates import OUTPUT, SERVO


def _has(key: str, gripper: str = "") -> Callable[[Draft], bool]:
    return lambda draft: key in draft.device_fields and gripper in ("", draft.gripper)


def _usual(key: str) -> Fill:
    return lambda draft, _one: f"{draft.device_fields[key]}"


def _axes(draft: Draft) -> Reader:
    count = len(draft.motors) + draft.stepped

    def read(line: str) -> str:
        letters = line.replace(" ", "").upper()
        if len(letters) != count or len(set(letters)) != count or not letters.isalpha():
            raise WrongAnswer(f"{count} different letters are needed, one for each motor: {line!r}")
        return letters

    return read


def _count(draft: Draft) -> int:
    return len(draft.motors) + draft.stepped


def _nodes(draft: Draft) -> Reader:
    count, bus = _count(draft), draft.dialect.bus
    node = whole(1, bus.most if bus is not None else count)

    def read(line: str) -> tuple[int, ...]:
        found = tuple(node(word) for word in line.replace(",", " ").split())
        if len(found) != count or len(set(found)) != count:
            raise WrongAnswer(f"{count} different numbers are needed, one a drive: {line!r}")
        return found

    return read


ROWS = (
    ArmRow(
        "device.axes", "Which axis of the board drives each motor, in the arm's order?",
        "One letter a motor. Where a plug sits on another socket, change the letters' order.",
        _axes,
        lambda draft, _one: str(draft.device_fields["axes"])[: len(draft.motors) + draft.stepped],
        when=_has("axes"),
    ),
    ArmRow(
        "device.ids", "Which node is the drive of each motor, in the arm's order?",
        "Node numbers, 1 to 127, as the drives' own program or switches set them. `armdrive doctor "
        "--can` shows who is on the bus.",
        _nodes,
        lambda draft, _one: " ".join(str(1 + each) for each in range(_count(draft))),
        when=_has("master_id"),
    ),
    ArmRow(
        "device.unit", "What is the board's mm: one motor step, or one degree?",
        "Steps need no rounding: $100 and its fellows are then 1.",
        fixed(choice(("steps", "degrees"))), plain("steps"), when=_has("unit"),
        choices=lambda _draft: (("steps", "one motor step"), ("degrees", "one degree")),
    ),
    ArmRow(
        "device.servo", "Which word sets the gripper's servo?",
        "M3 with a number S, or M67E0 for an analogue output of grblHAL.",
        fixed(text), _usual("servo"), when=_has("servo", SERVO),
    ),
    ArmRow(
        "device.servo_closed", "The servo's number with the fingers closed?",
        "The S or Q of that word. Begin near the middle and go outwards in small steps.",
        fixed(number(0.0, 100_000.0)), _usual("servo_closed"),
        when=_has("servo_closed", SERVO),
    ),
    ArmRow(
        "device.servo_open", "The servo's number with the fingers open?",
        "It may be below the one for closed fingers.",
        fixed(number(0.0, 100_000.0)), _usual("servo_open"),
        when=_has("servo_open", SERVO),
    ),
    ArmRow(
        "device.gripper_output", "Which output bit switches the gripper?",
        "0 is the first word of the section's outputs, flood by default.",
        fixed(whole(0, 7)), _usual("gripper_output"),
        when=_has("gripper_output", OUTPUT),
    ),
    ArmRow(
        "device.gripper_closes", "Does the gripper close when that output is on?",
        "no: it opens then, and closes when the power fails.",
        fixed(yes_or_no), plain("yes"), when=_has("gripper_closes", OUTPUT),
    ),
)  # fmt: skip
"""Asked after the gripper is known."""
