"""Keyboard layouts: where the jog keys and a few others are on keyboards that are not QWERTY.

`armdrive jog --keys azerty` chooses one. The desk remembers it, as it remembers its colours.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tui.keys.keyboard import Keyboard

QWERTY = "qwerty"
LAYOUTS: Mapping[str, tuple[str, str, Mapping[str, str]]] = MappingProxyType(
    {
        QWERTY: ("qwertyu", "asdfghj", {}),
        "azerty": (
            "azertyu",
            "qsdfghj",
            {"finer": ",", "coarser": ";", "view-nearer": "w"},
        ),
        "qwertz": (
            "qwertzu",
            "asdfghj",
            {"finer": ",", "coarser": ".", "view-nearer": "#"},
        ),
        "dvorak": ("',.pyfg", "aoeuidh", {"view-up": "j", "view-fit": "q"}),
        "colemak": ("qwfpgjl", "arstdhn", {}),
    }
)
"""The letters where those of the table stand on other keyboards, upper and middle row; and rows
whose keys would need three fingers there."""


def keyboard_of(layout: str) -> Keyboard:
    """Return the keyboard of a layout; that of the table where there is none of that name."""
    # the help of `armdrive jog` names the layouts, and does not wait for the framework
    from textual.keys import _character_to_key

    from tui.keys.keyboard import DEFAULT_KEYS

    upper, middle, more = LAYOUTS.get(layout, LAYOUTS[QWERTY])
    keys = {row: (_character_to_key(key),) for row, key in more.items()}
    for number, (plus, minus) in enumerate(zip(upper, middle, strict=True), 1):
        keys[f"axis-{number}-plus"] = (_character_to_key(plus),)
        keys[f"axis-{number}-minus"] = (_character_to_key(minus),)
    return DEFAULT_KEYS.changed(keys)
