"""Parse the text of an EDS file (CiA 306) into an object dictionary."""

from __future__ import annotations

import re
from collections.abc import Iterator
from configparser import Error, RawConfigParser, SectionProxy

from firmware_protocol.canopen.objects import (
    Access,
    DataType,
    Dictionary,
    ObjectEntry,
    Place,
    Value,
)
from firmware_protocol.errors import BadField, RemoteProtocolError

ARRAY, RECORD, VARIABLE = 0x08, 0x09, 0x07
"""Object codes of CiA 301."""

_OBJECT = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?", re.IGNORECASE)
_NODE = re.compile(r"\$NODEID", re.IGNORECASE)


def read_eds(text: str) -> Dictionary:
    """Return the objects of an EDS or DCF file. Raises `RemoteProtocolError`, with the section.

    Objects of manufacturer-specific types stay bytes. The unit comes from the keyword `Unit`,
    which is an extension of CiA 306.
    """
    parser = RawConfigParser(strict=False, inline_comment_prefixes=(";",), default_section="")
    try:
        parser.read_string(text.removeprefix("\ufeff"))
    except Error as error:
        reason = " ".join(error.message.split())
        raise RemoteProtocolError(f"this is no EDS file: {reason}") from None
    entries: dict[Place, ObjectEntry] = {}
    records: dict[int, str] = {}
    for name in parser.sections():
        found = _OBJECT.fullmatch(name)
        if found is None:
            continue
        index, sub = int(found[1], 16), found[2]
        try:
            if sub is None and _number(parser[name], "ObjectType", VARIABLE) in (ARRAY, RECORD):
                records[index] = _word(parser[name], "ParameterName")
                entries |= {entry.place: entry for entry in _compact(index, parser[name])}
            else:
                place = Place(index, int(sub or "0", 16))
                entries[place] = _entry(place, parser[name])
        except (BadField, RemoteProtocolError) as error:
            raise RemoteProtocolError(f"section [{name}]: {error}") from None
    return Dictionary(entries.values(), records)


def _compact(index: int, section: SectionProxy) -> Iterator[ObjectEntry]:
    """Yield the entries of an array that is described in a single section."""
    count = _number(section, "CompactSubObj", 0)
    if not count:
        return
    yield ObjectEntry(Place(index), "Highest sub-index", DataType.U8, Access.CONST, default=count)
    model = _entry(Place(index), section)
    for sub in range(1, count + 1):
        yield ObjectEntry(
            Place(index, sub),
            f"{model.name} {sub}",
            model.type,
            model.access,
            model.unit,
            model.default,
            model.mappable,
            model.adds_node,
        )


def _entry(place: Place, section: SectionProxy) -> ObjectEntry:
    kind = _type(_number(section, "DataType", 0))
    default, adds_node = _default(kind, section.get("DefaultValue"))
    return ObjectEntry(
        place,
        _word(section, "ParameterName"),
        kind,
        _access(section),
        _clean(section.get("Unit")),
        default,
        bool(_number(section, "PDOMapping", 0)),
        adds_node,
    )


def _word(section: SectionProxy, key: str) -> str:
    value = _clean(section.get(key))
    if not value:
        raise RemoteProtocolError(f"{key} is missing")
    return value


def _clean(value: str | None) -> str:
    """Return the text as a single clean line."""
    return "".join(c if c.isprintable() else " " for c in value or "").strip()


def _access(section: SectionProxy) -> Access:
    word = (section.get("AccessType") or Access.RO.value).lower()  # optional for a DOMAIN
    try:
        return Access(word)
    except ValueError:
        raise RemoteProtocolError(f"AccessType {word} is none") from None


def _number(section: SectionProxy, key: str, default: int) -> int:
    value = section.get(key)
    return default if not value else _whole(key, value)


def _whole(key: str, value: str) -> int:
    try:
        return int(value, 0)
    except ValueError:
        pass
    try:
        return int(value)  # "010" means ten
    except ValueError:
        raise RemoteProtocolError(f"{key} {value} is no whole number") from None


def _type(number: int) -> DataType:
    try:
        return DataType(number)
    except ValueError:
        return DataType.DOMAIN


def _default(kind: DataType, text: str | None) -> tuple[Value | None, bool]:
    """Return a default value, and whether to add the node's number."""
    if not text:
        return None, False
    bare, times = _NODE.subn("", text)
    if times and kind.limits is not None:
        return _whole("DefaultValue", bare.replace("+", "").strip() or "0"), True
    return _value(kind, text), False


def _value(kind: DataType, text: str) -> Value | None:
    if kind.limits is not None:
        number = _whole("DefaultValue", text)
        wraps = kind.signed and number > kind.limits[1]  # FFh as an I8 is -1
        return number - (1 << (kind.bits or 0)) if wraps else number
    if kind is DataType.BOOLEAN:
        return bool(_whole("DefaultValue", text))
    try:
        if kind in (DataType.REAL32, DataType.REAL64):
            return float(text)
        if kind is DataType.VISIBLE_STRING:
            return (_clean(text) or None) if text.isascii() else None
        return bytes.fromhex(text) or None
    except ValueError:
        return None  # manufacturers write byte strings in many forms
