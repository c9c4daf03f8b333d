"""Stop a GRBL board, and restore the outputs that a stop's reset switches off.

    hold         brake a motion, then reset the board, which drops the lines that it still has
    cancel_jog   end a jog without a reset, if the board takes the cancel
    kill         reset at once (emergency stop), which may cost the position

All but a jog's cancel end in `reset_and_restore`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armdrive.dialects.exchange import Script, ScriptIO
from armdrive.dialects.grbl.board import HELD, LINES_IGNORED, MOVING, BoardState
from armdrive.dialects.grbl.exchange import REPORT_TIMEOUT_S, GrblExchange, refusal
from armdrive.dialects.grbl.planner import RESEND_S, InFlightLines
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.errors import Refused
from armdrive.tasks import Done, Reply, RequestRejected
from firmware_protocol.grbl import Acknowledged, Line, Realtime, State, StatusReport
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.text import counted


class GrblOutputs:
    """Switches outputs and drives a servo or output gripper, and remembers their last state.

    `reset_lets_go` means that a reset can switch off the output that holds the gripper.
    """

    def __init__(self, exchange: GrblExchange, gripper: str) -> None:
        self._exchange = exchange
        self._settings = exchange.settings
        self._gripper = gripper
        self._bits = 0
        self._share: float | None = None
        self.reset_lets_go = gripper in ("servo", "output")

    def check(self, bits: int) -> None:
        """Raise `Refused` if the arm file names no output for one of the bits."""
        if bits >> len(self._settings.outputs):
            raise Refused(
                f"this board has {counted(len(self._settings.outputs), 'output')}, {bits} needs "
                "more: name them in grbl.outputs"
            )

    def set(self, bits: int) -> Script[HostEvent, Reply]:
        """Switch the outputs."""
        refused = yield from self._carry_out(self._switching(bits), "the outputs")
        if refused is None:
            self._bits = bits
        return refused or Done()

    def set_gripper(self, share: float) -> Script[HostEvent, Reply]:
        """Open the gripper to a share from 0, closed, to 1, open."""
        if self._gripper == "output":
            bit = 1 << self._settings.gripper_output
            closed = share < 0.5  # the driver asks only for 0 or 1
            on = closed == self._settings.gripper_closes
            return (yield from self.set(self._bits | bit if on else self._bits & ~bit))
        refused = yield from self._carry_out(self._turning(share), "the gripper's servo")
        if refused is None:
            self._share = share
        return refused or Done()

    def restore(self) -> Script[HostEvent, None]:
        """Restore what a reset switched off, so that a valve or a servo does not drop its load."""
        if self._share is not None:
            yield from self._carry_out(self._turning(self._share), "the gripper's servo")
        if self._bits:
            yield from self._carry_out(self._switching(self._bits), "the outputs")

    def _turning(self, share: float) -> list[str]:
        span = self._settings.servo_open - self._settings.servo_closed
        value = self._settings.servo_closed + span * share
        word = "S" if self._settings.servo == "M3" else "Q"
        return [f"{self._settings.servo}{word}{value:.3f}".rstrip("0").rstrip(".")]

    def _switching(self, bits: int) -> list[str]:
        """Return the lines that switch the outputs. M9 switches both flood and mist off."""
        words = self._settings.outputs
        on = {word for bit, word in enumerate(words) if bits >> bit & 1}
        lines = ["M9"] if {"flood", "mist"} & set(words) - on else []
        lines += [line for word, line in (("flood", "M8"), ("mist", "M7")) if word in on]
        # M64 and M65 switch at once; M62 and M63 would wait for the next motion
        ports = (word for word in words if word.startswith("P"))
        return [*lines, *(f"M{64 if word in on else 65}{word}" for word in ports)]

    def _carry_out(
        self, lines: Sequence[str], what: str
    ) -> Script[HostEvent, RequestRejected | None]:
        """Send lines one at a time; return the reason if one was refused, or None."""
        for line in lines:
            message = yield from self._exchange.ask(Line(line))
            if not isinstance(message, Acknowledged):
                return refusal(message, what)
        return None


# Stop a GRBL board, and make it ready to continue.
#
# A feed hold, a wait for `Hold:0` and then a reset keep the position; a reset in motion loses it.
# A jog is cancelled by 0x85, sent only once: a cancel that arrives just as the jog ends leaves the
# board Idle but reading no lines. With a cancel every 20 ms, that happened to 3 of 259 jogs of a
# grbl-Mega-5X and to 2 of 264 of an ATmega328p.

# Interval of queries while the board brakes.
STOP_POLL_S = 0.02
# After more Idle reports than this, the board evidently ignores a hold at rest. grblHAL does if a
# jog cancel has hung it (state_machine.c, state_await_motion_cancel).
IDLE_REPORTS = 10


@dataclass(slots=True, eq=False)
class GrblStops:
    """Stops the board. `brakes_s` bounds how long a motion takes to stop after a feed hold."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    outputs: GrblOutputs
    settings: GrblSettings
    brakes_s: Callable[[], float]
    _cancel_again_s: float = -math.inf

    def _watch(self) -> Script[HostEvent, bool]:
        """Query once; return whether a report was received within `STOP_POLL_S`."""
        self.exchange.send_realtime(Realtime.STATUS)
        end_s, seen = self.io.now_s + STOP_POLL_S, False
        while self.io.now_s < end_s and not self.io.stop_hard:
            message = yield from self.exchange.listen(end_s)
            seen |= isinstance(message, StatusReport)
        return seen

    def hold(self) -> Script[HostEvent, bool]:
        """Brake, wait until the board stands, and reset it; return False if steps may be lost.

        The reset empties receive buffer and planner; after a hold alone, the motion would continue
        at the next resume. If no report has shown the board at rest, it may have been reset some
        other way in the meantime, so the reset counts as one in motion. A mute board is left in its
        hold, because no report shows whether a reset would interrupt a motion.
        """
        end_s = self.io.now_s + self.brakes_s() + self.settings.answer_s
        idle, stood = 0, False
        while self._may_wait(end_s) and not stood:
            if self.board.state not in HELD:  # the first one may be lost; a second is harmless
                self.send_brake()
            if (yield from self._watch()):
                idle = idle + 1 if self.board.standing else 0
                held = self.board.state in HELD and not self.board.sub_state
                stood = held or self.board.state is State.ALARM or idle > IDLE_REPORTS
        if self.exchange.mute and not self.io.stop_hard:
            return False
        return (yield from self.reset_and_restore(moving=not stood)) and stood

    def send_brake(self) -> None:
        """Tell the board to brake: by a feed hold, or by a jog cancel if that does not end a jog.

        Every board ignores a jog cancel outside of a jog.
        """
        cancels = self.board.state is State.JOG and not self.board.behaviour.holds_jogs
        if cancels and self.io.now_s >= self._cancel_again_s:
            self.exchange.send_realtime(Realtime.JOG_CANCEL)
            self._cancel_again_s = self.io.now_s + RESEND_S
        else:
            self.exchange.send_realtime(Realtime.FEED_HOLD)

    def _may_wait(self, end_s: float) -> bool:
        """Return whether to keep waiting for the board to stop: not if mute or in an emergency."""
        return self.io.now_s < end_s and not self.io.stop_hard and not self.exchange.mute

    def kill(self, lines: InFlightLines) -> Script[HostEvent, bool]:
        """Stop at once; return False if that interrupted a motion.

        The board says so, but its message may be lost, or be due to a reset that was not ours. So
        its last reported state and the unfinished lines count as well.
        """
        moving = self.board.state in MOVING or not lines.empty
        return (yield from self.reset_and_restore(moving=moving)) and not moving

    def reset_and_restore(self, *, moving: bool) -> Script[HostEvent, bool]:
        """Reset the board and restore its outputs; return whether it kept its position."""
        alarmed = self.board.alarm is not None and not self.board.alarm.position_kept
        answered = yield from self.exchange.soft_reset(patient=False, moving=moving)
        kept = answered and not self.board.aborted and not alarmed
        if kept:
            yield from self.outputs.restore()
        return kept

    def cancel_jog(self) -> Script[HostEvent, bool]:
        """End a jog and keep the position; return False if steps may be lost.

        If the board still jogs after `RESEND_S`, the cancel may be lost, or a line came after it: a
        cancel ends only what the planner holds. Then brake once more. Once the board is Idle, a
        line that it must refuse proves that it reads lines and that its receive buffer holds no
        motion.
        """
        end_s = self.io.now_s + self.brakes_s() + self.settings.answer_s
        self._cancel_again_s = hold_s = self.io.now_s + RESEND_S
        self.exchange.send_realtime(Realtime.JOG_CANCEL)
        while self._may_wait(end_s):
            if not (yield from self._watch()):
                continue
            if self.board.state is State.JOG and self.io.now_s >= hold_s:
                self.send_brake()
                hold_s = math.inf  # once: if it is lost too, `hold` below repeats it
            elif self.board.standing:
                reads = yield from self.exchange.flush_line()
                seen = reads and (yield from self.exchange.look(REPORT_TIMEOUT_S))
                if seen and self.board.standing:
                    return True
                break
            elif self.board.state in (*LINES_IGNORED, State.ALARM, State.RUN):
                break
        return (yield from self.hold())
