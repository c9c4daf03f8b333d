"""Compare the objects of CiA 402 drives with the arm file, and correct them line by line.

A line is a drive's node number, an object, its type and its value: `3: 608F:01 u32 10000`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from armdrive.dialects.cia402.contact import BRAKE
from armdrive.dialects.cia402.exchange import Cia402Exchange
from armdrive.dialects.cia402.objects import value_words
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.cia402.transfers import Script
from armdrive.errors import Refused
from armdrive.tasks import DeviceSettings, Difference, Done, Reply
from firmware_protocol import canopen
from firmware_protocol.canopen import DataType, Place, Write

_LINE = re.compile(
    r"\s*(\d{1,3})\s*:\s*([0-9A-Fa-f]{4}):([0-9A-Fa-f]{2})\s+([iu])(8|16|32)\s+(-?\d{1,10})\s*"
)
_COMMUNICATION = range(0x1000, 0x2000)
# Objects that could move a motor, or let it go: controlword, mode, targets and their offsets.
_MOVING = (0x6040, 0x6060, 0x6071, 0x607A, 0x60B0, 0x60B1, 0x60B2, 0x60C1, 0x60FF)


def wanted(settings: Cia402Settings) -> tuple[tuple[Write, str, bool], ...]:
    """Return the required objects, their names, and whether every motion needs them."""
    u8, u32, turns = DataType.U8, DataType.U32, settings.encoder_increments
    rows = (
        (Write(Place(0x607E), u8, 0), "polarity", True),
        (Write(canopen.POSITION_UNIT, u32, canopen.POSITION_INCREMENTS), "unit of position", True),
        (Write(Place(0x6091, 1), u32, 1), "gear ratio, motor turns", True),
        (Write(Place(0x6091, 2), u32, 1), "gear ratio, shaft turns", True),
        (
            Write(canopen.FOLLOWING_ERROR_WINDOW, u32, settings.following_window),
            "following error window",
            False,
        ),
        (BRAKE, "fault reaction", False),
    )
    if not turns:
        return rows
    return (
        *rows,
        (Write(Place(0x608F, 1), u32, turns), "encoder increments", True),
        (Write(Place(0x608F, 2), u32, 1), "encoder increments, turns", True),
        (Write(Place(0x6092, 1), u32, turns), "feed constant", True),
        (Write(Place(0x6092, 2), u32, 1), "feed constant, turns", True),
    )


def compare(io: Cia402Exchange) -> Script[Reply]:
    """Compare the objects that the arm depends on, as far as a drive has them."""
    rows = wanted(io.settings)
    wanted_values = {write.place: write.value for write, _, _ in rows}
    results = yield from io.obtain(dict.fromkeys(io.drives, tuple(wanted_values)))
    differences = tuple(
        Difference(
            f"{name} ({write.place}) of {result.drive}",
            value_words(write.place, found),
            value_words(write.place, write.value),
            fix_line(result.drive.node, write),
            must,
        )
        for write, name, must in rows
        for result in results
        if (found := result.values.get(write.place)) not in (None, write.value)
        and not _same_ratio(write.place.index, result.values, wanted_values)
    )
    return DeviceSettings(differences)


def _same_ratio(index: int, found: Mapping[Place, int], wanted_values: Mapping[Place, int]) -> bool:
    """Return whether an object is the wanted ratio in other numbers.

    6091 of Yiyou's EuServo is 5308416 to 5308416 and cannot be written (its EDS file).
    """
    over, under = Place(index, 1), Place(index, 2)
    if over not in wanted_values or under not in wanted_values:
        return False
    left = found.get(over, 0) * wanted_values[under]
    return left != 0 and left == found.get(under, 0) * wanted_values[over]


def fix(io: Cia402Exchange, line: str) -> Script[Reply]:
    """Write one object."""
    node, write = parsed_line(line)
    if node not in io.by_node:
        raise Refused(f"`{line}`: no drive of this arm has the node number {node}")
    io.last_command = line
    yield from io.put({io.by_node[node]: (write,)})
    return Done()


def fix_line(node: int, write: Write) -> str:
    """Return the line that writes an object."""
    return f"{node}: {write.place} {write.type.name.lower()} {write.value}"


def parsed_line(line: str) -> tuple[int, Write]:
    """Parse such a line. Raises `Refused` if it writes no setting, or could move a motor."""
    found = _LINE.fullmatch(line)
    if found is None:
        raise Refused(f"`{line}` is not a drive setting: write one like `3: 608F:01 u32 10000`")
    place = Place(int(found[2], 16), int(found[3], 16))
    if place.index in _COMMUNICATION or place.index in _MOVING:
        raise Refused(f"`{line}` writes nothing that may be changed this way")
    kind = DataType[f"{found[4].upper()}{found[5]}"]
    entry = canopen.STANDARD.find(place)
    try:
        write = Write(place, entry.type if entry is not None else kind, int(found[6]))
        write.data  # noqa: B018 - raises where the value does not fit
    except ValueError as error:
        raise Refused(f"`{line}` is not a drive setting: {error}") from None
    return int(found[1]), write
