"""What an MKS drive is asked about itself: firmware, whether it is alone, why it does not move.

Connecting to an arm, surveying a bus and setting a drive up all find it out here. Nothing is set,
nothing turns.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.dialects.bus.observer import Finding, ObservedDrive, Verdict
from armdrive.dialects.mks.stops import restarted_words
from armdrive.dialects.mks.wire import Asking, MksWire
from armdrive.tasks import Alert, AlertKind
from firmware_protocol.mks import (
    Ability,
    Code,
    EnabledRead,
    Mode,
    MotorState,
    Read,
    ReadAngleError,
    ReadEnabled,
    ReadEncoder,
    ReadRawEncoder,
    ReadSetting,
    ReadStall,
    ReadState,
    ReadVersion,
    SetMode,
    SettingRead,
    StallRead,
    StateRead,
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


# What is wrong with an MKS drive that does not do what it was told: it is asked, and named.

Words: TypeAlias = Asking[str]


class MksInquiry:
    """Asks drives what keeps them from moving."""

    def __init__(self, wire: MksWire) -> None:
        self._wire = wire

    def states(self, nodes: Collection[int] | None = None) -> Asking[Mapping[int, MotorState]]:
        """Ask drives what they do."""
        found = yield from self._wire.read(ReadState(), nodes)
        return {node: told.state for node, told in found.items() if isinstance(told, StateRead)}

    def stalled(self, nodes: Collection[int]) -> Asking[list[int]]:
        """Return those of some drives whose protection has let the shaft go."""
        found = yield from self._wire.read(ReadStall(), nodes)
        return [node for node, told in found.items() if told == StallRead(on=True)]

    def off(self, nodes: Collection[int]) -> Asking[list[int]]:
        """Return those of some drives whose motors have no current."""
        found = yield from self._wire.read(ReadEnabled(), nodes)
        return [node for node, told in found.items() if told == EnabledRead(on=False)]

    def stall_words(self, node: int) -> str:
        """Say that a drive's protection has acted."""
        return (
            f"{self._wire.drive(node)} has stalled, and its protection has let the shaft go: look "
            "what blocked it, or give it more current or less speed"
        )

    def mode_words(self, node: int) -> Words:
        """Say that a drive is in a mode in which the bus cannot move it; empty where it is not."""
        if not self._wire.can(Ability.READ_SETTINGS):
            return ""
        mode = yield from self._wire.setting(node, Code.MODE)
        if not isinstance(mode, SetMode) or mode.mode.on_bus:
            return ""
        return (
            f"{self._wire.drive(node)} is in mode {int(mode.mode)} ({mode.mode.name}), in which "
            f"the bus moves nothing: set mode {int(Mode.BUS_FOC)} (Menu > Mode > SR_vFOC, or "
            "`armdrive doctor --mend`)"
        )

    def hindered(self, node: int) -> Asking[Alert | None]:
        """Find what keeps a drive from moving: a stall, no current, or a mode; None for nothing."""
        if (yield from self.stalled((node,))):
            return Alert(AlertKind.SWITCHED_OFF, self.stall_words(node))
        if (yield from self.off((node,))):
            words = f"{self._wire.drive(node)} has switched its motor off"
            return Alert(AlertKind.SWITCHED_OFF, words)
        mode = yield from self.mode_words(node)
        return Alert(AlertKind.ASTRAY, mode) if mode else None

    def explain(self, verdict: Verdict) -> Asking[Alert]:
        """Find out why a drive is where it should not be, and what that means for the arm."""
        drive = self._wire.drive(verdict.node)
        if verdict.finding is Finding.RESTARTED:
            stalled = yield from self.stalled((drive.node,))
            if not stalled:
                return Alert(AlertKind.RESTARTED, restarted_words(drive))
        hindered = yield from self.hindered(drive.node)
        return hindered or Alert(AlertKind.ASTRAY, _off_words(drive, verdict))

    def found_at_rest(self, drive: ObservedDrive) -> Asking[Alert]:
        """Find out why a drive that was not sent anywhere is elsewhere."""
        now_s, count = self._wire.now_s, drive.count or 0
        anew = drive.counts_from_zero(now_s, now_s)
        finding = Finding.RESTARTED if anew else Finding.ELSEWHERE
        verdict = Verdict(drive.node, finding, count, drive.goal)
        return (yield from self.explain(verdict))


def _off_words(drive: ObservedDrive, verdict: Verdict) -> str:
    if verdict.finding in (Finding.OFF_WAY, Finding.WEAK):
        return (
            f"{drive} is {verdict.off:.0f} counts beside its way, which the others keep: it is "
            "overloaded, or its supply is too weak for its speed"
        )
    return (
        f"{drive} is at {verdict.count}, not at {round(verdict.place)} counts: it is blocked, "
        "overloaded, was turned by force, or was reset"
    )
