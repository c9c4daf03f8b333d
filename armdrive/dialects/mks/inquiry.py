"""Questions to an MKS drive: its firmware, whether it is alone, why it does not move.

Connecting to an arm, surveying a bus and setting a drive up all ask here. Nothing is set and
nothing turns.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.dialects.bus.drives import off_target_words
from armdrive.dialects.bus.observer import DriveFinding, ObservedDrive, Verdict
from armdrive.dialects.mks.stops import restarted_words
from armdrive.dialects.mks.wire import MksWire, WireScript, obeys_bus
from armdrive.tasks import Alert, AlertKind
from firmware_protocol.mks import (
    Ability,
    Code,
    EnabledRead,
    Mode,
    MotorState,
    Read,
    ReadEnabled,
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
from kinematics.text import counted

# The firmware of a drive. Before 1.0.8 it does not report its version, which then follows from the
# questions that it answers.

OLDEST: Version = (1, 0, 4)
"""Assumed for a drive that reports neither its version nor a setting."""


@dataclass(frozen=True, slots=True)
class Firmware:
    """A drive's firmware: `reported` by the drive, or concluded.

    `read` is its answer, with board and calibration; None from old firmware.
    """

    version: Version = OLDEST
    reported: bool = False
    read: VersionRead | None = None

    def __str__(self) -> str:
        return ".".join(map(str, self.version))


UNKNOWN_FIRMWARE = Firmware()


def firmware_of(wire: MksWire, nodes: Collection[int]) -> WireScript[dict[int, Firmware]]:
    """Find out the firmware of each drive."""
    answers = yield from wire.read(ReadVersion(), nodes)
    found = {}
    for node in nodes:
        read = answers.get(node)
        if not isinstance(read, VersionRead):
            mode = yield from wire.reading(node, ReadSetting(Code.MODE))
            found[node] = UNKNOWN_FIRMWARE if mode is None else Firmware((1, 0, 6))
        elif read.version is None:
            watchdog = yield from wire.reading(node, ReadSetting(Code.WATCHDOG))
            has_one = isinstance(watchdog, SettingRead) and watchdog.value is not None
            found[node] = Firmware((1, 0, 9) if has_one else (1, 0, 8), read=read)
        else:
            found[node] = Firmware(read.version, reported=True, read=read)
    return found


def shared_words(ids: Collection[int]) -> str:
    """Return which ids two drives answer to; empty if there are none."""
    if not ids:
        return ""
    named = ", ".join(map(str, ids))
    return (
        f"more than one drive answers to the id {named}: every drive ships with id 1. Unplug "
        "all but one and give each an id of its own, one at a time"
    )


# Why a drive does not follow its orders.

Words: TypeAlias = WireScript[str]


class MksInquiry:
    """Finds out what keeps drives from moving."""

    def __init__(self, wire: MksWire) -> None:
        self._wire = wire

    def states(self, nodes: Collection[int] | None = None) -> WireScript[Mapping[int, MotorState]]:
        """Read the drives' motor states."""
        found = yield from self._wire.read(ReadState(), nodes)
        return {node: each.state for node, each in found.items() if isinstance(each, StateRead)}

    def stalled(self, nodes: Collection[int]) -> WireScript[list[int]]:
        """Return the drives whose stall protection has released the shaft."""
        found = yield from self._wire.read(ReadStall(), nodes)
        return [node for node, each in found.items() if each == StallRead(on=True)]

    def off(self, nodes: Collection[int]) -> WireScript[list[int]]:
        """Return the drives whose motors have no current."""
        found = yield from self._wire.read(ReadEnabled(), nodes)
        return [node for node, each in found.items() if each == EnabledRead(on=False)]

    def stall_words(self, node: int) -> str:
        """Return that a drive's stall protection has acted."""
        return (
            f"{self._wire.drive(node)} has stalled, and its protection has let the shaft go: find "
            "out what blocked it, or give it more current or less speed"
        )

    def mode_words(self, node: int) -> Words:
        """Return that a drive is in a mode that the bus cannot move; empty if it is not."""
        if not self._wire.can(Ability.READ_SETTINGS):
            return ""
        mode = yield from self._wire.setting(node, Code.MODE)
        if not isinstance(mode, SetMode) or obeys_bus(mode):
            return ""
        return (
            f"{self._wire.drive(node)} is in mode {int(mode.mode)} ({mode.mode.name}), in which "
            f"the bus moves nothing: set mode {int(Mode.BUS_FOC)} (Menu > Mode > SR_vFOC, or "
            "`armdrive doctor --mend`)"
        )

    def ask_fitness(self, node: int) -> None:
        """Ask a moving drive what may keep it from moving; `wire.unfit` takes the answers.

        Waits for nothing, since the other drives are still moving and a stop must not wait.
        """
        questions: list[Read | ReadSetting] = [ReadStall(), ReadEnabled()]
        if self._wire.can(Ability.READ_SETTINGS):
            questions.append(ReadSetting(Code.MODE))
        for question in questions:
            self._wire.put(node, question)

    def obstructed(self, node: int) -> WireScript[Alert | None]:
        """Return what keeps a drive from moving: a stall, no current, or its mode; or None."""
        if (yield from self.stalled((node,))):
            return Alert(AlertKind.SWITCHED_OFF, self.stall_words(node))
        if (yield from self.off((node,))):
            words = f"{self._wire.drive(node)} has switched its motor off"
            return Alert(AlertKind.SWITCHED_OFF, words)
        mode = yield from self.mode_words(node)
        return Alert(AlertKind.OFF_PATH, mode) if mode else None

    def explain(self, verdict: Verdict) -> WireScript[Alert]:
        """Find out why a drive is in the wrong place, and what that means for the arm."""
        drive = self._wire.drive(verdict.node)
        if verdict.finding is DriveFinding.RESTARTED:
            stalled = yield from self.stalled((drive.node,))
            if not stalled:
                return Alert(AlertKind.RESTARTED, restarted_words(drive))
        obstructed = yield from self.obstructed(drive.node)
        return obstructed or Alert(AlertKind.OFF_PATH, _departed_words(drive, verdict))

    def found_at_rest(self, drive: ObservedDrive) -> WireScript[Alert]:
        """Find out why a drive that had no new target has moved."""
        now_s, count = self._wire.now_s, drive.count or 0
        restarted = drive.counts_from_zero(now_s, now_s)
        finding = DriveFinding.RESTARTED if restarted else DriveFinding.ELSEWHERE
        verdict = Verdict(drive.node, finding, count, drive.goal)
        return (yield from self.explain(verdict))


def _departed_words(drive: ObservedDrive, verdict: Verdict) -> str:
    if verdict.finding in (DriveFinding.OFF_PATH, DriveFinding.WEAK):
        return (
            f"{drive} has {counted(round(verdict.off), 'count')} of following error; the "
            "other drives are on the "
            "path. It is overloaded, or its supply is too weak for its speed"
        )
    return off_target_words(drive, verdict.count, round(verdict.place), "counts")
