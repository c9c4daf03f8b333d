"""Rows of the table of keys for the screens that plan motion: move and points."""

from __future__ import annotations

from tui.key_row import DeskKey

MOVE_KEYS = (
    DeskKey("move-go", ("enter",), "press_go", "go (twice)",
            "Press twice: the arm moves as it is shown. A key that is held does not count.",
            "move"),
    DeskKey("move-next", ("down", "tab"), "field(1)", "next", "Go to the next field.", "move"),
    DeskKey("move-previous", ("up", "shift+tab"), "field(-1)", "",
            "Go to the field before.", "move"),
    DeskKey("move-more", ("right",), "step(1)", "more", "Make the field larger by a step.", "move"),
    DeskKey("move-less", ("left",), "step(-1)", "less", "Make it smaller by a step.", "move"),
    DeskKey("move-erase", ("backspace",), "erase", "",
            "Take the last character of the field away; an empty field stays as it is.", "move"),
    DeskKey("move-clear", ("delete",), "clear", "clear",
            "Empty all fields: the arm would stay where it is.", "move"),
    DeskKey("move-nearest", ("n",), "nearest", "nearest",
            "After a refusal: ask for the nearest goal that is possible.", "move"),
    DeskKey("move-posture", ("b",), "posture", "posture",
            "Ask for the next posture that holds the hand at this goal, by its joints.", "move"),
    DeskKey("move-mode", ("m",), "mode", "mode",
            "Switch between joint angles and poses.", "move"),
    DeskKey("move-line", ("l",), "line", "line",
            "Switch between a straight line of the tip and a joint motion.", "move"),
    DeskKey("move-frame", ("F",), "frame", "frame",
            "Which frame the pose is one of; of the tool, it is a change from where it is.",
            "move"),
    DeskKey("move-slower", ("less_than_sign",), "speed(-1)", "slower", "Move more slowly.",
            "move"),
    DeskKey("move-faster", ("greater_than_sign",), "speed(1)", "faster", "Move faster.", "move"),
    DeskKey("move-finer", ("left_square_bracket",), "step_size(-1)", "finer",
            "Make the arrows' step smaller.", "move"),
    DeskKey("move-coarser", ("right_square_bracket",), "step_size(1)", "coarser",
            "Make the arrows' step larger.", "move"),
)  # fmt: skip
"""Digits, the point and the minus are typed into the field, and are no rows of the table."""
