"""Talking to a GRBL board: one line and its answer, reports, resets, and what comes unasked."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Generator
from dataclasses import replace
from typing import TypeAlias

from armdrive.abilities import Abilities
from armdrive.controllers.grbl_axes import PINS, Axes
from armdrive.controllers.grbl_settings import GrblSettings
from armdrive.controllers.requests import (
    Alert,
    AlertKind,
    Denied,
    Oddity,
    Registers,
    Reply,
    Request,
)
from armdrive.controllers.scripted import BITS_A_BYTE, Scripted
from firmware_protocol.grbl import (
    Acknowledged,
    AlarmRaised,
    AxesInfo,
    BuildInfo,
    Command,
    Dialect,
    Host,
    Realtime,
    Refused,
    Restarted,
    Setting,
    State,
    StatusReported,
    Unexpected,
    Unreadable,
    Variant,
    Version,
)
from firmware_protocol.grbl.events import Event as HostEvent
from kinematics.spaces import Motors

Waiting: TypeAlias = Generator[float, HostEvent | None, None]
Asking: TypeAlias = Generator[float, HostEvent | None, bool]
Answering: TypeAlias = Generator[float, HostEvent | None, Reply]

LATE_REPORT_S = 0.25
"""A report that has not come by then was lost."""
RESET_S = 1.5
"""A board says its banner within this after a reset; one that kills its motors waits 0.26 s."""
RESETS = 3
ABORTED = (3, 6)
"""Alarms that our own reset raises where it ends a motion: of a motion, and of homing."""
REPORTS_TO_OFFSET = 40
"""The work offset comes with one report in thirty at least."""


class GrblTalk(Scripted[HostEvent]):
    """What the driver knows of one board, and how it asks for more."""

    def __init__(self, abilities: Abilities, settings: GrblSettings, axes: Axes, baud: int) -> None:
        self._host = Host(
            Dialect(axes=axes.board(), ring_bytes=None, outputs=True, crlf_answers_twice=False)
        )
        super().__init__(abilities, self._host)
        self.settings = settings
        self.axes = axes
        self.byte_s = BITS_A_BYTE / baud
        self.wire_free_s = -math.inf
        self.state: State | str | None = None
        self.sub_state: int | None = None
        self.reported: StatusReported | None = None
        self.position: Motors | None = None
        self.inputs = 0
        self.most_free = 0
        self.alarm: AlarmRaised | None = None
        self.firmware = ""
        self.told: dict[int | str, str] = {}
        self.contacted = False
        self.modes_set = False
        self.aborted = False
        self.blocks = settings.max_segments
        self._resetting = False

    @abstractmethod
    def script(self, request: Request) -> Answering:
        """Return the script that carries out a request."""

    # -- saying -------------------------------------------------------------------------------

    def say(self, data: bytes, text: str = "") -> None:
        """Put bytes on the wire, and know when they are through."""
        super().say(data, text)
        self.wire_free_s = max(self.wire_free_s, self.now_s) + len(data) * self.byte_s

    def speak(self, command: Command) -> None:
        """Say a line."""
        self.say(self._host.send(command), command.text)

    def press(self, command: Realtime) -> None:
        """Say a real-time command."""
        shown = "" if command is Realtime.STATUS else command.name.lower().replace("_", " ")
        self.say(self._host.send_realtime(command), shown)

    def give_up(self) -> None:
        """Forget unanswered lines and half a message."""
        self._host.forget_outstanding()
        self._host.discard()
        self._resetting = False

    # -- hearing ------------------------------------------------------------------------------

    def listen(self, until_s: float) -> Generator[float, HostEvent | None, HostEvent | None]:
        """Wait for whatever comes next; None when the time is over or a stop is asked for."""
        heard = yield until_s
        if heard is not None:
            self.weigh(heard)
        return heard

    def unasked(self, heard: HostEvent) -> None:
        """Weigh what no script was waiting for."""
        self.weigh(heard)

    def weigh(self, heard: HostEvent) -> None:
        """Learn from anything that the board says, whoever waits for it."""
        match heard:
            case StatusReported():
                self._learn_status(heard)
            case AlarmRaised():
                self._learn_alarm(heard)
            case Restarted():
                self._learn_restart(heard)
            case BuildInfo():
                self._learn_build(heard)
            case AxesInfo(_, letters):
                if set(self.axes.letters) <= set(letters):
                    self._host.dialect = replace(
                        self._host.dialect, axes="".join(dict.fromkeys(letters))
                    )
            case Version(version):
                self.firmware = version
            case Setting(key, value):
                self.told[key] = value
            case Unexpected() | Unreadable():
                self.tell(Oddity(str(heard)))

    def _learn_status(self, heard: StatusReported) -> None:
        report = heard.report
        self.reported = heard
        self.state, self.sub_state = report.state, report.sub_state
        if self.state is not State.ALARM:
            self.alarm = None
        if report.free_blocks is not None:
            self.most_free = max(self.most_free, report.free_blocks)
        pins = report.pins or ""
        self.inputs = sum(1 << bit for bit, pin in enumerate(PINS) if pin in pins)
        if heard.machine_position is not None:
            self.position = self.axes.motors(heard.machine_position, self._host.dialect.axes)

    def _learn_alarm(self, heard: AlarmRaised) -> None:
        self.alarm, self.state = heard, State.ALARM
        if self._resetting and heard.code in ABORTED:
            self.aborted = True  # we have asked for it
            return
        kind = AlertKind.ALARM if heard.position_kept else AlertKind.ALARM_LOST
        if self.contacted:
            self.tell(Alert(kind, self.alarm_words()))

    def _learn_restart(self, heard: Restarted) -> None:
        own, self._resetting = self._resetting, False
        self.modes_set = False
        self.alarm = self.state = None
        if heard.banner.firmware:
            self.firmware = heard.banner.firmware
        if self.contacted and not own:
            self.tell(
                Alert(
                    AlertKind.RESTARTED,
                    "the board was reset, or lost its power, and counts from zero again",
                )
            )

    def _learn_build(self, build: BuildInfo) -> None:
        if build.blocks:
            self.blocks = min(self.settings.max_segments, build.blocks)
        dialect = replace(self._host.dialect, ring_bytes=build.rx_bytes)
        if "H" in build.letters or dialect.variant is not Variant.GRBL:
            dialect = replace(dialect, single_axis_homing=True)
        self._host.dialect = dialect

    @property
    def variant(self) -> Variant:
        """Which firmware of the family it is."""
        return self._host.dialect.variant

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
        return Registers(self.position or Motors((0,) * len(self.axes.letters)), self.inputs)

    def planner_empty(self) -> bool:
        """Tell whether the last report has no motion in the planner; Idle alone may precede it."""
        free = None if self.reported is None else self.reported.report.free_blocks
        return free is None or free >= self.most_free

    # -- asking -------------------------------------------------------------------------------

    def look(self, patience_s: float) -> Asking:
        """Ask for a report until one comes; False where none did. Moves nothing."""
        end_s = self.now_s + patience_s
        while self.now_s < end_s:
            self.press(Realtime.STATUS)
            again_s = min(self.now_s + LATE_REPORT_S, end_s)
            while self.now_s < again_s:
                heard = yield from self.listen(again_s)
                if isinstance(heard, StatusReported):
                    return True
        return False

    def look_position(self) -> Asking:
        """Look until the machine position is known, which may need the work offset's report."""
        for _ in range(REPORTS_TO_OFFSET):
            if not (yield from self.look(self.settings.answer_s)):
                return False
            if self.reported is not None and self.reported.machine_position is not None:
                return True
        return False

    def ask(
        self, command: Command, patience_s: float
    ) -> Generator[
        float, HostEvent | None, Acknowledged | Refused | Restarted | AlarmRaised | None
    ]:
        """Say one line and wait for its answer, or for what ends the waiting; None is silence."""
        self._host.forget_outstanding()
        self.speak(command)
        end_s = self.wire_free_s + patience_s
        while self.now_s < end_s:
            heard = yield from self.listen(end_s)
            if isinstance(heard, Acknowledged | Refused | Restarted | AlarmRaised):
                return heard
        self._host.forget_outstanding()
        return None

    def soft_reset(self) -> Asking:
        """Reset the board and wait for its banner; `aborted` tells whether that killed a motion."""
        self.aborted = False
        for _ in range(RESETS):
            self._resetting = True
            self.press(Realtime.SOFT_RESET)
            end_s = self.now_s + RESET_S
            while self.now_s < end_s:
                heard = yield from self.listen(end_s)
                if isinstance(heard, Restarted):
                    return True
            self._host.forget_outstanding()  # the banner may have been garbled
            self._resetting = False
            self.modes_set = False
            if (yield from self.look(2.0 * LATE_REPORT_S)):
                return True
        return False


def refusal(heard: HostEvent | None, what: str, *, moved: bool = False) -> Denied:
    """Return the reply that says why a line was not carried out."""
    match heard:
        case Refused(_, code, meaning, remedy):
            number = "" if code is None else f"error {code}, "
            return Denied(f"{what}: {number}{meaning}; {remedy}", moved)
        case AlarmRaised(_, meaning, remedy):
            return Denied(f"{what}: the board went into alarm ({meaning}); {remedy}", moved)
        case Restarted():
            return Denied(f"{what}: the board was reset or lost its power", moved)
    return Denied(f"{what}: the board did not answer", moved)
