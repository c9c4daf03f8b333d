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

from armdrive.dialects.controller import HOMING_MARGIN_S, HomingTime
from armdrive.dialects.exchange import Script, ScriptIO
from armdrive.dialects.grbl.board import HELD, BoardState
from armdrive.dialects.grbl.contact import GrblContact
from armdrive.dialects.grbl.exchange import (
    RESET_POLL_S,
    Answer,
    GrblExchange,
    refusal,
)
from armdrive.dialects.grbl.planner import (
    InFlightLines,
    MotionBounds,
    MotorPath,
    line_path,
)
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
    StatusReported,
)
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.spaces import Motors

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
# After this, the first lines of a motion have filled the segment buffer and the planner.
FILL_S = 0.1
# A motion too slow for the board runs ahead of its schedule by up to this, then waits.
MAX_LEAD_S = 0.1
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
    waits: bool = False  # during a pause
    steps: int = 0  # of the last line's busiest motor
    guess_s: float = 0.0  # the last line's duration, and so probably the next one's
    began_s: float = -math.inf  # when the motors started to turn
    # a motion too slow for the board is ahead of its schedule, and sends nothing until later
    lead_s: float = 0.0
    not_before_s: float = -math.inf
    # reports
    seen_s: float = -math.inf  # when the latest report was asked for
    changed_s: float = 0.0  # the latest progress
    off: int = 0  # successive reports off the path
    dry: bool = False  # the planner has run empty
    starved: bool = False  # it has, and this is an underrun if another segment is drawn

    def drive(self) -> Script[HostEvent, Reply]:
        """Send segments while there is room, until the motion is complete or something ends it.

        The board must be ready for lines, and its position known.
        """
        self.changed_s = self.io.now_s
        while True:
            if self.io.stop_asked or self.request.released():
                return (yield from self._halt())
            if self.request.held_back():
                self.waits = True
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
        """Send the next line if its predecessor is answered and the time ahead allows it."""
        if self.lines.unanswered or self.io.now_s < self.not_before_s or self.off:
            return
        if self.drawn is None and not self.exhausted:
            self._draw()
        if self.drawn is None:
            return
        lasts_s = self.drawn.duration_s
        # the board cannot turn more slowly than this; a slower line finishes ahead of schedule
        driven_s = min(lasts_s, self.drawn.steps.largest / self.bounds.segments.slowest_hz)
        ahead = line_path(self.drawn.steps, driven_s, self.bounds.limits)
        if not self.lines.fits(ahead, self.request.ahead_s, self.bounds.ramp_s()):
            return
        full = self.lines.waiting >= self.board.blocks
        if full or self.lines.ends_by(self.io.now_s + END_MARGIN_S):
            return
        self.exchange.send(Line(self._text(self.drawn.steps, ahead)))
        self.began_s = self.io.now_s if self.lines.empty else self.began_s
        self.lines.send(self.drawn.steps, ahead, self.io.now_s)
        self.guess_s, self.steps, self.drawn = driven_s, self.drawn.steps.largest, None
        self.changed_s = self.io.now_s
        self.lead_s += lasts_s - driven_s
        self.waits = False
        if self.lead_s >= MAX_LEAD_S:
            self.not_before_s, self.lead_s = self.lines.ends_s + self.lead_s, 0.0

    def _draw(self) -> None:
        """Draw the next segment if one like the last would fit: at a pause, the rest is undrawn."""
        if not self.lines.has_room(self.guess_s, self.request.ahead_s):
            return
        self.drawn = next(self.request.segments, None)
        self.exhausted = self.drawn is None
        self.board.underruns += self.starved and not self.exhausted
        self.starved = False

    def _text(self, steps: Motors, ahead: MotorPath) -> str:
        words = self.axes.words(self.lines.end, self.lines.end + steps)
        return f"{'$J=G91' if self.request.jog else 'G91G1'}{feed(ahead)}{words}"

    def _wake_s(self) -> float:
        wake_s = min(self.exchange.poll_due_s, self.exchange.mute_at_s)
        return min(wake_s, self.not_before_s) if self.io.now_s < self.not_before_s else wake_s

    # -- evaluating ---------------------------------------------------------------------------

    def _outcome(self, message: HostEvent | None) -> Reply | None:
        """Evaluate a message, or its absence; return the reply if the motion has ended."""
        match message:
            case Acknowledged():
                self.lines.answered(self.io.now_s)
                self.changed_s = self.io.now_s
            case Refused():
                moved = self.lines.oks > 0
                return refusal(message, f"`{message.command.text}` was refused", moved=moved)
            case AlarmRaised():
                return RequestRejected(self.board.alarm_words())
            case Restarted():
                return RequestRejected("the board was reset, or lost its power, while it moved")
            case StatusReported():
                return self._reported()
        if message is not None:  # the missing message may be next, still unread
            return None
        return self._silence_of_mute() if self.exchange.mute else self._overdue()

    def _reported(self) -> Reply | None:
        self.seen_s = self.board.polls.asked_s
        board, state = self.board, self.board.state
        if state is State.ALARM:
            return RequestRejected(board.alarm_words())
        if state is State.HOLD:
            return Interrupted()
        if state in HELD:
            return RequestRejected("the safety door is open")
        if state in (State.SLEEP, State.CHECK):
            return RequestRejected(board.busy_words())
        if not board.located or board.position is None:
            return None
        self.io.notify(Progress(board.registers()))
        left = self.lines.waiting, self.lines.start
        idle, planned = board.standing, board.planner_holds()
        on_it = self.lines.report(board.position, self.io.now_s, idle=idle, planned=planned)
        self._count_underrun(idle)
        if left != (self.lines.waiting, self.lines.start):
            self.changed_s = self.io.now_s
        self.off = 0 if on_it else self.off + 1
        if self.off == 1:
            # the report may be damaged, as it has no checksum: query again
            self.exchange.send_realtime(Realtime.STATUS)
        return self._end_off_path() if self.off > 1 else None

    def _count_underrun(self, idle: bool) -> None:
        """Count an underrun: the planner runs empty in mid-motion, and the motors brake to a stop.

        Between single steps, and while the driver waits between lines, they stand anyway.
        """
        now_s = self.io.now_s
        filled = now_s >= self.began_s + FILL_S
        empty = idle or (filled and self.board.planner_holds() == 0)
        intended = self.waits or now_s < self.not_before_s + FILL_S
        dry = empty and self.lines.oks > 1 and self.steps > SINGLE_STEPS and not intended
        if dry and not self.dry:
            if self.lines.unanswered:
                self.board.underruns += 1  # the next line is still on the wire
            else:
                self.starved = True  # an underrun only if another segment is drawn
        self.dry = dry

    def _end_off_path(self) -> Reply:
        here, goal = tuple(self.board.registers().positions), tuple(self.lines.end)
        text = (
            f"the arm is off the path that was sent, at {here} steps on the way to {goal}: a byte "
            "was lost, or the board's steps per unit are wrong"
        )
        self.io.notify(Alert(AlertKind.OFF_PATH, text))
        return RequestRejected(text)

    def _overdue(self) -> Reply | None:
        """Check for a missing ok or a motion without progress; return the reply if it has ended."""
        lines, now_s = self.lines, self.io.now_s
        standing, position = self.board.standing, self.board.position
        if lines.unanswered and now_s >= lines.sent_s + self.settings.answer_s:
            if standing and position is not None and position == lines.end:
                lines.unanswered = False  # the line was driven, so only its ok was lost
                self.exchange.forget_lines()
                lines.report(position, now_s, idle=True)
            elif standing or not lines.oks:
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
            return self._silence_of_mute() if self.exchange.mute else Halted(kept)
        if not self.io.stop_asked and self.lines.empty and self.drawn is None:
            return Done()
        stop = self.stops.cancel_jog(self.lines) if self.request.jog else self.stops.hold()
        kept = yield from stop
        return self._silence_of_mute() if self.exchange.mute else Halted(kept)

    def _break_off(self, end: Reply) -> Script[HostEvent, Reply]:
        """Stop a motion that has failed, and return the failure."""
        if isinstance(end, Timeout):
            # the board may still receive; a reset could make the arm sag
            self.stops.send_brake()
            return end
        if self.board.alarm is None and self.board.state not in (None, State.ALARM):
            yield from self.stops.hold()
        return end

    def _silence_of_mute(self) -> Timeout:
        """Return the reply to a motion during which the board has stopped reporting."""
        note = "while the arm was moving; a feed hold was sent"
        return Timeout("?", self.settings.report_timeout_s, note=note)


class HomingWatch:
    """Which motors have turned since a homing command was sent.

    A count must differ from that at the start in two reports in a row: a single one, which has no
    checksum, may be damaged.
    """

    def __init__(self, motor: int, start: Motors) -> None:
        self._motor = motor
        self._start = start
        self._latest: set[int] = set()
        self._turned: set[int] = set()

    @property
    def own(self) -> bool:
        """Whether the motor to be homed has turned."""
        return self._motor in self._turned

    @property
    def others(self) -> bool:
        """Whether any other motor has turned."""
        return bool(self._turned - {self._motor})

    def see(self, position: Motors) -> None:
        """Compare a reported position with the one at the start."""
        steps = enumerate(position - self._start)
        differing = {motor for motor, count in steps if count}
        self._turned |= differing & self._latest
        self._latest = differing


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
        another one that did has homed again.
        """
        motor = self.letters.index(command.axes)
        for _ in range(2):
            began_s = self.io.now_s
            if not (yield from self.exchange.confirm_position()):
                return self.io.silence(began_s)
            watch = HomingWatch(motor, self.board.registers().positions)
            failed = yield from self._search(command, watch)
            if watch.others:
                words = "the line was changed on the wire, because another motor has turned"
                return RequestRejected(f"`{command.text}`: {words}")
            if failed is not None or watch.own:
                return failed
        return None

    def _search(self, command: Home, watch: HomingWatch) -> Script[HostEvent, Reply | None]:
        """Send a homing command and wait for its end; return why it failed, or None."""
        yield from self.exchange.clean_line()
        alarm, began_s = self.board.alarm, self.io.now_s
        self.exchange.send(command)
        message = yield from self._answer(self.time_of(command), watch)
        if message is None:
            if (yield from self._end()) and not self.io.stop_hard:
                yield from self.contact.clear()  # the driver knows: nothing is referenced
            return Halted(kept=False)
        if not isinstance(message, Acknowledged):
            return refusal(message, f"`{command.text}`", moved=True)
        too_soon = self.io.now_s < began_s + SHORTEST_HOMING_S
        if too_soon and self.board.alarm is alarm:
            return RequestRejected(
                f"the board answered `{command.text}` at once, so it has not homed: the line "
                "was changed on the wire"
            )
        for _ in range(2):
            if not (yield from self.exchange.look_position()):
                return self.io.silence(began_s)
            watch.see(self.board.registers().positions)
        return None

    def commands(self, groups: tuple[tuple[int, ...], ...]) -> list[Home]:
        """Return the homing commands: one for each motor, in the arm's order without groups.

        `$H` alone answers ok even if its build leaves axes out, as five-axis grbl-Mega-5X does.
        """
        motors = groups or (range(len(self.letters)),)
        return [Home(self.letters[motor]) for group in motors for motor in group]

    def _answer(self, lasts: HomingTime, watch: HomingWatch) -> Script[HostEvent, Answer | None]:
        """Wait for the answer to a homing command; return None at a stop or at the timeout.

        The board homes on while this program is suspended, so everything that has arrived meanwhile
        is read before the deadline counts. A board that reports while it homes is lost soon if it
        falls silent, and it shows at once if another motor turns.
        """
        reports = self.board.behaviour.reports_homing
        end_s = self.io.now_s + lasts.waited_s
        while not (self.io.stop_asked or watch.others):
            until_s, wake_s = end_s, end_s
            if reports:
                self.exchange.poll()
                until_s = min(end_s, self.board.polls.since_s + HOMING_MARGIN_S)
                wake_s = min(until_s, self.exchange.poll_due_s)
            message = yield from self.exchange.listen(wake_s)
            if isinstance(message, Answer):
                return message
            if isinstance(message, StatusReported) and self.board.located:
                watch.see(self.board.registers().positions)
            if message is None and self.io.now_s >= until_s:
                break
        return None

    def _end(self) -> Script[HostEvent, bool]:
        """Reset a board that is homing, which obeys nothing else; return whether it answered.

        It sends no report that would show a lost byte, so the reset is sent twice.
        """
        self.board.greeting.await_late()
        self.exchange.send_realtime(Realtime.SOFT_RESET)
        yield from self.io.pause(self.io.now_s + RESET_POLL_S)
        # if the first reset arrived, this one has no effect
        return (yield from self.exchange.soft_reset(moving=True))
