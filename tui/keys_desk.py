"""Rows of the table of keys for every screen of the desk, and for its dialogs."""

from __future__ import annotations

from tui.key_row import DeskKey

STOP = "stop"
"""The row that no file of keys can take the space bar from."""

DESK_KEYS = (
    DeskKey(
        STOP,
        ("space", "escape", "ctrl+c"),
        "stop_arm",
        "STOP",
        "Stop, disarm, close any dialog; works everywhere. Space is 0.1 s quicker than Esc.",
        everywhere=True,
    ),
    DeskKey("help", ("question_mark", "f1"), "help", "help", "Show all keys."),
    DeskKey(
        "quit",
        ("ctrl+q",),
        "leave",
        "quit",
        "Stop the arm and leave the desk.",
        everywhere=True,
    ),
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
        "palette",
        ("ctrl+p",),
        "command_palette",
        "commands",
        "Find by a few letters what can be done here; enter does it.",
    ),
    DeskKey(
        "look",
        ("T",),
        "next_look",
        "look",
        "Other colours: dark, light, of high contrast, or your terminal's own.",
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
"""What can be done on every screen."""

DIALOG_KEYS = (
    DeskKey(
        "help-close", ("question_mark", "f1", "enter", "n"), "close", "close", "Close it.", "help"
    ),
    DeskKey("understood", ("enter",), "close", "understood", "Go to the desk.", "first"),
    DeskKey("yes", ("y",), "answer(True)", "yes", "It is so: do it.", "question"),
    DeskKey("no", ("n",), "answer(False)", "no", "It is not so: do nothing.", "question"),
)
"""Enter answers no question: whoever armed with it might still be pressing it."""
