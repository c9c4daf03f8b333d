"""How a GRBL board is brought to a stand-still, and what it takes to go on afterwards.

A feed hold, a wait for `Hold:0` and then a reset keep the position; a reset in motion loses it. A
jog is cancelled by 0x85, once: one that a board carries out as its jog ends leaves it Idle, and
reading no line any more. Seen on 3 of 259 jogs of a grbl-Mega-5X and on 2 of 264 of an ATmega328p,
with a cancel every 20 ms.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.dialects.grbl.exchange import LATE_REPORT_S, RESET_POLL_S, Asking, GrblTalk, refusal
from armdrive.dialects.grbl.in_flight import InFlightLines
from armdrive.dialects.grbl.receive import TURNING
from armdrive.tasks import RequestRejected, Timeout
from firmware_protocol.grbl import (
    Acknowledged,
    Coolant,
    DigitalOutput,
    Line,
    Modes,
    Realtime,
    State,
    StatusReported,
)
from firmware_protocol.grbl.events import Event as HostEvent

STOP_POLL_S = 0.02
"""How often a board that brakes is looked at."""
AGAIN_S = 0.04
"""A stop that is lost on the wire, or the report that would show it, is followed by another."""
IDLE_LOOKS = 10
TRIES = 3
HELD = (State.HOLD, State.DOOR, State.TOOL)
UNREAD = (
    "the board says it is idle but reads no line, also after a reset: switch it off and on, then "
    "home the arm"
)
DEAF = (*HELD, State.SLEEP, State.CHECK)
"""States in which lines are not carried out, and which a reset leaves."""


class GrblStopping(GrblTalk):
    """The ways to a stand-still."""

    outputs_on: int | None = None
    gripper_share: float | None = None
    brake_s = 1.0

    def watch(self, step_s: float) -> Generator[float, HostEvent | None, StatusReported | None]:
        """Ask for a report and wait a moment for it."""
        self.press(Realtime.STATUS)
        end_s = self.now_s + step_s
        found: StatusReported | None = None
        while self.now_s < end_s and not (self.stop_asked and self.stop_hard):
            heard = yield from self.listen(end_s)
            if isinstance(heard, StatusReported):
                found = heard
        return found

    def hold(self) -> Asking:
        """Brake, wait until the board stands, and reset it; False where steps may be lost.

        The reset is what empties ring and planner: a hold alone would go on at the next resume.
        A board that was never seen to stand may have been reset by somebody else meanwhile. One
        that is mute is left in its hold: nobody sees whether a reset would kill a motion.
        """
        end_s = self.now_s + self.brake_s + self.settings.answer_s
        idle, stood = 0, False
        while self.now_s < end_s and not self.stop_hard and not self.mute:
            if self.state not in HELD:  # one too many has no effect, one that is lost has none
                self.press(Realtime.FEED_HOLD)
            seen = yield from self.watch(STOP_POLL_S)
            if seen is None:
                continue
            idle = idle + 1 if self.state is State.IDLE and self.planner_empty() else 0
            stood = (
                (self.state in HELD and not self.sub_state)
                or self.state in (State.ALARM, State.SLEEP, State.CHECK)
                or (self.state is State.DOOR and self.sub_state == 1)
                or idle > IDLE_LOOKS  # a firmware that takes no hold while it stands
            )
            if stood:
                break
        if self.mute and not self.stop_hard:
            return False
        return (yield from self.reset_and_restore(moving=not stood)) and stood

    def kill(self, road: InFlightLines) -> Asking:
        """Stop dead; False where that ended a motion, as the board says or was seen to be in.

        Its words may be lost, or those of a board that somebody else has just reset.
        """
        moving = self.state in TURNING or not road.empty
        return (yield from self.reset_and_restore(moving=moving)) and not moving

    def end_homing(self) -> Generator[float, HostEvent | None, None]:
        """Reset a board that homes, which obeys nothing else. No report tells of a lost byte."""
        self.greeting.await_late()
        self.press(Realtime.SOFT_RESET)
        yield from self.pause(self.now_s + RESET_POLL_S)
        yield from self.soft_reset(moving=True)  # within the same reset, it has no effect

    def reset_and_restore(self, *, moving: bool) -> Asking:
        """Reset the board, and have its outputs and gripper as they were; tell what it kept."""
        alarmed = self.alarm is not None and not self.alarm.position_kept
        answered = yield from self.soft_reset(patient=False, moving=moving)
        kept = answered and not self.aborted and not alarmed
        if kept:
            yield from self.restore()
        return kept

    def restore(self) -> Generator[float, HostEvent | None, None]:
        """Switch on again what a reset switches off: a valve or a servo must not drop its load."""
        if self.gripper_share is not None:
            yield from self.drive_gripper(self.gripper_share)
        if self.outputs_on:
            yield from self.drive_outputs(self.outputs_on)

    def cancel_jog(self, road: InFlightLines) -> Asking:
        """End a jog and keep the position; False where steps may be lost.

        The line that is unanswered is waited for: a cancel does not reach lines in the ring. If the
        board still jogs after `AGAIN_S`, the byte of the cancel may be lost. A feed hold follows:
        it ends a jog as well, and one too many shows as Hold. Once the board is Idle, a line that
        it has to refuse proves that it reads lines, and that none is left in its ring to move it.
        """
        end_s = self.now_s + self.settings.answer_s
        while road.unanswered and self.now_s < end_s and not self.stop_hard:
            heard = yield from self.listen(min(end_s, self.now_s + LATE_OK_S))
            if isinstance(heard, Acknowledged):
                road.answered(self.now_s)
            elif heard is None and self.now_s >= road.oldest_sent_s + LATE_OK_S:
                break
        end_s = self.now_s + self.brake_s + self.settings.answer_s
        hold_s = self.now_s + AGAIN_S
        self.press(Realtime.JOG_CANCEL)
        while self.now_s < end_s and not self.stop_hard and not self.mute:
            seen = yield from self.watch(STOP_POLL_S)
            if seen is None:
                continue
            if self.state is State.JOG and self.now_s >= hold_s:
                self.press(Realtime.FEED_HOLD)
                hold_s = math.inf
            elif self.state is State.IDLE and self.planner_empty():
                if (yield from self.spoil()) and (yield from self._still_idle()):
                    return True
                break
            elif self.state in (*DEAF, State.ALARM, State.RUN):
                break
        if self.stop_hard:
            return (yield from self.kill(road))
        return (yield from self.hold())

    def _still_idle(self) -> Asking:
        """Look whether the board stands, behind all lines that it was sent."""
        self._host.forget_outstanding()
        seen = yield from self.look(LATE_REPORT_S)
        return seen and self.state is State.IDLE and self.planner_empty()

    def silence_of_mute(self) -> Timeout:
        """Return the reply to a motion whose board gives no report any more."""
        return Timeout("? (mute in motion; a feed hold was sent)", self.settings.mute_s)

    # -- lines that move nothing --------------------------------------------------------------

    def prepare(self) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """See to it that a motion can begin; return why it cannot, where it cannot.

        A report has no check bytes: one that surprises is believed when it comes twice.
        """
        seen: object = State.IDLE, self.position
        for _ in range(TRIES):
            if not (yield from self.look_position(self.settings.answer_s)):
                words = self.alarm_words() if self.alarm else "the board tells no position"
                return RequestRejected(words, moved=False)
            if seen == (self.state, self.position):
                break
            seen = self.state, self.position
        if self.state is State.ALARM:
            return RequestRejected(f"{self.alarm_words()}. `reset()` unlocks it", moved=False)
        if self.state is not State.IDLE:
            return RequestRejected(
                f"the board's state is {self.state}; `reset()` leaves it", moved=False
            )
        for _ in range(2):
            if (yield from self.clean_line()):
                refused = yield from self.set_modes()
                if refused is None or not self.polls.stray:
                    return refused
            if not (yield from self.free()):
                break
        return RequestRejected(UNREAD, moved=False)

    def free(self) -> Asking:
        """Reset a board that is Idle and reads no line, and tell whether it reads one now.

        A resume would free it as well, and have it carry out what waits in its ring. A reset of a
        board that stands keeps the position.
        """
        return (yield from self.reset_and_restore(moving=False)) and (yield from self.spoil())

    def set_modes(self) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """Put the parser into the modes that our lines are written for: harmless to repeat."""
        heard: HostEvent | None = None
        for _ in range(0 if self.modes_set else TRIES):
            if not (yield from self.clean_line()):
                break
            heard = yield from self.ask(Modes(relative=True), self.settings.answer_s)
            if isinstance(heard, Acknowledged):
                self.modes_set = True
                break
        return None if self.modes_set else refusal(heard, "the board's modes could not be set")

    def carry_out(
        self, commands: tuple[Line | Coolant | DigitalOutput, ...], what: str
    ) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """Say lines one at a time; return why one was refused."""
        for command in commands:
            heard = yield from self.ask(command, self.settings.answer_s)
            if not isinstance(heard, Acknowledged):
                return refusal(heard, what)
        return None

    def drive_gripper(
        self, share: float
    ) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """Command a gripper that is no stepper."""
        span = self.settings.servo_open - self.settings.servo_closed
        value = self.settings.servo_closed + span * share
        word = "S" if self.settings.servo == "M3" else "Q"
        line = Line(f"{self.settings.servo}{word}{value:.3f}".rstrip("0").rstrip("."))
        return (yield from self.carry_out((line,), "the gripper's servo"))

    def drive_outputs(
        self, bits: int
    ) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """Switch the outputs; flood and mist have one word to switch both off."""
        words = self.settings.outputs
        on = {word for bit, word in enumerate(words) if bits >> bit & 1}
        commands: list[Line | Coolant | DigitalOutput] = []
        if {"flood", "mist"} & set(words) - on:
            commands.append(Coolant(on=False))
        commands += [Coolant(on=True)] * ("flood" in on)
        commands += [Line("M7")] * ("mist" in on)
        commands += [
            DigitalOutput(int(word[1:]), word in on, at_once=True)
            for word in words
            if word.startswith("P")
        ]
        return (yield from self.carry_out(tuple(commands), "the outputs"))


LATE_OK_S = 0.3
"""The ok of a jog's line that has not come by then was lost."""
