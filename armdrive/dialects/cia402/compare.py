"""How CiA 402 drives are set up, compared with the arm file; and the lines that mend it.

A line is a drive's node number, an object, its type and its value: `3: 608F:01 u32 10000`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from armdrive.dialects.cia402.cycle import Script
from armdrive.dialects.cia402.homing import Cia402Homing
from armdrive.dialects.cia402.sdo_queue import ObjectRead, SdoQueue, refusal_words
from armdrive.errors import Refused
from armdrive.tasks import DeviceSettings, Difference, Done, RequestRejected
from firmware_protocol.canopen import (
    FAULT_REACTION_OPTION,
    FOLLOWING_ERROR_WINDOW,
    STANDARD,
    DataType,
    Place,
    Write,
)

ENCODER, MOTOR_TURNS = Place(0x608F, 1), Place(0x608F, 2)
GEAR_MOTOR, GEAR_SHAFT = Place(0x6091, 1), Place(0x6091, 2)
FEED, FEED_TURNS = Place(0x6092, 1), Place(0x6092, 2)
POLARITY = Place(0x607E)
_LINE = re.compile(
    r"\s*(\d{1,3})\s*:\s*([0-9A-Fa-f]{4}):([0-9A-Fa-f]{2})\s+([iu])(8|16|32)\s+(-?\d{1,10})\s*"
)
_NOT_BY_LINE = range(0x1000, 0x2000)
_NEVER = (0x6040, 0x6060, 0x607A)
"""What would move a motor, or let it go."""


@dataclass(frozen=True, slots=True)
class WantedObject:
    """An object as it has to be: what people call it, and whether nothing moves without it."""

    write: Write
    name: str
    must: bool = True


class Cia402Comparing(Cia402Homing):
    """Reads settings, compares and mends them."""

    def compare(self) -> Script:
        """Read what the arm depends on; what a drive does not have is not compared."""
        began_s, wanted = self.now_s, self._wanted()
        lanes = yield from self.everywhere(*(ObjectRead(one.write.place) for one in wanted))
        if (missing := self.missing(lanes, began_s)) is not None:
            return missing
        return DeviceSettings(tuple(self._differing(lanes, wanted)))

    def _wanted(self) -> tuple[WantedObject, ...]:
        rows = [
            WantedObject(Write(POLARITY, DataType.U8, 0), "polarity"),
            WantedObject(Write(GEAR_MOTOR, DataType.U32, 1), "gear ratio, motor turns"),
            WantedObject(Write(GEAR_SHAFT, DataType.U32, 1), "gear ratio, shaft turns"),
            WantedObject(
                Write(FOLLOWING_ERROR_WINDOW, DataType.U32, self.settings.following_window),
                "following error window",
                must=False,
            ),
            WantedObject(
                Write(FAULT_REACTION_OPTION, DataType.I16, 2), "fault reaction", must=False
            ),
        ]
        if self.settings.encoder_increments:
            increments = self.settings.encoder_increments
            rows += (
                WantedObject(Write(ENCODER, DataType.U32, increments), "encoder increments"),
                WantedObject(Write(MOTOR_TURNS, DataType.U32, 1), "encoder increments, turns"),
                WantedObject(Write(FEED, DataType.U32, increments), "feed constant"),
                WantedObject(Write(FEED_TURNS, DataType.U32, 1), "feed constant, turns"),
            )
        return tuple(rows)

    def _differing(
        self, lanes: Mapping[int, SdoQueue], wanted: tuple[WantedObject, ...]
    ) -> list[Difference]:
        return [
            Difference(
                f"{one.name} ({one.write.place}) of {lane.drive}",
                str(found),
                str(one.write.value),
                mending_line(lane.drive.node, one.write),
                one.must,
            )
            for one in wanted
            for lane in lanes.values()
            if (found := lane.values.get(one.write.place)) not in (None, one.write.value)
        ]

    def mend(self, line: str) -> Script:
        """Write one object."""
        node, write = parsed_line(line)
        if node not in self._by_node:
            raise Refused(f"`{line}`: no drive of this arm has the node number {node}")
        lanes = yield from self.transfer({node: (write,)})
        self.last_said = line
        if lanes[node].mute:
            return RequestRejected(self.absent_words((lanes[node].drive,)), moved=False)
        if lanes[node].refused:
            return RequestRejected(refusal_words(lanes[node], write.place), moved=False)
        return Done()


def mending_line(node: int, write: Write) -> str:
    """Return the line that writes an object."""
    kind = f"{'i' if write.type.signed else 'u'}{write.type.bits}"
    return f"{node}: {write.place} {kind} {write.value}"


def parsed_line(line: str) -> tuple[int, Write]:
    """Read a mending line. Raises `Refused` for one that sets nothing, or would move a motor."""
    found = _LINE.fullmatch(line)
    if found is None:
        raise Refused(f"`{line}` is no setting of a drive: write one as `3: 608F:01 u32 10000`")
    place = Place(int(found[2], 16), int(found[3], 16))
    if place.index in _NOT_BY_LINE or place.index in _NEVER:
        raise Refused(f"`{line}` sets nothing that can be mended so")
    kind = DataType[f"{found[4].upper()}{found[5]}"]
    entry = STANDARD.find(place)
    try:
        write = Write(place, entry.type if entry is not None else kind, int(found[6]))
        write.data  # noqa: B018 - raises where the value does not fit
    except ValueError as error:
        raise Refused(f"`{line}` is no setting of a drive: {error}") from None
    return int(found[1]), write
