"""Motion on a GRBL board: lines sent a little ahead, their oks counted, and the board's own homing.

Nothing is sent that the planner could not end within the announced time, and no line while
another is still on the wire. What a report shows off the lines that were sent ends the motion.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.grbl.board import HELD, BoardState
from armdrive.dialects.grbl.contact import GrblContact
from armdrive.dialects.grbl.exchange import (
    LATE_REPORT_S,
    RESET_POLL_S,
    Answer,
    Answering,
    GrblExchange,
    refusal,
)
from armdrive.dialects.grbl.planner import (
    SLOWEST_HZ,
    InFlightLines,
    LineTrip,
    MotionBounds,
    MotorPath,
    way,
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
    Variant,
)
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.spaces import Motors

STALLED_S = 2.0
"""A motion that does not go on for so long, beyond what it should take, is given up."""
FEW_STEPS = 2
"""A line of no more of them is single steps: the arm stands between those anyway."""
CLEAR_S = 0.02
"""No line is sent so shortly before the motion under way ends: the board has to be Idle then.

A line that GRBL plans as its motors stop is either left in the segment buffer, with the board Idle,
or carried out in Run although it was a jog, so that no jog cancel ends it. Both were seen on a
grbl-Mega-5X at 25 steps/s. The time covers the line's way and what the host may be late by.
"""
FILLED_S = 0.1
"""By then, the lines that a motion begins with have filled segment buffer and planner."""
LEAD_S = 0.1
"""A motion that is too slow for the board gets so far ahead of its time before it waits."""
OVERRIDDEN = 12.0
"""The lowest feed override makes a motion ten times longer."""


@dataclass(slots=True, eq=False)
class GrblMotion:
    """Drives the segments of one motion after another."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    stops: GrblStops
    settings: GrblSettings
    axes: BoardAxes
    underruns: int = 0
    """How often the board stood still although more of its motion was to come."""

    def drive(self, request: MoveAlong, bounds: MotionBounds) -> Answering:
        """Send segments while there is room, until all is driven or something ends it.

        The board stands ready for lines, and its position is known.
        """
        start = self.board.position or self.board.registers().positions
        lines = InFlightLines(start, bounds.limits, self.settings.corridor_steps, bounds.segments)
        trip = LineTrip(request.segments, lines, bounds, request.ahead_s, request.jog)
        trip.changed_s = self.io.now_s
        self.stops.brake_s = bounds.slowest_stop_s + bounds.ramp_s()
        while True:
            if self.io.stop_asked or request.let_go():
                return (yield from self._halt(trip))
            if request.held_back():
                trip.waits = True
                if trip.lines.empty:
                    return Done(unsent=int(trip.drawn is not None))
            else:
                self._send(trip)
            if trip.finished:
                return Done()
            self._poll(trip)
            heard = yield from self.exchange.listen(self._wake_s(trip))
            if (end := self._weighed(trip, heard)) is not None:
                return (yield from self._break_off(end))

    # -- sending ------------------------------------------------------------------------------

    def _send(self, trip: LineTrip) -> None:
        """Send what there is room for: on the wire, in the ring, and in the time ahead."""
        if self.io.now_s < max(self.exchange.wire_free_s, trip.not_before_s) or trip.off:
            return
        if trip.drawn is None and not trip.exhausted and self._has_room(trip):
            trip.drawn = next(trip.segments, None)
            trip.exhausted = trip.drawn is None
            self.underruns += trip.starved and not trip.exhausted
            trip.starved = False
        if trip.drawn is None:
            return
        lasts_s = trip.drawn.duration_s
        # what is slower than the board's slowest rate is driven at that rate, ahead of its time
        driven_s = min(lasts_s, trip.drawn.steps.largest / SLOWEST_HZ)
        ahead = way(trip.drawn.steps, driven_s, trip.bounds.limits)
        if not trip.lines.fits(ahead, trip.ahead_s, trip.bounds.ramp_s()):
            return
        line = Line(self._text(trip, trip.drawn.steps, ahead))
        if not self._may_say(trip, line):
            return
        self.exchange.speak(line)
        trip.began_s = self.io.now_s if trip.lines.empty else trip.began_s
        trip.lines.send(trip.drawn.steps, ahead, self.io.now_s)
        trip.guess_s, trip.steps, trip.drawn = driven_s, trip.drawn.steps.largest, None
        trip.changed_s = self.io.now_s
        trip.lead_s += lasts_s - driven_s
        trip.waits = False
        if trip.lead_s >= LEAD_S:
            trip.not_before_s, trip.lead_s = trip.lines.ends_s + trip.lead_s, 0.0

    def _has_room(self, trip: LineTrip) -> bool:
        """Tell whether one more segment like the last would fit: it is drawn no earlier."""
        return not trip.waits_for_ok and trip.lines.has_room(trip.guess_s, trip.ahead_s)

    def _may_say(self, trip: LineTrip, line: Line) -> bool:
        if trip.waits_for_ok or trip.lines.ends_by(self.io.now_s + CLEAR_S):
            return False
        return trip.lines.waiting < self.board.blocks and self.exchange.room_for(line)

    def _text(self, trip: LineTrip, steps: Motors, ahead: MotorPath) -> str:
        words = self.axes.words(trip.lines.end, trip.lines.end + steps)
        return f"{'$J=G91' if trip.jog else 'G91G1'}{feed(ahead)}{words}"

    def _poll(self, trip: LineTrip) -> None:
        every_s = LATE_REPORT_S if trip.awaiting else self.settings.poll_s
        if self.io.now_s >= trip.polled_s + every_s:
            self.exchange.press(Realtime.STATUS)
            trip.polled_s, trip.awaiting = self.io.now_s, True

    def _wake_s(self, trip: LineTrip) -> float:
        every_s = LATE_REPORT_S if trip.awaiting else self.settings.poll_s
        wake_s = min(trip.polled_s + every_s, self.exchange.mute_at_s)
        for later_s in (self.exchange.wire_free_s, trip.not_before_s):
            if self.io.now_s < later_s:
                wake_s = min(wake_s, later_s)
        return wake_s

    # -- weighing -----------------------------------------------------------------------------

    def _weighed(self, trip: LineTrip, heard: HostEvent | None) -> Reply | None:
        """Take in what was heard; return what the motion has come to, where it has come to one."""
        match heard:
            case Acknowledged():
                trip.lines.answered(self.io.now_s)
                trip.changed_s = self.io.now_s
            case Refused():
                moved = trip.lines.oks > 0 or trip.lines.unanswered > 1
                return refusal(heard, f"`{heard.command.text}` was refused", moved=moved)
            case AlarmRaised():
                return RequestRejected(self.board.alarm_words())
            case Restarted():
                return RequestRejected("the board was reset, or lost its power, while it moved")
            case StatusReported():
                return self._reported(trip)
        if heard is not None:  # what is missed may stand behind it, unread
            return None
        return self._silence_of_mute() if self.exchange.mute else self._overdue(trip)

    def _reported(self, trip: LineTrip) -> Reply | None:
        trip.awaiting, trip.seen_s = False, trip.polled_s
        board, state = self.board, self.board.state
        if state is State.ALARM:
            return RequestRejected(board.alarm_words())
        if state is State.HOLD:
            return Interrupted()
        if state in HELD:
            return RequestRejected("the safety door is open")
        if state in (State.SLEEP, State.CHECK):
            return RequestRejected(f"the board's state is {state}; `reset()` leaves it")
        if not board.located or board.position is None:
            return None
        self.io.tell(Progress(board.registers()))
        left = trip.lines.waiting, trip.lines.start
        idle, planned = board.standing, board.planner_holds()
        on_it = trip.lines.report(board.position, self.io.now_s, idle=idle, planned=planned)
        self._note_dry(trip, idle)
        if left != (trip.lines.waiting, trip.lines.start):
            trip.changed_s = self.io.now_s
        trip.off = 0 if on_it else trip.off + 1
        if trip.off == 1:
            trip.polled_s = -math.inf  # a report has no check bytes either: look again, at once
        return self._astray(trip) if trip.off > 1 else None

    def _note_dry(self, trip: LineTrip, idle: bool) -> None:
        """Count a planner that runs empty in mid-motion: the motors slow down to a stand-still.

        Between single steps, and where the driver waits between lines, they stand anyway.
        """
        now_s = self.io.now_s
        filled = now_s >= trip.began_s + FILLED_S
        empty = idle or (filled and self.board.planner_holds() == 0)
        meant = trip.waits or now_s < trip.not_before_s + FILLED_S
        dry = empty and trip.lines.oks > 1 and trip.steps > FEW_STEPS and not meant
        if dry and not trip.dry:
            if trip.lines.unanswered:
                self.underruns += 1  # the next line is on the wire still
            else:
                trip.starved = True  # whether more was to come, the next draw will tell
        trip.dry = dry

    def _astray(self, trip: LineTrip) -> Reply:
        here, goal = tuple(self.board.registers().positions), tuple(trip.lines.end)
        text = (
            f"the arm is off the path that was sent, at {here} steps on the way to {goal}: a byte "
            "was lost or the steps a unit are wrong"
        )
        self.io.tell(Alert(AlertKind.ASTRAY, text))
        return RequestRejected(text)

    def _overdue(self, trip: LineTrip) -> Reply | None:
        """Look at what has not come: an ok, or the end of the motion."""
        lines, now_s = trip.lines, self.io.now_s
        standing, position = self.board.standing, self.board.position
        if lines.unanswered and now_s >= lines.oldest_sent_s + self.settings.answer_s:
            if standing and position is not None and lines.at_end(position):
                lines.take_as_answered()  # the line was driven: only its ok was lost
                self.exchange.forget_lines()
                lines.report(position, now_s, idle=True)
            elif standing or not lines.oks:
                return RequestRejected(
                    "the board answered a line with nothing: it was lost on the wire"
                )
        patience_s = STALLED_S + OVERRIDDEN * lines.expected_s()
        # by the last report: where this program is late, the board has not been asked meanwhile
        waited_s = trip.seen_s - max(trip.changed_s, trip.not_before_s)
        if (not lines.empty or trip.drawn is not None) and waited_s >= patience_s:
            return RequestRejected("the motion does not go on: look at the arm and at the board")
        return None

    # -- ending -------------------------------------------------------------------------------

    def _halt(self, trip: LineTrip) -> Answering:
        """End a motion that somebody stopped, or a jog that was let go."""
        if self.io.stop_asked and self.io.stop_hard:
            kept = yield from self.stops.kill(trip.lines)
            return self._silence_of_mute() if self.exchange.mute else Halted(kept)
        if not self.io.stop_asked and trip.lines.empty and trip.drawn is None:
            return Done()
        stop = self.stops.cancel_jog(trip.lines) if trip.jog else self.stops.hold()
        kept = yield from stop
        return self._silence_of_mute() if self.exchange.mute else Halted(kept)

    def _break_off(self, end: Reply) -> Answering:
        """Bring a motion to an end that went wrong, and return what went wrong."""
        if isinstance(end, Timeout):
            # the board may hear us still; a reset could make the arm sag
            self.exchange.press(Realtime.FEED_HOLD)
            return end
        if self.board.alarm is None and self.board.state not in (None, State.ALARM):
            yield from self.stops.hold()
        return end

    def _silence_of_mute(self) -> Timeout:
        """Return the reply to a motion whose board gives no report any more."""
        return Timeout("? (mute in motion; a feed hold was sent)", self.settings.mute_s)


@dataclass(slots=True, eq=False)
class GrblHoming:
    """Has the board find its switches, which it does by itself."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    contact: GrblContact
    settings: GrblSettings
    letters: str

    def home(self, groups: tuple[tuple[int, ...], ...]) -> Answering:
        """Have the board home, all motors at once or group after group."""
        yield from self.exchange.look(self.settings.answer_s)
        if self.board.state in HELD:
            return RequestRejected(
                f"the board's state is {self.board.state}; `reset()` leaves it", moved=False
            )
        yield from self.exchange.clean_line()
        for command in self._commands(groups):
            self.exchange.speak(command)
            heard = yield from self._answer()
            if heard is None:
                yield from self._end()
                if not self.io.stop_hard:
                    yield from self.contact.clear()  # the driver knows: nothing is referenced
                return Halted(kept=False)
            if not isinstance(heard, Acknowledged):
                return refusal(heard, f"`{command.text}`", moved=True)
        return Done()

    def _commands(self, groups: tuple[tuple[int, ...], ...]) -> list[Home]:
        """Return the commands; only some firmwares home several axes that are named together."""
        if not groups:
            return [Home()]
        named = ["".join(self.letters[motor] for motor in group) for group in groups]
        if self.board.variant is not Variant.GRBLHAL:
            named = list("".join(named))
        return [Home(letters) for letters in named]

    def _answer(self) -> Generator[float, HostEvent | None, Answer | None]:
        """Wait for the answer to a homing command; None for a stop, and where none comes."""
        end_s = self.io.now_s + self.settings.homing_s
        while self.io.now_s < end_s and not self.io.stop_asked:
            heard = yield from self.exchange.listen(end_s)
            if isinstance(heard, Answer):
                return heard
        return None

    def _end(self) -> Generator[float, HostEvent | None, None]:
        """Reset a board that homes, which obeys nothing else. No report tells of a lost byte."""
        self.board.greeting.await_late()
        self.exchange.press(Realtime.SOFT_RESET)
        yield from self.io.pause(self.io.now_s + RESET_POLL_S)
        yield from self.exchange.soft_reset(moving=True)  # within the same reset, it has no effect
