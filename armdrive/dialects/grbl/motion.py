"""Drive motions on a GRBL board, sending lines a little ahead, and let the board home itself.

`GrblMotion.drive` is a loop. Each turn sends at most one line (`_send`), queries if it is time, and
waits for one message, which `_outcome` evaluates. `InFlightLines` (planner) knows the lines sent so
far. A line is sent only if

- the previous one has its ok, so that a stop byte waits behind one line at most, and nothing is
  sent after a line that was refused or lost;
- the board can finish it within the announced time, which bounds the motion after a stop;
- the motion under way does not end just now (`END_MARGIN_S`).

A reported position off the lines that were sent ends the motion, and so do a refused line, a lost
ok, a mute board, and a motion without progress. `_halt` stops at request, `_break_off` after a
failure; `stops` has how.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.dialects.controller import HomingTime
from armdrive.dialects.exchange import Script, ScriptIO
from armdrive.dialects.grbl.board import LINES_IGNORED, BoardState
from armdrive.dialects.grbl.contact import GrblContact
from armdrive.dialects.grbl.exchange import Answer, GrblExchange, refusal
from armdrive.dialects.grbl.planner import InFlightLines, MotionBounds, line_path
from armdrive.dialects.grbl.settings import BoardAxes, GrblSettings, feed
from armdrive.dialects.grbl.stops import GrblStops
from armdrive.tasks import (
    Alert,
    AlertKind,
    Done,
    Halted,
    Interrupted,
    MoveAlong,
    MoveBy,
    Progress,
    Reply,
    RequestRejected,
    Timeout,
)
from firmware_protocol.grbl import (
    Acknowledged,
    AlarmRaised,
    Home,
    Line,
    Realtime,
    Refused,
    Restarted,
    State,
    StatusReport,
)
from firmware_protocol.grbl.host import Event as HostEvent

# A motion without progress is given up this long after it should have ended.
STALLED_S = 2.0
# A line of at most this many steps is single steps: the arm stands between them anyway.
SINGLE_STEPS = 2
# In this time before the present motion ends, no line is sent: wait until the board is Idle.
#
# If a line arrives just as the motors stop, GRBL either leaves it in the segment buffer and becomes
# Idle, or executes a jog in state Run, where no jog cancel ends it. Both were seen on a
# grbl-Mega-5X at 25 steps/s. The margin covers the line's time on the wire and the host's
# scheduling delays.
END_MARGIN_S = 0.02
# A motion too slow for the board runs ahead of its schedule by up to this, then waits.
MAX_LEAD_S = 0.1
# Tolerance for rounding in comparisons of the time ahead.
ROUNDING_S = 1e-6
# No board homes so fast: it backs off twice, with pauses ($26). An earlier ok is that of a line
# that was changed on the wire.
SHORTEST_HOMING_S = 0.05
# The lowest feed override makes a motion take ten times as long; the rest is margin.
OVERRIDE_FACTOR = 12.0


@dataclass(slots=True, eq=False)
class GrblMotion:
    """Drives one motion, segment by segment."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    stops: GrblStops
    settings: GrblSettings
    axes: BoardAxes
    bounds: MotionBounds
    request: MoveAlong
    lines: InFlightLines
    # sending
    drawn: MoveBy | None = None  # the next segment, not sent yet
    exhausted: bool = False  # there are no more segments
    rests: bool = True  # the motors may stand before the next line
    guess_s: float = 0.0  # the last line's duration, and so probably the next one's
    # a motion too slow for the board is ahead of its schedule, and sends nothing until later
    lead_s: float = 0.0
    not_before_s: float = -math.inf
    # reports
    seen_s: float = -math.inf  # when the latest report was asked for
    changed_s: float = 0.0  # the latest progress
    off: int = 0  # successive reports off the path
    dry_s: float = math.inf  # when the planner runs empty, unless the next line is in it by then

    def drive(self) -> Script[HostEvent, Reply]:
        """Send segments while there is room, until the motion is complete or something ends it.

        The board must be ready for lines, and its position known.
        """
        self.changed_s = self.io.now_s
        while True:
            if self.io.stop_asked or self.request.released():
                return (yield from self._halt())
            if self.request.held_back():
                if self.lines.empty:
                    return Done(unsent=int(self.drawn is not None))
            else:
                self._send()
            if self.exhausted and self.drawn is None and self.lines.empty:
                return Done()
            self.exchange.poll()
            message = yield from self.exchange.listen(self._wake_s())
            if (end := self._outcome(message)) is not None:
                return (yield from self._break_off(end))

    # -- sending ------------------------------------------------------------------------------

    def _send(self) -> None:
        """Send the next line if its predecessor is answered and the time ahead allows it.

        A segment is drawn only when one like the last would fit: at a pause, the rest is undrawn.
        """
        lines, now_s = self.lines, self.io.now_s
        if lines.unanswered or now_s < self.not_before_s or self.off:
            return
        ramp_s, most_s = self.bounds.ramp_s(), self.request.ahead_s + ROUNDING_S
        if self.drawn is None and (lines.empty or lines.ahead_s(ramp_s) + self.guess_s <= most_s):
            self.drawn = next(self.request.segments, None)
            self.exhausted = self.drawn is None
        if self.drawn is None:
            return
        steps, lasts_s = self.drawn.steps, self.drawn.duration_s
        # the board cannot turn more slowly than this; a slower line finishes ahead of schedule
        driven_s = min(lasts_s, steps.largest / self.bounds.segments.slowest_hz)
        path = line_path(steps, driven_s, self.bounds.limits)
        if not lines.empty and (
            lines.ahead_s(ramp_s, path) > most_s or lines.ends_s <= now_s + END_MARGIN_S
        ):
            return
        words = self.axes.words(lines.end, lines.end + steps)
        self.exchange.send(Line(f"{'$J=G91' if self.request.jog else 'G91G1'}{feed(path)}{words}"))
        self.dry_s = math.inf if self.rests else lines.ends_s
        lines.send(steps, path, now_s)
        self.guess_s, self.drawn, self.changed_s = driven_s, None, now_s
        self.rests = steps.largest <= SINGLE_STEPS
        self.lead_s += lasts_s - driven_s
        if self.lead_s >= MAX_LEAD_S:
            self.not_before_s, self.lead_s = lines.ends_s + self.lead_s, 0.0
            self.rests = True

    def _wake_s(self) -> float:
        wake_s = min(self.exchange.poll_due_s, self.exchange.mute_at_s)
        return min(wake_s, self.not_before_s) if self.io.now_s < self.not_before_s else wake_s

    # -- evaluating ---------------------------------------------------------------------------

    def _outcome(self, message: HostEvent | None) -> Reply | None:
        """Evaluate a message, or its absence; return the reply if the motion has ended."""
        match message:
            case Acknowledged():
                self.lines.answered(self.io.now_s)
                self.board.underruns += self.io.now_s > self.dry_s
                self.changed_s = self.io.now_s
            case Refused():
                moved = self.lines.oks > 0
                return refusal(message, f"`{message.command.text}` was refused", moved=moved)
            case AlarmRaised():
                return RequestRejected(self.board.alarm_words())
            case Restarted():
                return RequestRejected("the board was reset, or lost its power, while it moved")
            case StatusReport():
                return self._reported()
        if message is not None:  # the missing message may be next, still unread
            return None
        return self._silence_of_mute() if self.exchange.mute else self._overdue()

    def _reported(self) -> Reply | None:
        self.seen_s = self.exchange.asked_s
        board, lines, state = self.board, self.lines, self.board.state
        if state is State.ALARM:
            return RequestRejected(board.alarm_words())
        if state is State.HOLD:
            return Interrupted()
        if state in LINES_IGNORED:
            return RequestRejected(board.busy_words())
        self.io.notify(Progress(board.registers()))
        before = lines.progress
        on_it = lines.report(board.registers().positions, self.io.now_s, idle=board.standing)
        if before != lines.progress:
            self.changed_s = self.io.now_s
        self.off = 0 if on_it else self.off + 1
        if self.off == 1:
            # the report may be damaged, as it has no checksum: query again
            self.exchange.send_realtime(Realtime.STATUS)
        return self._end_off_path() if self.off > 1 else None

    def _end_off_path(self) -> Reply:
        here, goal = tuple(self.board.registers().positions), tuple(self.lines.end)
        text = (
            f"the arm is off the path that was sent, at {here} steps on the way to {goal}: a byte "
            "was lost, or the board's steps per unit are wrong"
        )
        self.io.notify(Alert(AlertKind.OFF_PATH, text))
        return RequestRejected(text)

    def _overdue(self) -> Reply | None:
        """Check for a missing ok or a motion without progress; return the reply if it has ended.

        A board with a full planner owes the ok until there is room.
        """
        lines, now_s = self.lines, self.io.now_s
        answer_s = self.settings.answer_s + (lines.expected_s() if lines.oks else 0.0)
        if lines.unanswered and now_s >= lines.sent_s + answer_s:
            return RequestRejected("the board did not answer a line: it was lost on the wire")
        patience_s = STALLED_S + OVERRIDE_FACTOR * lines.expected_s()
        # measured up to the latest query: a suspended program has not queried the board meanwhile
        waited_s = self.seen_s - max(self.changed_s, self.not_before_s)
        if (not lines.empty or self.drawn is not None) and waited_s >= patience_s:
            return RequestRejected("the motion makes no progress: check the arm and the board")
        return None

    # -- ending -------------------------------------------------------------------------------

    def _halt(self) -> Script[HostEvent, Reply]:
        """End a motion after a stop request, or a jog whose key was released."""
        if self.io.stop_asked and self.io.stop_hard:
            kept = yield from self.stops.kill(self.lines)
        elif self.request.jog:
            kept = yield from self.stops.cancel_jog()
        else:
            kept = yield from self.stops.hold()
        return self._silence_of_mute() if self.exchange.mute else Halted(kept)

    def _break_off(self, end: Reply) -> Script[HostEvent, Reply]:
        """Stop a motion that has failed, and return the failure."""
        if isinstance(end, Timeout):
            # the board may still receive; a reset could make the arm sag
            self.stops.send_brake()
        elif self.board.state not in (None, State.ALARM):
            yield from self.stops.hold()
        return end

    def _silence_of_mute(self) -> Timeout:
        """Return the reply to a motion during which the board has stopped reporting."""
        note = "while the arm was moving; a feed hold was sent"
        return Timeout("?", self.settings.report_timeout_s, note=note)


@dataclass(slots=True, eq=False)
class GrblHoming:
    """Homes the arm with the board's own homing cycle and its switches."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    contact: GrblContact
    letters: str
    time_of: Callable[[Home], HomingTime]
    """How long a homing command lasts."""

    def commands(self, groups: tuple[tuple[int, ...], ...]) -> list[Home]:
        """Return the homing commands: one for each motor, in the arm's order without groups.

        `$H` alone answers ok even if its build leaves axes out, as five-axis grbl-Mega-5X does.
        """
        motors = groups or (range(len(self.letters)),)
        return [Home(self.letters[motor]) for group in motors for motor in group]

    def home(self, groups: tuple[tuple[int, ...], ...]) -> Script[HostEvent, Reply]:
        """Make the board home one motor after the other, in the order of `commands`."""
        began_s = self.io.now_s
        if not (yield from self.exchange.confirm_position()):
            return self.io.silence(began_s)
        if self.board.state not in (State.IDLE, State.ALARM):
            return RequestRejected(self.board.busy_words(), moved=False)
        before = self.board.alarm  # any other one is reported, and stays
        for command in self.commands(groups):
            if (failed := (yield from self._home_motor(command))) is not None:
                return failed
        if self.board.state is State.ALARM and self.board.alarm is before:
            # FluidNC stays locked while an axis that could home has not: the arm file leaves it out
            return (yield from self.contact.clear())
        return Done()

    def _home_motor(self, command: Home) -> Script[HostEvent, Reply | None]:
        """Home one motor; return why that failed, or None.

        A line has no checksum, so its letter may become that of another axis, and the board answers
        ok as well. Hence no other motor's count may change. If the motor's own does not change
        either, the line is sent once more: the motor may have stood at its switch already, or
        another one that did has homed again. FluidNC counts zero before and after the first homing.
        """
        motor = self.letters.index(command.axes)
        for _ in range(2):
            began_s = self.io.now_s
            if not (yield from self.exchange.confirm_position()):
                return self.io.silence(began_s)
            before = self.board.registers().positions
            failed = yield from self._search(command)
            if failed is not None:
                return failed
            if not (yield from self.exchange.confirm_position()):
                return self.io.silence(began_s)
            ways = self.board.registers().positions - before
            if any(steps for other, steps in enumerate(ways) if other != motor):
                words = "the line was changed on the wire, because another motor has turned"
                return RequestRejected(f"`{command.text}`: {words}")
            if ways[motor]:
                break
        return None

    def _search(self, command: Home) -> Script[HostEvent, Reply | None]:
        """Send a homing command and wait for its end; return why it failed, or None.

        The board homes on while this program is suspended, so everything that has arrived meanwhile
        is read before the deadline counts. Most boards report nothing while they home.
        """
        yield from self.exchange.clear_line()
        alarm, began_s = self.board.alarm, self.io.now_s
        self.exchange.send(command)
        end_s = began_s + self.time_of(command).waited_s
        message: HostEvent | None = None
        while not isinstance(message, Answer):
            if self.io.stop_asked or (message is None and self.io.now_s >= end_s):
                return (yield from self._end())
            message = yield from self.exchange.listen(end_s)
        if not isinstance(message, Acknowledged):
            return refusal(message, f"`{command.text}`", moved=True)
        if self.io.now_s < began_s + SHORTEST_HOMING_S and self.board.alarm is alarm:
            return RequestRejected(
                f"the board answered `{command.text}` at once, so it has not homed: the line "
                "was changed on the wire"
            )
        return None

    def _end(self) -> Script[HostEvent, Reply]:
        """Reset a board that is homing, which obeys nothing else."""
        answered = yield from self.exchange.soft_reset(moving=True)
        if answered and not self.io.stop_hard:
            yield from self.contact.clear()  # the driver knows: nothing is referenced
        return Halted(kept=False)
