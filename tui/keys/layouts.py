"""Keyboard layouts: where the jog keys and a few others are on keyboards that are not QWERTY.

`armdrive jog --keys azerty` chooses one. The desk remembers it, as it remembers its colours. The
help of `armdrive jog` names them: this module does not load the framework.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

QWERTY = "qwerty"
# The letters where those of the table stand on other keyboards, upper and middle row; and rows
# whose keys would need three fingers there, each with its key or with the opposite one before it.
LAYOUTS: Mapping[str, tuple[str, str, Mapping[str, str]]] = MappingProxyType(
    {
        QWERTY: ("qwertyu", "asdfghj", {}),
        "azerty": ("azertyu", "qsdfghj", {"step": ",;", "view-zoom": "xw"}),
        "qwertz": ("qwertzu", "asdfghj", {"step": ",.", "view-zoom": "x#"}),
        "dvorak": ("',.pyfg", "aoeuidh", {"view-tilt": "kj", "view-fit": "q"}),
        "colemak": ("qwfpgjl", "arstdhn", {}),
    }
)
