"""The drives' own homing (mode 6), in the arm file's groups: each searches for its switch.

The drive itself counts from its home offset where it has found that. Nothing here sets a zero.
"""

from __future__ import annotations

from collections.abc import Collection

from armdrive.dialects.cia402.cycle import Script
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.power import Hindrance
from armdrive.dialects.cia402.profile import Cia402Profile
from armdrive.dialects.cia402.sdo_queue import refusal_words
from armdrive.tasks import Done, Halted, RequestRejected
from firmware_protocol.canopen import (
    Command,
    ControlBit,
    Controlword,
    DataType,
    OperationMode,
    Place,
    StatusBit,
    Write,
)

MODE = OperationMode.HOMING
METHOD, TOWARDS, AWAY = Place(0x6098), Place(0x6099, 1), Place(0x6099, 2)
GO = Controlword.of(Command.ENABLE_OPERATION, ControlBit.NEW_SET_POINT)
BEYOND = 1.1
"""A search that goes this much farther than a motor's whole range will find nothing."""
SHOWN_TURNS = 10
"""A homing of before is shown for no longer: who is home after so many turns is home again."""
PROGRESS_TURNS = 5


class Cia402Homing(Cia402Profile):
    """Has drives home themselves."""

    ranges: tuple[float, ...] = ()
    """How far each motor turns, in increments, between the limits of its joints."""

    def home(self, groups: tuple[tuple[int, ...], ...]) -> Script:
        """Home group after group; all drives, one after the other, where none is named."""
        hindrance = yield from self.prepare(self.resting_mode)
        if hindrance is not None:
            return hindrance
        for group in groups or tuple((motor,) for motor in range(len(self.drives))):
            reply = yield from self._home_group(tuple(self.drives[motor] for motor in group))
            if not isinstance(reply, Done):
                return reply
        return Done()

    def _home_group(self, group: tuple[Cia402Drive, ...]) -> Script:
        hindrance = yield from self._write_methods(group)
        if hindrance is None:
            hindrance = yield from self.take_mode(group, MODE)
        if hindrance is not None:
            return hindrance
        self.last_said = "HOME"
        reply = yield from self._search(group)
        if not isinstance(reply, Done):
            return reply
        for drive in group:
            drive.rest()
        return (yield from self.take_mode(group, self.resting_mode)) or Done()

    def _write_methods(self, group: Collection[Cia402Drive]) -> Hindrance:
        """Tell the drives how they shall search, as far as the arm file says so."""
        lanes = yield from self.transfer({drive.node: self._jobs(drive) for drive in group})
        for lane in lanes.values():
            if lane.mute:
                return RequestRejected(self.absent_words((lane.drive,)), moved=False)
            for place in lane.refused:
                return RequestRejected(refusal_words(lane, place), moved=False)
        return None

    def _jobs(self, drive: Cia402Drive) -> tuple[Write, ...]:
        methods, jobs = self.settings.homing_methods, []
        if methods:
            jobs.append(Write(METHOD, DataType.I8, methods[self.drives.index(drive)]))
        for place, speed in zip((TOWARDS, AWAY), self.settings.homing_speeds, strict=True):
            if speed:
                jobs.append(Write(place, DataType.U32, speed))
        return tuple(jobs)

    def _search(self, group: tuple[Cia402Drive, ...]) -> Script:
        began_s, turns = self.now_s, 0
        start = {drive.node: drive.seen for drive in group}
        left = {drive.node: drive.word is None or _at_home(drive) for drive in group}
        while left:
            if self.stop_asked:
                return (yield from self._given_up(""))
            if self.now_s > began_s + self.settings.homing_s:
                return (yield from self._given_up(f"{self._by_node[min(left)]} found no switch"))
            for drive in group:
                self.command(drive, GO, MODE, drive.seen)
            yield from self.turn_of_motion()
            turns += 1
            if (ended := None if self.stop_asked else (yield from self._in_homing())) is not None:
                return ended
            words = self._looked_at(left, start, turns)
            if words:
                return (yield from self._given_up(words))
            if turns % PROGRESS_TURNS == 0:
                self.progress()
        return Done()

    def _in_homing(self) -> Hindrance:
        """Look at all drives; those that do not home are in their resting mode."""
        for drive in self.drives:
            if (alert := self.trouble(drive, moving=True)) is not None:
                return (yield from self.broken_off(alert, drive))
        if mute := self.mute(self.drives):
            return (yield from self.lost(mute))
        return None

    def _looked_at(self, left: dict[int, bool], start: dict[int, int], turns: int) -> str:
        """Forget drives that are home, and say what went wrong.

        One that showed to be at home before it began has to show that it is not, first.
        """
        for node in tuple(left):
            drive = self._by_node[node]
            if drive.missed > 1 or drive.word is None:
                continue
            if drive.word.has(StatusBit.FOLLOWING_ERROR):
                return f"{drive} did not find its switch or stop"
            if not _at_home(drive):
                left[node] = False
                if abs(drive.seen - start[node]) > BEYOND * self.ranges[self._motor(drive)] + 1:
                    return f"{drive} found no switch within its joints' limits"
            elif turns > 1 and (not left[node] or turns > SHOWN_TURNS):
                del left[node]
        return ""

    def _motor(self, drive: Cia402Drive) -> int:
        return self.drives.index(drive)

    def _given_up(self, words: str) -> Script:
        """End a homing that went wrong or was stopped: every drive is stopped."""
        unstopped = yield from self.halt()
        if words:
            return RequestRejected(words)
        return unstopped or Halted()


def _at_home(drive: Cia402Drive) -> bool:
    word = drive.word
    return word is not None and word.has(StatusBit.ACKNOWLEDGED) and word.has(StatusBit.REACHED)
