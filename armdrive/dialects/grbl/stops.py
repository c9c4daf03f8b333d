"""How a GRBL board is stopped, and the outputs that a stop's reset switches off."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.grbl.board import DEAF, HELD, TURNING, BoardState
from armdrive.dialects.grbl.exchange import LATE_REPORT_S, Answering, Asking, GrblExchange, refusal
from armdrive.dialects.grbl.planner import AGAIN_S, InFlightLines
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.errors import Refused
from armdrive.tasks import Done, RequestRejected
from firmware_protocol.grbl import (
    Acknowledged,
    Coolant,
    DigitalOutput,
    Line,
    Realtime,
    State,
    StatusReported,
)
from firmware_protocol.grbl.host import Event as HostEvent

TOLD = {"M3", "flood", "mist"}
"""The outputs of which a status report says that they are on (gnea/grbl grbl/report.c)."""

Switching = Generator[float, HostEvent | None, RequestRejected | None]


class GrblOutputs:
    """Switches outputs and drives a gripper that is no stepper; knows what was last asked of them.

    `reset_lets_go` says that a reset can switch off what the gripper hangs on, and `reported` that
    a status report tells whether that is on.
    """

    def __init__(self, exchange: GrblExchange, settings: GrblSettings, gripper: str) -> None:
        self._exchange = exchange
        self._settings = settings
        self._gripper = gripper
        self._bits: int | None = None
        self._share: float | None = None
        self.reset_lets_go = gripper in ("servo", "output")
        outputs = settings.outputs[settings.gripper_output :][:1]
        hangs_on = (settings.servo,) if gripper == "servo" else outputs
        self.reported = set(hangs_on) <= TOLD

    def check(self, bits: int) -> None:
        """Raise `Refused` where the arm file names no output for one of the bits."""
        if bits >> len(self._settings.outputs):
            raise Refused(
                f"this board has {len(self._settings.outputs)} outputs, {bits} needs more: "
                "name them in grbl.outputs"
            )

    def check_gripper(self) -> None:
        """Raise `Refused` where the gripper is driven by a motor."""
        if not self.reset_lets_go:
            raise Refused("this arm's gripper is driven by a motor, not by a servo or output")

    def set(self, bits: int) -> Answering:
        """Switch the outputs."""
        refused = yield from self._switch(bits)
        if refused is None:
            self._bits = bits
        return refused or Done()

    def set_gripper(self, share: float) -> Answering:
        """Open the gripper so far: 0 is closed, 1 is open."""
        if self._gripper == "output":
            bit = 1 << self._settings.gripper_output
            closed = share < 0.5  # the driver asks for 0 or 1 alone
            before = self._bits or 0
            on = closed == self._settings.gripper_closes
            return (yield from self.set(before | bit if on else before & ~bit))
        refused = yield from self._turn_servo(share)
        if refused is None:
            self._share = share
        return refused or Done()

    def restore(self) -> Generator[float, HostEvent | None, None]:
        """Switch on again what a reset switches off: a valve or a servo must not drop its load."""
        if self._share is not None:
            yield from self._turn_servo(self._share)
        if self._bits:
            yield from self._switch(self._bits)

    def _turn_servo(self, share: float) -> Switching:
        span = self._settings.servo_open - self._settings.servo_closed
        value = self._settings.servo_closed + span * share
        word = "S" if self._settings.servo == "M3" else "Q"
        line = Line(f"{self._settings.servo}{word}{value:.3f}".rstrip("0").rstrip("."))
        return (yield from self._carry_out((line,), "the gripper's servo"))

    def _switch(self, bits: int) -> Switching:
        """Switch the outputs; flood and mist have one word to switch both off."""
        words = self._settings.outputs
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
        return (yield from self._carry_out(tuple(commands), "the outputs"))

    def _carry_out(
        self, commands: tuple[Line | Coolant | DigitalOutput, ...], what: str
    ) -> Switching:
        """Say lines one at a time; return why one was refused."""
        for command in commands:
            heard = yield from self._exchange.ask(command, self._settings.answer_s)
            if not isinstance(heard, Acknowledged):
                return refusal(heard, what)
        return None


# How a GRBL board is brought to a stand-still, and what it takes to go on afterwards.
#
# A feed hold, a wait for `Hold:0` and then a reset keep the position; a reset in motion loses it.
# A jog is cancelled by 0x85, once: a cancel that arrives as the jog ends leaves the board Idle and
# reading no line. Seen on 3 of 259 jogs of a grbl-Mega-5X and on 2 of 264 of an ATmega328p, with a
# cancel every 20 ms.

STOP_POLL_S = 0.02
"""How often a board that brakes is looked at."""
IDLE_LOOKS = 10
LATE_OK_S = 0.3
"""The ok of a jog's line that has not come by then was lost."""


@dataclass(slots=True, eq=False)
class GrblStops:
    """The ways to a stand-still.

    `brake_s` is how long the motion under way takes to a stand-still at most.
    """

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    outputs: GrblOutputs
    settings: GrblSettings
    brake_s: float = 1.0

    def _watch(self, step_s: float) -> Generator[float, HostEvent | None, StatusReported | None]:
        """Ask for a report and wait a moment for it."""
        self.exchange.press(Realtime.STATUS)
        end_s = self.io.now_s + step_s
        found: StatusReported | None = None
        while self.io.now_s < end_s and not self.io.stop_hard:
            heard = yield from self.exchange.listen(end_s)
            if isinstance(heard, StatusReported):
                found = heard
        return found

    def hold(self) -> Asking:
        """Brake, wait until the board stands, and reset it; False where steps may be lost.

        The reset is what empties ring and planner: a hold alone would go on at the next resume.
        A board that was never seen to stand may have been reset by somebody else meanwhile. One
        that is mute is left in its hold: nobody sees whether a reset would kill a motion.
        """
        end_s = self.io.now_s + self.brake_s + self.settings.answer_s
        idle, stood = 0, False
        while self._may_wait(end_s):
            if self.board.state not in HELD:  # a second hold has no effect, and one may be lost
                self.exchange.press(Realtime.FEED_HOLD)
            seen = yield from self._watch(STOP_POLL_S)
            if seen is None:
                continue
            idle = idle + 1 if self.board.standing else 0
            state, sub_state = self.board.state, self.board.sub_state
            stood = (
                (state in HELD and not sub_state)
                or state in (State.ALARM, State.SLEEP, State.CHECK)
                or (state is State.DOOR and sub_state == 1)
                or idle > IDLE_LOOKS  # a firmware that takes no hold while it stands
            )
            if stood:
                break
        if self.exchange.mute and not self.io.stop_hard:
            return False
        return (yield from self.reset_and_restore(moving=not stood)) and stood

    def _may_wait(self, end_s: float) -> bool:
        """Tell whether a stand-still is waited for: not of a mute board, nor in an emergency."""
        in_time = self.io.now_s < end_s
        return in_time and not self.io.stop_hard and not self.exchange.mute

    def kill(self, lines: InFlightLines) -> Asking:
        """Stop dead; False where that ended a motion, as the board says or was seen to be in.

        Its words may be lost, or those of a board that somebody else has just reset.
        """
        moving = self.board.state in TURNING or not lines.empty
        return (yield from self.reset_and_restore(moving=moving)) and not moving

    def reset_and_restore(self, *, moving: bool) -> Asking:
        """Reset the board, and have its outputs and gripper as they were; tell what it kept."""
        alarmed = self.board.alarm is not None and not self.board.alarm.position_kept
        answered = yield from self.exchange.soft_reset(patient=False, moving=moving)
        kept = answered and not self.board.aborted and not alarmed
        if kept:
            yield from self.outputs.restore()
        return kept

    def cancel_jog(self, lines: InFlightLines) -> Asking:
        """End a jog and keep the position; False where steps may be lost.

        The line that is unanswered is waited for: a cancel does not reach lines in the ring. If the
        board still jogs after `AGAIN_S`, the byte of the cancel may be lost. A feed hold follows:
        it ends a jog as well, and one too many shows as Hold. Once the board is Idle, a line that
        it has to refuse proves that it reads lines, and that none is left in its ring to move it.
        """
        end_s = self.io.now_s + self.settings.answer_s
        while lines.unanswered and self.io.now_s < end_s and not self.io.stop_hard:
            heard = yield from self.exchange.listen(min(end_s, self.io.now_s + LATE_OK_S))
            if isinstance(heard, Acknowledged):
                lines.answered(self.io.now_s)
            elif heard is None and self.io.now_s >= lines.oldest_sent_s + LATE_OK_S:
                break
        end_s = self.io.now_s + self.brake_s + self.settings.answer_s
        hold_s = self.io.now_s + AGAIN_S
        self.exchange.press(Realtime.JOG_CANCEL)
        while self._may_wait(end_s):
            seen = yield from self._watch(STOP_POLL_S)
            if seen is None:
                continue
            if self.board.state is State.JOG and self.io.now_s >= hold_s:
                self.exchange.press(Realtime.FEED_HOLD)
                hold_s = math.inf
            elif self.board.standing:
                if (yield from self.exchange.spoil()) and (yield from self._still_idle()):
                    return True
                break
            elif self.board.state in (*DEAF, State.ALARM, State.RUN):
                break
        if self.io.stop_hard:
            return (yield from self.kill(lines))
        return (yield from self.hold())

    def _still_idle(self) -> Asking:
        """Look whether the board stands, behind all lines that it was sent."""
        self.exchange.forget_lines()
        seen = yield from self.exchange.look(LATE_REPORT_S)
        return seen and self.board.standing

    def free(self) -> Asking:
        """Reset a board that is Idle and reads no line, and tell whether it reads one now.

        A resume would free it as well, and have it carry out what waits in its ring. A reset of a
        board that stands keeps the position.
        """
        kept = yield from self.reset_and_restore(moving=False)
        return kept and (yield from self.exchange.spoil())
