"""A motion on a GRBL board: lines sent a little ahead, their oks counted, every report weighed.

Nothing is sent that the planner could not end within the announced time, and no line while
another is still on the wire. What a report shows off the lines that were sent ends the motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.abilities import Abilities
from armdrive.dialects.controller import StopPart
from armdrive.dialects.grbl.exchange import LATE_REPORT_S, Answering, refusal
from armdrive.dialects.grbl.in_flight import (
    LAST_STEP_S,
    SLOWEST_HZ,
    InFlightLines,
    Limits,
    LineTrip,
    MotorPath,
    way,
)
from armdrive.dialects.grbl.settings import BoardAxes, GrblSettings, feed
from armdrive.dialects.grbl.stops import HELD, GrblStopping
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
    Line,
    Realtime,
    Refused,
    Restarted,
    State,
    StatusReported,
)
from firmware_protocol.grbl.events import Event as HostEvent
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


class GrblMotion(GrblStopping):
    """Drives segments."""

    def __init__(
        self, abilities: Abilities, settings: GrblSettings, axes: BoardAxes, baud: int
    ) -> None:
        super().__init__(abilities, settings, axes, baud)
        self.limits: Limits = axes.expected(settings)

    @property
    def _fastest(self) -> list[tuple[float, float]]:
        """Each motor's fastest rate on this arm, and its acceleration: steps/s and steps/s^2."""
        limits = self.limits
        each = zip(limits.rates_hz(), self.axes.most_hz, strict=True)
        slopes = zip(limits.accelerations, limits.steps_per_unit, strict=True)
        return [(min(pair), slope * per) for pair, (slope, per) in zip(each, slopes, strict=True)]

    @property
    def ramp_s(self) -> float:
        """How long the slowest motor brakes from the fastest that this arm drives it."""
        return self.ramp_from_s(())

    def ramp_from_s(self, parts: Sequence[StopPart]) -> float:
        """Return how long a motion brakes at most; of no parts, one at any speed.

        No motor turns faster than the busiest does, or than this arm drives it.
        """
        rate_hz = max((part.rate_hz for part in parts), default=math.inf)
        return max(min(rate_hz, fastest_hz) / slope for fastest_hz, slope in self._fastest)

    @property
    def slowest_stop_s(self) -> float:
        """How long a board takes at most from a hold that it has heard to the last step.

        It drives what its segment buffer holds, brakes, and makes the step that it has begun.
        """
        return self.segment_buffer.longest_s + self.ramp_s + LAST_STEP_S

    def held_longest_s(self, parts: Sequence[StopPart], piece_s: float) -> float:
        """Return for how long the board drives what its segment buffer holds, at most.

        Where the motion speeds up or slows down, its segments are those of slower rates.
        """
        if not parts:
            return self.segment_buffer.longest_s
        held_s = self.segment_buffer.longest_of_s(parts, piece_s)
        slopes = [slope for _, slope in self._fastest]
        ramps_s = self.segment_buffer.slow_ramp_s(max(p.rate_hz for p in parts), min(slopes))
        return min(held_s + ramps_s, self.segment_buffer.longest_s)

    def held_full_speed_s(self, parts: Sequence[StopPart]) -> float:
        """Return how long the motion takes at its speed for the steps that the buffer can hold.

        Of no parts, a single motor at its full speed: the slowest takes longest.
        """
        rates_hz = [part.rate_hz for part in parts] or [each for each, _ in self._fastest]
        return max((self.segment_buffer.most_steps(rate) + 1.0) / rate for rate in rates_hz)

    def drive(self, request: MoveAlong) -> Answering:
        """Send segments while there is room, until all is driven or something ends it."""
        hindrance = yield from self.prepare()
        if hindrance is not None:
            return hindrance
        start = self.position or self.registers().positions
        road = InFlightLines(start, self.limits, self.settings.corridor_steps, self.segment_buffer)
        trip = LineTrip(request.segments, road, request.ahead_s, request.jog)
        trip.changed_s = self.now_s
        self.brake_s = self.slowest_stop_s + self.ramp_s
        while True:
            if self.stop_asked or request.let_go():
                return (yield from self._halt(trip))
            if request.held_back():
                trip.waits = True
                if trip.road.empty:
                    return Done(unsent=int(trip.drawn is not None))
            else:
                self._send(trip)
            if trip.finished:
                return Done()
            self._poll(trip)
            heard = yield from self.listen(self._wake_s(trip))
            if (end := self._weighed(trip, heard)) is not None:
                return (yield from self._break_off(end))

    # -- sending ------------------------------------------------------------------------------

    def _send(self, trip: LineTrip) -> None:
        """Send what there is room for: on the wire, in the ring, and in the time ahead."""
        if self.now_s < max(self.wire_free_s, trip.not_before_s) or trip.off:
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
        ahead = way(trip.drawn.steps, driven_s, self.limits)
        if not trip.road.fits(ahead, trip.ahead_s, self.ramp_s):
            return
        line = Line(self._text(trip, trip.drawn.steps, ahead))
        if not self._may_say(trip, line):
            return
        self.speak(line)
        trip.began_s = self.now_s if trip.road.empty else trip.began_s
        trip.road.send(trip.drawn.steps, ahead, self.now_s)
        trip.guess_s, trip.steps, trip.drawn = driven_s, trip.drawn.steps.largest, None
        trip.changed_s = self.now_s
        trip.lead_s += lasts_s - driven_s
        trip.waits = False
        if trip.lead_s >= LEAD_S:
            trip.not_before_s, trip.lead_s = trip.road.ends_s + trip.lead_s, 0.0

    def _has_room(self, trip: LineTrip) -> bool:
        """Tell whether one more segment like the last would fit: it is drawn no earlier."""
        return not trip.waits_for_ok and trip.road.has_room(trip.guess_s, trip.ahead_s)

    def _may_say(self, trip: LineTrip, line: Line) -> bool:
        if trip.waits_for_ok:
            return False
        if trip.road.ends_by(self.now_s + CLEAR_S):
            return False
        return trip.road.waiting < self.blocks and self._host.room_for(line)

    def _text(self, trip: LineTrip, steps: Motors, ahead: MotorPath) -> str:
        words = self.axes.words(trip.road.end, trip.road.end + steps)
        return f"{'$J=G91' if trip.jog else 'G91G1'}{feed(ahead)}{words}"

    def _poll(self, trip: LineTrip) -> None:
        every_s = LATE_REPORT_S if trip.awaiting else self.settings.poll_s
        if self.now_s >= trip.polled_s + every_s:
            self.press(Realtime.STATUS)
            trip.polled_s, trip.awaiting = self.now_s, True

    def _wake_s(self, trip: LineTrip) -> float:
        every_s = LATE_REPORT_S if trip.awaiting else self.settings.poll_s
        wake_s = min(trip.polled_s + every_s, self.mute_at_s)
        for later_s in (self.wire_free_s, trip.not_before_s):
            if self.now_s < later_s:
                wake_s = min(wake_s, later_s)
        return wake_s

    # -- weighing -----------------------------------------------------------------------------

    def _weighed(self, trip: LineTrip, heard: HostEvent | None) -> Reply | None:
        """Take in what was heard; return what the motion has come to, where it has come to one."""
        match heard:
            case Acknowledged():
                trip.road.answered(self.now_s)
                trip.changed_s = self.now_s
            case Refused():
                moved = trip.road.oks > 0 or trip.road.unanswered > 1
                return refusal(heard, f"`{heard.command.text}` was refused", moved=moved)
            case AlarmRaised():
                return RequestRejected(self.alarm_words())
            case Restarted():
                return RequestRejected("the board was reset, or lost its power, while it moved")
            case StatusReported():
                return self._reported(trip)
        if heard is not None:  # what is missed may stand behind it, unread
            return None
        return self.silence_of_mute() if self.mute else self._overdue(trip)

    def _reported(self, trip: LineTrip) -> Reply | None:
        trip.awaiting, trip.seen_s = False, trip.polled_s
        if self.state is State.ALARM:
            return RequestRejected(self.alarm_words())
        if self.state in HELD:
            return (
                Interrupted()
                if self.state is State.HOLD
                else RequestRejected("the safety door is open")
            )
        if self.state in (State.SLEEP, State.CHECK):
            return RequestRejected(f"the board's state is {self.state}; `reset()` leaves it")
        position = self.position
        if self.reported is None or self.reported.machine_position is None or position is None:
            return None
        self.tell(Progress(self.registers()))
        left = trip.road.waiting, trip.road.start
        idle = self.state is State.IDLE and self.planner_empty()
        planned = self.planner_holds()
        on_it = trip.road.report(position, self.now_s, idle=idle, planned=planned)
        self._note_dry(trip, idle)
        if left != (trip.road.waiting, trip.road.start):
            trip.changed_s = self.now_s
        trip.off = 0 if on_it else trip.off + 1
        if trip.off == 1:
            trip.polled_s = -math.inf  # a report has no check bytes either: look again, at once
        return self._astray(trip) if trip.off > 1 else None

    def _note_dry(self, trip: LineTrip, idle: bool) -> None:
        """Count a planner that runs empty in mid-motion: the motors slow down to a stand-still.

        Between single steps, and where the driver waits between lines, they stand anyway.
        """
        empty = idle or (self.now_s >= trip.began_s + FILLED_S and self.planner_holds() == 0)
        meant = trip.waits or self.now_s < trip.not_before_s + FILLED_S
        dry = empty and trip.road.oks > 1 and trip.steps > FEW_STEPS and not meant
        if dry and not trip.dry:
            if trip.road.unanswered:
                self.underruns += 1  # the next line is on the wire still
            else:
                trip.starved = True  # whether more was to come, the next draw will tell
        trip.dry = dry

    def _astray(self, trip: LineTrip) -> Reply:
        text = (
            f"the arm is off the path that was sent, at {tuple(self.registers().positions)} steps "
            f"on the way to {tuple(trip.road.end)}: a byte was lost or the steps a unit are wrong"
        )
        self.tell(Alert(AlertKind.ASTRAY, text))
        return RequestRejected(text)

    def _overdue(self, trip: LineTrip) -> Reply | None:
        """Look at what has not come: an ok, or the end of the motion."""
        road = trip.road
        standing = self.state is State.IDLE and self.planner_empty()
        if road.unanswered and self.now_s >= road.oldest_sent_s + self.settings.answer_s:
            if standing and self.position is not None and road.at_end(self.position):
                road.take_as_answered()  # the line was driven: only its ok was lost
                self._host.forget_outstanding()
                road.report(self.position, self.now_s, idle=True)
            elif standing or not road.oks:
                return RequestRejected(
                    "the board answered a line with nothing: it was lost on the wire"
                )
        patience_s = STALLED_S + OVERRIDDEN * road.expected_s()
        # by the last report: where this program is late, the board has not been asked meanwhile
        waited_s = trip.seen_s - max(trip.changed_s, trip.not_before_s)
        if (not road.empty or trip.drawn is not None) and waited_s >= patience_s:
            return RequestRejected("the motion does not go on: look at the arm and at the board")
        return None

    # -- ending -------------------------------------------------------------------------------

    def _halt(self, trip: LineTrip) -> Answering:
        """End a motion that somebody stopped, or a jog that was let go."""
        if self.stop_asked and self.stop_hard:
            kept = yield from self.kill(trip.road)
            return self.silence_of_mute() if self.mute else Halted(kept)
        if not self.stop_asked and trip.road.empty and trip.drawn is None:
            return Done()
        stop = self.cancel_jog(trip.road) if trip.jog else self.hold()
        kept = yield from stop
        return self.silence_of_mute() if self.mute else Halted(kept)

    def _break_off(self, end: Reply) -> Answering:
        """Bring a motion to an end that went wrong, and return what went wrong."""
        if isinstance(end, Timeout):
            self.press(Realtime.FEED_HOLD)  # it may hear us still; a reset could make the arm sag
            return end
        if self.alarm is None and self.state is not None and self.state is not State.ALARM:
            yield from self.hold()
        return end
