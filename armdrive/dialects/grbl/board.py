"""What is known of a GRBL board: its state, its position, and the answers that it owes."""

from __future__ import annotations

import math
import re
from dataclasses import replace

from armdrive.dialects.grbl.planner import SEGMENTS, SegmentBuffer, segments_of
from armdrive.dialects.grbl.settings import PINS, BoardAxes, GrblSettings
from armdrive.tasks import Alert, AlertKind, Event, ProtocolWarning, Registers
from firmware_protocol.grbl import (
    AXIS_LETTERS,
    AlarmRaised,
    AxesInfo,
    BuildInfo,
    Host,
    Restarted,
    Setting,
    State,
    StatusReported,
    Unexpected,
    Unreadable,
    Variant,
    Version,
)
from firmware_protocol.grbl.dialect import RING_BYTES_MAX
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.spaces import Motors

# The `?` that a GRBL board has been asked: how long it has been mute, and what they may leave.
#
# A board answers a `?` within milliseconds, but in homing and while it starts. One that was
# changed on the wire is no `?` to it but a character, and stands in front of the next line.


class Polls:
    """What is unanswered: `since_s` is when the oldest was asked, infinity where none is left.

    `stray` tells whether a character may stand in the board's line.
    """

    def __init__(self) -> None:
        self.stray = False
        self.since_s = math.inf

    def ask(self, now_s: float) -> None:
        """Take in that a report is asked for; where one was asked for before, that one is lost."""
        self.stray |= self.since_s < now_s
        self.since_s = min(self.since_s, now_s)

    def answered(self) -> None:
        """Take in a report."""
        self.since_s = math.inf

    def begin_anew(self) -> None:
        """Take in a banner: the board has forgotten what stood in its line."""
        self.since_s = math.inf
        self.stray = False


# The greeting of a GRBL board: whether it answers a reset of our own, or was said unasked.
#
# A board that stands and is reset by 0x18 greets within milliseconds. One whose button was
# pressed, or that had lost its power, takes longer: its loader comes first. Its counts are zero
# then, which says nothing where they had been zero before; so the time has to.

GREETS_S = 0.4
"""How long a reset of our own takes a board that stood, and what it says on the wire."""


class Greeting:
    """What is expected: `awaited` from a reset of our own until its greeting comes."""

    def __init__(self) -> None:
        self.awaited = False
        self._by_s = math.inf

    def await_soon(self, now_s: float, asked_s: float) -> None:
        """Expect that of a board that stands; where it owes a report for long, none is credible."""
        self.awaited = True
        self._by_s = now_s + GREETS_S if asked_s > now_s - GREETS_S else -math.inf

    def await_late(self) -> None:
        """Expect that of a board whose motion is ended: it lets its motors go and raises an alarm.

        Its position is lost, whatever has reset it.
        """
        self.awaited = True
        self._by_s = math.inf

    def give_up(self) -> None:
        """Expect none any longer."""
        self.awaited = False

    def answers(self, now_s: float) -> bool:
        """Take in that one has come; tell whether it is the one that was awaited."""
        answers = self.awaited and now_s <= self._by_s
        self.awaited = False
        return answers


COORDINATES = re.compile(rb"<[A-Za-z:0-9]+\|[MW]Pos:([-0-9.,]+)[|>]")
"""How a report begins."""
LEAST_RING = 128
"""What the smallest board has, in bytes: a board that tells of less gets one line at a time."""
TURNING = (State.RUN, State.JOG, State.HOME)
HELD = (State.HOLD, State.DOOR, State.TOOL)
DEAF = (*HELD, State.SLEEP, State.CHECK)
"""States in which lines are not carried out, and which a reset leaves."""
ABORTED = (3, 6)
"""Alarms that our own reset raises where it ends a motion: of a motion, and of homing."""


class BoardState:
    """What one board has said, and what it is expected to say.

    `contacted` says that contact was made, `recognised` that the firmware was read without a flaw,
    `modes_set` that the parser is in the modes of our lines. `aborted` says that a reset has ended
    a motion, or may have been somebody else's. `lacking` are axes of the arm that the board does
    not have, and `blocks` is how many lines its planner takes.
    """

    def __init__(self, host: Host, settings: GrblSettings, axes: BoardAxes) -> None:
        self.state: State | str | None = None
        self.sub_state: int | None = None
        self.reported: StatusReported | None = None
        self.position: Motors | None = None
        self.inputs = 0
        self.alarm: AlarmRaised | None = None
        self.firmware = ""
        self.told: dict[int | str, str] = {}
        self.contacted = self.recognised = False
        self.modes_set = False
        self.aborted = False
        self.blocks = settings.max_segments
        self.lacking = ""
        self.garbled = 0
        self.polls = Polls()
        self.greeting = Greeting()
        self._host = host
        self._settings = settings
        self._axes = axes
        self._most_free = 0
        self._free: int | None = None
        self._planner_blocks: int | None = None

    # -- learning -----------------------------------------------------------------------------

    def learn(self, heard: HostEvent, now_s: float) -> Event | None:
        """Take in anything that the board says; return what the engine should know of it."""
        match heard:
            case StatusReported():
                self._learn_status(heard)
            case AlarmRaised():
                return self._learn_alarm(heard)
            case Restarted():
                return self._learn_restart(heard, now_s)
            case BuildInfo():
                self._learn_build(heard)
            case AxesInfo(_, letters):
                self._learn_axes("".join(dict.fromkeys(letters)))
            case Version(version):
                self.firmware = version
            case Setting(key, value):
                self.told[key] = value
            case Unreadable(data):
                self.garbled += 1
                if not self.contacted:
                    self._count_axes(data)
                return ProtocolWarning(str(heard))
            case Unexpected():
                return ProtocolWarning(str(heard))
        return None

    def _count_axes(self, report: bytes) -> None:
        """Learn from a report of another number of coordinates how many axes the board has."""
        found = COORDINATES.match(report)
        count = found[1].count(b",") + 1 if found else 0
        if count == len(self._axes.letters):
            self._learn_axes(self._axes.board())
        elif 0 < count <= len(AXIS_LETTERS):
            self._learn_axes(AXIS_LETTERS[:count])

    def _learn_axes(self, letters: str) -> None:
        """Take in which axes the board has, in its own order, and which it lacks."""
        self._host.dialect = replace(self._host.dialect, axes=letters)
        self.lacking = "".join(letter for letter in self._axes.letters if letter not in letters)

    def _learn_status(self, heard: StatusReported) -> None:
        report = heard.report
        self.reported = heard
        self.polls.answered()
        self.state, self.sub_state = report.state, report.sub_state
        if self.state is not State.ALARM:
            self.alarm = None
        free = report.free_blocks
        if free is not None and free == self._free:  # a report has no check bytes
            self._most_free = max(self._most_free, free)
        self._free = free
        pins = report.pins or ""
        self.inputs = sum(1 << bit for bit, pin in enumerate(PINS) if pin in pins)
        if heard.machine_position is not None and not self.lacking:
            self.position = self._axes.motors(heard.machine_position, self._host.dialect.axes)

    def _learn_alarm(self, heard: AlarmRaised) -> Alert | None:
        self.alarm, self.state = heard, State.ALARM
        if self.greeting.awaited and heard.code in ABORTED:
            self.aborted = True  # we have asked for it
            self.greeting.await_late()
            return None
        kind = AlertKind.ALARM if heard.position_kept else AlertKind.ALARM_LOST
        return Alert(kind, self.alarm_words()) if self.contacted else None

    def _learn_restart(self, heard: Restarted, now_s: float) -> Alert | None:
        own = self.greeting.answers(now_s)
        self.aborted |= not own
        self.polls.begin_anew()
        self.modes_set = False
        self.alarm = self.state = None
        if heard.banner.firmware:
            self.firmware = heard.banner.firmware
        if own or not self.contacted:
            return None
        words = "the board was reset, or lost its power, and counts from zero again"
        return Alert(AlertKind.RESTARTED, words)

    def _learn_build(self, build: BuildInfo) -> None:
        self._planner_blocks = build.blocks
        if build.blocks:
            self.blocks = min(self._settings.max_segments, build.blocks)
        ring = build.rx_bytes or 0  # a damaged number may leave no room for a line, for ever
        self._host.ring_bytes = ring if LEAST_RING <= ring <= RING_BYTES_MAX else None

    # -- what is known ------------------------------------------------------------------------

    @property
    def letters(self) -> str:
        """The axes of the board, in its own order."""
        return self._host.dialect.axes

    @property
    def variant(self) -> Variant:
        """Which firmware of the family it is."""
        return self._host.dialect.variant

    @property
    def segment_buffer(self) -> SegmentBuffer:
        """The board's segment buffer; as the largest of all, until the firmware is known."""
        if self._settings.segments is not None:
            return SegmentBuffer(self._settings.segments)
        if not self.recognised:
            return SegmentBuffer(max(SEGMENTS.values()))
        return SegmentBuffer(segments_of(self.variant, self._planner_blocks))

    def alarm_words(self) -> str:
        """Say what the board's alarm is, and what to do."""
        if self.alarm is None:
            return "the board is locked by an alarm"
        number = "" if self.alarm.code is None else f" {self.alarm.code}"
        return (
            f"the board is in alarm{number} ({self.alarm.meaning}): {self.alarm.remedy}. It may "
            "answer nothing until then, which is no broken wire"
        )

    def registers(self) -> Registers:
        """Return the position as it was reported last."""
        return Registers(self.position or Motors((0,) * len(self._axes.letters)), self.inputs)

    @property
    def located(self) -> bool:
        """Tell whether the machine position follows from the last report."""
        return self.reported is not None and self.reported.machine_position is not None

    @property
    def in_motion(self) -> bool:
        """Tell whether the board moved when it was heard of last."""
        return self.state in TURNING or (self.state is State.HOLD and bool(self.sub_state))

    @property
    def standing(self) -> bool:
        """Tell whether the board is Idle with an empty planner; Idle alone may precede a motion."""
        return self.state is State.IDLE and not self.planner_holds()

    def planner_holds(self) -> int | None:
        """Return how many lines were in the planner by the last report; None where it is silent."""
        free = None if self.reported is None else self.reported.report.free_blocks
        return None if free is None else self._most_free - free
