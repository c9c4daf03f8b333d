"""How the desk is laid out, and the framework's bindings made from the table of keys."""

from __future__ import annotations

from textual.binding import Binding, BindingType

from tui.keys import ALL_JOG_KEYS, KEYS

CSS = """
#title, #footer { height: 1; text-style: reverse; }
#title.-real { background: $error; color: $text; text-style: bold; }
#banner { height: auto; display: none; background: $error; color: $text; text-style: bold; }
#banner.-shown { display: block; }
#remarks { height: auto; min-height: 1; max-height: 4; }
#views { width: 1fr; }
#panel { width: 1fr; min-width: 42; padding: 0 0 0 1; scrollbar-size: 0 0; }
ArmView { height: 1fr; }
#conduct, #joints, #tip, #bottom { height: auto; }
#conduct.-armed { color: $warning; text-style: bold; }
.-wide #joints, .-wide #tip, .-wide #bottom { margin: 1 0 0 0; }
ModalScreen { align: center middle; }
.dialog { width: 90%; max-width: 100; height: 90%; border: solid $primary; padding: 0 1; }
.dialog PlainText { height: auto; }
"""


def bindings() -> list[BindingType]:
    """Make the framework's bindings from the tables."""
    made: list[BindingType] = [
        Binding(
            ",".join(entry.keys),
            entry.action,
            entry.description,
            tooltip=entry.tooltip,
            priority=entry.everywhere,
            id=entry.id,
        )
        for entry in KEYS
    ]
    made += [Binding(key, f"jog('{key}')", show=False, id=f"jog.{key}") for key in ALL_JOG_KEYS]
    return made
