"""The driver's knowledge of a GRBL board: its state, its position, its axes and its firmware.

`BoardState.learn` takes every message that the board sends, whichever script waits for it. It also
decides whether a banner or an alarm answers the driver's own reset, or shows that the board has
restarted, which costs the position.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

from armdrive.dialects.grbl.planner import SegmentBuffer
from armdrive.dialects.grbl.settings import PINS, BoardAxes, GrblSettings
from armdrive.dialects.grbl.variants import BEHAVIOURS, Behaviour, cautious
from armdrive.dialects.words import plain
from armdrive.tasks import Alert, AlertKind, Event, ProtocolWarning, Registers
from firmware_protocol.grbl import (
    AXIS_LETTERS,
    AlarmRaised,
    AxesInfo,
    Host,
    Restarted,
    Setting,
    State,
    StatusReport,
    Stray,
    Unreadable,
    Variant,
    Version,
)
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.spaces import Motors

# The start of a status report, with its coordinates.
REPORTED_POSITION = re.compile(rb"<[A-Za-z:0-9]+\|MPos:([-0-9.,]+)[|>]")
MOVING = (State.RUN, State.JOG, State.HOME)
HELD = (State.HOLD, State.DOOR, State.TOOL)
# States in which the board executes no lines; a reset leaves them.
LINES_IGNORED = (*HELD, State.SLEEP, State.CHECK)
# Alarms that our own reset raises if it ends a motion (3), homing (6), or homing that backs off a
# pressed switch (8): observed on grbl-Mega-5X.
ABORT_ALARMS = (3, 6, 8)
# Longest time from our own reset of a board at rest to its greeting, including the wire. After its
# reset button or a power failure a board takes longer, because its boot loader runs first. Such a
# restart zeroes the counts, but zero counts prove nothing if they were zero before.
OWN_RESET_S = 0.4
# In this time after a reset in motion was answered, a greeting or an alarm may answer a second
# reset. grblHAL starts once more if 0x18 comes again in the 0.1 s before its greeting. FluidNC
# reads two resets together while it homes, and answers each with alarm and greeting. Observed: 5 ms
# later.
AGAIN_S = 0.25


class BoardState:
    """The latest known state of one board.

    `contacted` means that contact has been made, and `recognised` that the firmware's description
    was read without a damaged line. `aborted` means that a reset ended a motion, or that the reset
    may not have been ours. `lacking` are axes of the arm that the board does not have.
    """

    def __init__(self, host: Host, settings: GrblSettings, axes: BoardAxes) -> None:
        self.state: State | str | None = None
        self.sub_state: int | None = None
        self.free_blocks: int | None = None
        self.room = 0
        """How many lines have room in the planner while the board stands."""
        self.position: Motors | None = None
        self.inputs = 0
        self.alarm: AlarmRaised | None = None
        self.firmware = ""
        self.reported_settings: dict[int | str, str] = {}
        self.contacted = self.recognised = False
        self.greeted_first = False
        """Whether the board sent a greeting before contact, and no reset of ours was the cause."""
        self.aborted = False
        self.lacking = ""
        self.garbled = 0
        self.underruns = 0
        """How often the board ran out of lines in the middle of a motion."""
        self._host = host
        self._settings = settings
        self._axes = axes
        self._reset_moving = False
        self._greets_by_s = -math.inf

    def reset_sent(self, by_s: float, *, moving: bool) -> None:
        """Expect the greeting that answers our own reset.

        A board that was reset in motion releases its motors and raises an alarm first, and its
        greeting may be late. Its position is lost, so it does not matter whose reset it was.
        """
        self._reset_moving = moving
        self._greets_by_s = math.inf if moving else by_s

    # -- learning -----------------------------------------------------------------------------

    def learn(self, message: HostEvent, now_s: float) -> Event | None:
        """Update the state from any message; return an event if the engine should know of it."""
        match message:
            case StatusReport():
                self._learn_status(message)
            case AlarmRaised():
                return self._learn_alarm(message, now_s)
            case Restarted():
                return self._learn_restart(message, now_s)
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

    def _learn_status(self, report: StatusReport) -> None:
        self.state, self.sub_state = report.state, report.sub_state
        self.free_blocks = report.free_blocks
        if self.state is not State.ALARM:
            self.alarm = None
        pins = report.pins or ""
        self.inputs = sum(1 << bit for bit, pin in enumerate(PINS) if pin in pins)
        if report.machine_position is not None and not self.lacking:
            self.position = self._axes.motors(report.machine_position, self.letters)

    def _learn_alarm(self, message: AlarmRaised, now_s: float) -> Alert | None:
        self.alarm, self.state = message, State.ALARM
        if message.code in ABORT_ALARMS and now_s <= self._greets_by_s:
            self.aborted = True  # the expected result of our own reset
            self.reset_sent(now_s, moving=True)
            return None
        kind = AlertKind.ALARM if message.position_kept else AlertKind.ALARM_LOST
        return Alert(kind, self.alarm_words()) if self.contacted else None

    def _learn_restart(self, message: Restarted, now_s: float) -> Alert | None:
        own = now_s <= self._greets_by_s
        self._greets_by_s = now_s + AGAIN_S if own and self._reset_moving else -math.inf
        self.greeted_first |= not (own or self.contacted)
        self.aborted |= not own
        self.alarm = self.state = None
        if message.banner.firmware:
            self.firmware = message.banner.firmware
        if own or not self.contacted:
            return None
        words = "the board was reset, or lost its power, and counts from zero again"
        return Alert(AlertKind.RESTARTED, words)

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
        behaviour = self.behaviour
        return SegmentBuffer(self._settings.segments or behaviour.segments, behaviour.slowest_hz)

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
        return (
            f"the board is in alarm {self.alarm.code} ({self.alarm.meaning}): "
            f"{self.alarm.remedy}. Until then the board may not answer, even if the cable is fine"
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
    def in_motion(self) -> bool:
        """Whether the board was moving at its latest report."""
        return self.state in MOVING or (self.state is State.HOLD and bool(self.sub_state))

    @property
    def standing(self) -> bool:
        """Whether the board is Idle with an empty planner; Idle alone may precede a motion."""
        planned = self.free_blocks is not None and self.free_blocks < self.room
        return self.state is State.IDLE and not planned
