"""The desk: terminal screens from which a person drives an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tui.startup import DeskEnd, run_desk
    from tui.watch import run_watch

__all__ = ["DeskEnd", "run_desk", "run_watch"]


def __getattr__(name: str) -> Any:
    """Load the desk when it is asked for: the table of keys alone, or a model, needs none of it."""
    if name == "run_watch":
        from tui.watch import run_watch

        return run_watch
    if name in __all__:
        from tui import startup

        return getattr(startup, name)
    raise AttributeError(f"module 'tui' has no attribute {name!r}")
