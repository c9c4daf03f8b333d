"""Who answers to the id of an MKS drive: which firmware, and whether it is one drive alone.

Connecting to an arm, surveying a bus and setting a drive up all find it out here. Nothing is set,
nothing turns.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from armdrive.dialects.mks.wire import Asking, MksWire
from firmware_protocol.mks import (
    Code,
    Read,
    ReadAngleError,
    ReadEncoder,
    ReadRawEncoder,
    ReadSetting,
    ReadVersion,
    SettingRead,
    Version,
    VersionRead,
)

# Which firmware a drive has. Before 1.0.8 none tells: it is concluded from what it answers.

OLDEST: Version = (1, 0, 4)
"""What is taken for the firmware of a drive that tells neither its version nor a setting."""


@dataclass(frozen=True, slots=True)
class Firmware:
    """A drive's firmware. `told` says whether that is its own word, or a conclusion.

    `read` is what it said when it was asked, board and calibration included; None of old firmware.
    """

    version: Version = OLDEST
    told: bool = False
    read: VersionRead | None = None

    def __str__(self) -> str:
        return ".".join(map(str, self.version))


UNTOLD = Firmware()


def firmware_of(wire: MksWire, nodes: Collection[int]) -> Asking[dict[int, Firmware]]:
    """Find out which firmware each of some drives has."""
    told = yield from wire.read(ReadVersion(), nodes)
    found = {}
    for node in nodes:
        read = told.get(node)
        if not isinstance(read, VersionRead):
            mode = yield from wire.reading(node, ReadSetting(Code.MODE))
            found[node] = UNTOLD if mode is None else Firmware((1, 0, 6))
        elif read.version is None:
            watchdog = yield from wire.reading(node, ReadSetting(Code.WATCHDOG))
            has_one = isinstance(watchdog, SettingRead) and watchdog.value is not None
            found[node] = Firmware((1, 0, 9) if has_one else (1, 0, 8), read=read)
        else:
            found[node] = Firmware(read.version, told=True, read=read)
    return found


# Whether two drives have one id. Both answer each question then, and are told apart where they
# say different things: two frames that are alike look like one on the bus.

TELLTALES: tuple[Read, ...] = (ReadEncoder(), ReadRawEncoder(), ReadAngleError())
"""Readings that are hardly ever alike in two drives: an encoder trembles."""
TIMES = 3
"""How often each is asked for."""
LINGER_S = 0.03
"""A second drive of the same id answers within this time after the first."""
LATE_S = 0.2
"""An answer that has not come by then never will, on however busy a computer."""


def is_shared(wire: MksWire, node: int) -> Asking[bool]:
    """Find out whether two drives answer to an id. Those that say the same are not told apart."""
    for message in TELLTALES:
        wire.surplus.clear()
        for _ in range(TIMES):
            yield from wire.reading(node, message, tries=1)
            yield from wire.pause(wire.now_s + LINGER_S)
        if wire.surplus.owed:
            yield from wire.pause(wire.now_s + LATE_S)
        if node in wire.surplus.shared:
            return True
    return False


def shared_words(ids: Collection[int]) -> str:
    """Say which ids two drives answer to; empty where none is."""
    if not ids:
        return ""
    named = ", ".join(map(str, ids))
    return (
        f"more than one drive answers to the id {named}: every drive ships with id 1. Unplug "
        "all but one and give each an id of its own, one at a time"
    )
