"""Other keys for the desk: a keyboard's layout by name, or a file that gives rows other keys.

layout = "azerty"           # or qwerty, qwertz, dvorak, colemak
[keys]
arm = "f9"                  # a row's id: a key, as printed or by its name ...
finer = [",", "f10"]        # ... or several
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from armdrive.errors import KeyFileError
from armdrive.storage import files as places
from armdrive.text.reading import is_there, read_toml
from kinematics.errors import suggestion
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, key_named, label
from tui.keys.table import SCREENS, STOP, TABLE, DeskKey

AnyKeyboard = TypeVar("AnyKeyboard", bound=Keyboard)

TABLES = ("layout", "keys")
"""The keys of a key file."""

STOP_KEYS = ("space", "ctrl+c")
"""Always stop, whatever a file says: a guest at the desk has to know one key."""

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


def load_keys(source: str | None) -> Keyboard:
    """Return the keyboard of a layout's name or a file; without either, of the user's own file.

    Raises `KeyFileError`. Without a file, returns the table as it stands.
    """
    if source in LAYOUTS:
        return checked(_of_layout(str(source)), f"the layout {source}")
    path = places.key_file() if source is None else Path(source)
    if source is None and not is_there(path):
        return DEFAULT_KEYS
    return _of_table(_read(path), str(path))


def _read(path: Path) -> dict[str, Any]:
    if not is_there(path):
        layouts = ", ".join(LAYOUTS)
        raise KeyFileError(
            f"{path} cannot be read: there is no such file. Name a file of keys, or one of the "
            f"layouts {layouts}{suggestion(str(path), LAYOUTS)}"
        )
    return read_toml(path, "the file of keys", KeyFileError)


def _of_table(table: dict[str, Any], where: str) -> Keyboard:
    """Return the keyboard of a file's content; `where` begins the errors."""
    for word in table:
        if word not in TABLES:
            known = (*TABLES, *(row.id for row in TABLE))
            raise KeyFileError(f"{where}: no {word!r} is known{suggestion(word, known)}")
    layout, given = table.get("layout", QWERTY), table.get("keys", {})
    if layout not in LAYOUTS:
        near = suggestion(str(layout), LAYOUTS)
        raise KeyFileError(f"{where}: layout is one of {', '.join(LAYOUTS)}, not {layout!r}{near}")
    if not isinstance(given, dict):
        raise KeyFileError(f'{where}: keys is a table: `[keys]`, and below it `arm = "f9"`')
    keys = {name: _keys(name, value, where) for name, value in given.items()}
    return checked(_of_layout(layout).changed(keys), where)


def _of_layout(name: str) -> Keyboard:
    upper, middle, more = LAYOUTS[name]
    keys = {row: (key_named(key),) for row, key in more.items()}
    for number, (plus, minus) in enumerate(zip(upper, middle, strict=True), 1):
        keys[f"axis-{number}-plus"] = (key_named(plus),)
        keys[f"axis-{number}-minus"] = (key_named(minus),)
    return DEFAULT_KEYS.changed(keys)


def _keys(name: str, value: object, where: str) -> tuple[str, ...]:
    """Return the keys that a file gives to a row, by the names of the framework."""
    if name not in {row.id for row in TABLE}:
        near = suggestion(name, (row.id for row in TABLE))
        raise KeyFileError(
            f"{where}: nothing at the desk is called {name!r}{near}; "
            "`armdrive jog --show-keys` lists all"
        )
    given = value if isinstance(value, list) else [value]
    words = [word for word in given if isinstance(word, str) and word]
    if not words or len(words) < len(given):
        raise KeyFileError(f"{where}: {name} is a key or a list of keys, not {value!r}")
    try:
        keys = tuple(key_named(word) for word in words)
    except ValueError as error:
        raise KeyFileError(f"{where}: {name}: {error}") from None
    return tuple(dict.fromkeys((STOP_KEYS[0], *keys, *STOP_KEYS[1:]))) if name == STOP else keys


def checked(keyboard: AnyKeyboard, where: str) -> AnyKeyboard:
    """Return the keyboard if no key does two things at one place, else raise `KeyFileError`."""
    owners: dict[tuple[str, str], DeskKey] = {}
    for place in {row.place for row in keyboard.rows}:
        for row in _heard_at(keyboard, place):
            for key in row.keys:
                other = owners.setdefault((place, key), row)
                if other.id != row.id:
                    raise KeyFileError(
                        f"{where}: {label(key)} would be both {other.id} and {row.id}: give one "
                        "of them another key"
                    )
    return keyboard


def _heard_at(keyboard: Keyboard, place: str) -> Iterator[DeskKey]:
    """Yield the rows whose keys have an effect at a place.

    On a screen those are its own and those of all screens; in a dialog nothing goes through it
    but what works everywhere.
    """
    for row in keyboard.rows:
        if row.place == place or row.everywhere or (not row.place and _is_screen(place)):
            yield row


def _is_screen(place: str) -> bool:
    return place in {entry.id for entry in SCREENS}
