"""Rows of the table of keys for the set-up screen. `t` alone moves anything."""

from __future__ import annotations

from tui.key_row import DeskKey

SETUP_KEYS = (
    DeskKey("setup-enter", ("enter",), "enter", "go on",
            "Do what is marked. What opens a port or writes a file asks for a second press.",
            "setup"),
    DeskKey("setup-next", ("down", "tab"), "mark(1)", "next", "Mark the next line.", "setup"),
    DeskKey("setup-previous", ("up", "shift+tab"), "mark(-1)", "", "Mark the line before.",
            "setup"),
    DeskKey("setup-on", ("right",), "on", "skip",
            "Of a port: go on to describe the arm without opening it.", "setup"),
    DeskKey("setup-back", ("left",), "back", "back",
            "Go back to the question or the list before. Nothing is written.", "setup"),
    DeskKey("setup-erase", ("backspace",), "erase", "", "Take the last character away.", "setup"),
    DeskKey("setup-turn", ("t",), "turn", "TURN",
            "While motors are checked: turn the motor a little; once more: bring it back.",
            "setup"),
    DeskKey("setup-yes", ("y",), "saw('AS_SHOWN')", "as shown", "It moved as shown.", "setup"),
    DeskKey("setup-reversed", ("r",), "saw('OTHER_WAY')", "reversed", "It moved the other way.",
            "setup"),
    DeskKey("setup-nothing", ("n",), "saw('NOT_AT_ALL')", "nothing", "Nothing moved.", "setup"),
    DeskKey("setup-another", ("a",), "another", "another",
            "Another motor's part moved: which one is chosen next.", "setup"),
    DeskKey("setup-double", ("d",), "saw('TWICE')", "double", "It moved about twice as far.",
            "setup"),
    DeskKey("setup-half", ("h",), "saw('HALF')", "half", "It moved about half as far.", "setup"),
)  # fmt: skip
"""While text is typed, printable keys are typed and do nothing else; space is never typed."""
