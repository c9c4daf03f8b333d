"""The driver's knowledge of a GRBL board: its state, its position and its unanswered queries.

`BoardState.learn` takes every message that the board sends, whichever exchange waits for it. Two
small state machines help: `Polls` remembers which queries have no report yet, and `Greeting`
decides whether a banner or an alarm answers the driver's own reset or shows that the board has
restarted, which costs the position.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

from armdrive.dialects.grbl.planner import SegmentBuffer
from armdrive.dialects.grbl.settings import PINS, BoardAxes, GrblSettings
from armdrive.dialects.grbl.variants import BEHAVIOURS, BLOCKS_328P, Behaviour, cautious
from armdrive.dialects.words import plain
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
    Stray,
    Unreadable,
    Variant,
    Version,
)
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.spaces import Motors

# Unanswered status queries (`?`): how long the board has been mute, and what they may leave behind.
#
# A board answers a `?` within milliseconds, except while it homes or starts up. If the byte is
# damaged on the wire, the board takes it for an ordinary character in front of the next line.


class Polls:
    """The status queries: `asked_s` is the time of the latest one.

    `since_s` is the time of the oldest unanswered one, or infinity. `stray` means that the board's
    input line may hold a stray character.
    """

    def __init__(self) -> None:
        self.stray = False
        self.asked_s = -math.inf
        self.since_s = math.inf

    @property
    def awaited(self) -> bool:
        """Whether a query is unanswered."""
        return self.since_s < math.inf

    def ask(self, now_s: float) -> None:
        """Record a query. If an earlier one is still unanswered, that one was lost."""
        self.stray |= self.since_s < now_s
        self.asked_s, self.since_s = now_s, min(self.since_s, now_s)

    def answered(self) -> None:
        """Record a report."""
        self.since_s = math.inf

    def restarted(self) -> None:
        """Record a banner: after a restart, the board's input line is empty."""
        self.since_s = math.inf
        self.stray = False


# The greeting (banner) of a GRBL board: does it answer our own reset, or did the board restart?
#
# A board at rest that is reset by 0x18 greets within milliseconds. After its reset button or a
# power failure it takes longer, because its boot loader runs first. Such a restart zeroes the
# counts, but zero counts prove nothing if they were zero before. So the delay has to decide.

# Longest time from our own reset of a board at rest to its greeting, including the wire.
OWN_RESET_S = 0.4
# In this time after a reset in motion was answered, a greeting or an alarm may answer a second
# reset. grblHAL starts once more if 0x18 comes again in the 0.1 s before its greeting. FluidNC
# reads two resets together while it homes, and answers each with alarm and greeting. Observed: 5 ms
# later.
AGAIN_S = 0.25


class Greeting:
    """The expected greeting; `awaited` is true from our own reset until the greeting arrives."""

    def __init__(self) -> None:
        self.awaited = False
        self._by_s = math.inf
        self._again_s = -math.inf

    def await_soon(self, now_s: float, asked_s: float) -> None:
        """Expect the greeting of a board at rest.

        If the board has not answered a query for long, no greeting counts as an answer to ours.
        """
        self.awaited = True
        self._by_s = now_s + OWN_RESET_S if asked_s > now_s - OWN_RESET_S else -math.inf

    def await_late(self) -> None:
        """Expect the greeting of a board reset in motion, however late.

        Such a board releases its motors and raises an alarm first. Its position is lost, so it does
        not matter whose reset it was.
        """
        self.awaited = True
        self._by_s = math.inf

    def give_up(self) -> None:
        """Stop expecting a greeting."""
        self.awaited = False

    def ended_motion(self, now_s: float) -> bool:
        """Record an alarm that a reset raises; return whether it answers our own reset.

        The greeting is then still to come, however late.
        """
        answers = self.awaited or now_s <= self._again_s
        if answers:
            self.await_late()
        return answers

    def answers(self, now_s: float) -> bool:
        """Record a greeting; return whether it answers our own reset."""
        answers = (self.awaited and now_s <= self._by_s) or now_s <= self._again_s
        if self.awaited and math.isinf(self._by_s):
            self._again_s = now_s + AGAIN_S
        self.awaited = False
        return answers


# The start of a status report, with its coordinates.
REPORTED_POSITION = re.compile(rb"<[A-Za-z:0-9]+\|[MW]Pos:([-0-9.,]+)[|>]")
MOVING = (State.RUN, State.JOG, State.HOME)
HELD = (State.HOLD, State.DOOR, State.TOOL)
# States in which the board executes no lines; a reset leaves them.
LINES_IGNORED = (*HELD, State.SLEEP, State.CHECK)
# Alarms that our own reset raises if it ends a motion (3), homing (6), or homing that backs off a
# pressed switch (8): observed on grbl-Mega-5X.
ABORT_ALARMS = (3, 6, 8)


class BoardState:
    """The latest known state of one board, and the answers expected from it.

    `contacted` means that contact has been made, `recognised` that the firmware's description was
    read without a damaged line, and `modes_set` that the parser is in the modes that our lines
    need. `aborted` means that a reset ended a motion, or that the reset may not have been ours.
    `lacking` are axes of the arm that the board does not have. `blocks` is the most lines in the
    planner at a time: its size, or that of the smallest one, an ATmega328P's.
    """

    def __init__(self, host: Host, settings: GrblSettings, axes: BoardAxes) -> None:
        self.state: State | str | None = None
        self.sub_state: int | None = None
        self.reported: StatusReported | None = None
        self.position: Motors | None = None
        self.inputs = 0
        self.alarm: AlarmRaised | None = None
        self.firmware = ""
        self.reported_settings: dict[int | str, str] = {}
        self.contacted = self.recognised = False
        self.greeted_first = False
        """Whether the board sent a greeting before contact, and no reset of ours was the cause."""
        self.modes_set = False
        self.aborted = False
        self.blocks = BLOCKS_328P
        self.lacking = ""
        self.garbled = 0
        self.underruns = 0
        """How often the board ran out of lines in the middle of a motion."""
        self.polls = Polls()
        self.greeting = Greeting()
        self._host = host
        self._settings = settings
        self._axes = axes
        self._most_free = 0
        self._free: int | None = None
        self._planner_blocks: int | None = None

    # -- learning -----------------------------------------------------------------------------

    def learn(self, message: HostEvent, now_s: float) -> Event | None:
        """Update the state from any message; return an event if the engine should know of it."""
        match message:
            case StatusReported():
                self._learn_status(message)
            case AlarmRaised():
                return self._learn_alarm(message, now_s)
            case Restarted():
                return self._learn_restart(message, now_s)
            case BuildInfo():
                self._learn_build(message)
            case AxesInfo(letters):
                self._learn_axes("".join(dict.fromkeys(letters)))
            case Version(version):
                self.firmware = version
            case Setting(key, value):
                self.reported_settings[key] = value
            case Unreadable(data):
                self.garbled += 1
                if not self.contacted:
                    self._count_axes(data)
                return ProtocolWarning(plain(message))
            case Stray():
                return ProtocolWarning(plain(message))
        return None

    def _count_axes(self, report: bytes) -> None:
        """Learn the number of axes from a report with an unexpected number of coordinates."""
        found = REPORTED_POSITION.match(report)
        count = found[1].count(b",") + 1 if found else 0
        if count == len(self._axes.letters):
            self._learn_axes(self._axes.board())
        elif 0 < count <= len(AXIS_LETTERS):
            self._learn_axes(AXIS_LETTERS[:count])

    def _learn_axes(self, letters: str) -> None:
        """Record the board's axes, in its own order, and the axes that it lacks."""
        self._host.dialect = replace(self._host.dialect, axes=letters)
        self.lacking = "".join(letter for letter in self._axes.letters if letter not in letters)

    def _learn_status(self, message: StatusReported) -> None:
        report = message.report
        self.reported = message
        self.polls.answered()
        self.state, self.sub_state = report.state, report.sub_state
        if self.state is not State.ALARM:
            self.alarm = None
        free = report.free_blocks
        # a report has no checksum, so a number counts only when two reports in a row give it
        if free is not None and free == self._free:
            self._most_free = max(self._most_free, free)
        self._free = free
        pins = report.pins or ""
        self.inputs = sum(1 << bit for bit, pin in enumerate(PINS) if pin in pins)
        if message.machine_position is not None and not self.lacking:
            self.position = self._axes.motors(message.machine_position, self._host.dialect.axes)

    def _learn_alarm(self, message: AlarmRaised, now_s: float) -> Alert | None:
        self.alarm, self.state = message, State.ALARM
        if message.code in ABORT_ALARMS and self.greeting.ended_motion(now_s):
            self.aborted = True  # the expected result of our own reset
            return None
        kind = AlertKind.ALARM if message.position_kept else AlertKind.ALARM_LOST
        return Alert(kind, self.alarm_words()) if self.contacted else None

    def _learn_restart(self, message: Restarted, now_s: float) -> Alert | None:
        own = self.greeting.answers(now_s)
        self.greeted_first |= not (own or self.contacted)
        self.aborted |= not own
        self.polls.restarted()
        self.modes_set = False
        self.alarm = self.state = None
        if message.banner.firmware:
            self.firmware = message.banner.firmware
        if own or not self.contacted:
            return None
        words = "the board was reset, or lost its power, and counts from zero again"
        return Alert(AlertKind.RESTARTED, words)

    def _learn_build(self, build: BuildInfo) -> None:
        self._planner_blocks = build.blocks
        if build.blocks:
            self.blocks = min(BLOCKS_328P, build.blocks)

    # -- what is known ------------------------------------------------------------------------

    @property
    def letters(self) -> str:
        """The axes of the board, in its own order."""
        return self._host.dialect.axes

    @property
    def variant(self) -> Variant:
        """The firmware, out of the GRBL family."""
        return self._host.dialect.variant

    @property
    def behaviour(self) -> Behaviour:
        """How its firmware behaves; with the dangers of all firmwares until it has been named."""
        behaviour = BEHAVIOURS[self.variant]
        return behaviour if self.recognised else cautious(behaviour)

    @property
    def segment_buffer(self) -> SegmentBuffer:
        """The board's segment buffer."""
        segments = self._settings.segments or self.behaviour.segments_of(self._planner_blocks)
        return SegmentBuffer(segments, self.behaviour.slowest_hz)

    def firmware_words(self) -> str:
        """Return the firmware and its version; FluidNC's version names it already."""
        named = str(self.variant) in self.firmware
        return (self.firmware if named else f"{self.variant} {self.firmware}").strip()

    def alarm_words(self) -> str:
        """Return a text that names the board's alarm and its remedy."""
        if self.alarm is None:
            bits = self._settings.limit_inputs.items()
            pressed = ", ".join(axis for axis, bit in bits if self.inputs >> bit & 1)
            if pressed:  # GRBL 1.1 and grbl-Mega-5X start locked then, with $21=1
                return f"the board is locked by an alarm, and a limit switch is pressed ({pressed})"
            homes = ", as after each start until it has homed" if self._settings.homing else ""
            return f"the board is locked by an alarm{homes}"
        number = "" if self.alarm.code is None else f" {self.alarm.code}"
        return (
            f"the board is in alarm{number} ({self.alarm.meaning}): {self.alarm.remedy}. Until "
            "then the board may not answer, even if the cable is fine"
        )

    def locked_words(self) -> str:
        """Return that the board is locked by its alarm, and what unlocks it."""
        return f"{self.alarm_words()}. Look at the arm, then call `reset()` to unlock it"

    def busy_words(self) -> str:
        """Return that the board is in a state in which it takes no motion, and what leaves it."""
        return f"the board's state is {self.state}; `reset()` leaves it"

    def registers(self) -> Registers:
        """Return the position from the latest report."""
        return Registers(self.position or Motors((0,) * len(self._axes.letters)), self.inputs)

    @property
    def located(self) -> bool:
        """Whether the latest report gives the machine position."""
        return self.reported is not None and self.reported.machine_position is not None

    @property
    def may_keep_line(self) -> bool:
        """Whether the board may have read a line in its hold that a reset would not drop."""
        return self.behaviour.keeps_line and self.state in HELD

    @property
    def in_motion(self) -> bool:
        """Whether the board was moving at its latest report."""
        return self.state in MOVING or (self.state is State.HOLD and bool(self.sub_state))

    @property
    def standing(self) -> bool:
        """Whether the board is Idle with an empty planner; Idle alone may precede a motion."""
        return self.state is State.IDLE and not self.planner_holds()

    def planner_holds(self) -> int | None:
        """Return the number of lines in the planner by the latest report; None if not reported."""
        free = None if self.reported is None else self.reported.report.free_blocks
        return None if free is None else self._most_free - free
