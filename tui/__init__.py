"""The desk: terminal screens from which a person drives an arm.

What is decided where:

    app         what a key or click does, stop first; what is stale and dropped
    keys/       which keys there are, what they are called, and which presses count
    desk        the app of one arm; the link, the calls, and the keys of all screens
    safety      the panel of every screen: state, trust, what a stop takes
    jog/, move/, points/, program/, setup/, log, theory   one screen each
    watch       an arm that another program drives; `model_desk` a model without an arm
    settings    what an operator has set, its steps and speeds, and what is remembered
    axes, arm_view, widgets, dialogs   what screens are made of
    terminal    what a terminal can show, and how it is left
    startup     which desk is opened, and which screens it has
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tui.startup import DeskEnd, run_desk
    from tui.watch import run_watch

__all__ = ["DeskEnd", "run_desk", "run_watch"]


def __getattr__(name: str) -> Any:
    """Load the desk on first use: the table of keys, or a model, works without it."""
    if name not in __all__:
        raise AttributeError(f"module 'tui' has no attribute {name!r}")
    from tui import startup, watch

    return getattr(watch if name == "run_watch" else startup, name)
