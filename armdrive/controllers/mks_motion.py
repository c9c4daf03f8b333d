"""Motion of MKS drives by steering: each is given a new target again and again, in flight.

At a fixed period every motor that moves is told the speed that brings it, by the end of the period,
to where the motion should be then, and a target that it would not reach before the next order but
no later than announced if none came: as far ahead as it goes one way. So drives do not brake
between segments, and stop by themselves when their host dies. Speeds are whole rpm; what rounding
leaves over is in the next period's way, so nothing adds up.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.controllers.mks_arriving import Ending
from armdrive.controllers.mks_beside import MksBeside
from armdrive.controllers.mks_drive import Drive
from armdrive.controllers.mks_ramps import COUNTS_S_PER_RPM, whole_rpm
from armdrive.controllers.mks_stops import ALL_MUTE_LOOKS, MUTE_LOOKS
from armdrive.controllers.mks_track import Lead, Track, Trip, shares_of
from armdrive.controllers.requests import Alert, AlertKind, Denied, MoveAlong, Progress, Reply
from firmware_protocol.mks import (
    SPEED_MAX_RPM,
    Answered,
    ArmSynchronous,
    EncoderRead,
    Event,
    Failed,
    LimitStop,
    MoveAbsoluteAxis,
    ReadEncoder,
    StoredForStart,
)
from kinematics.spaces import Motors

SLOW_RPM = LAST_RPM = 3
"""Slower than this, a drive is sent to the end of the period alone: it stands there."""
CREEP_RPM, FAR = 32, 2.0
"""Slower than this, or so many corridors behind, one is told to be there when it is announced."""
CATCH_UP, CATCH_UP_RPM = 1.25, 30
"""How much faster than planned a drive may be told to go that is behind."""
GAIN = 0.3
"""How far the model of a moving drive follows its encoder at each look."""
FRESH_S = 0.3
SHOWS_PERIODS = 1.5
"""A drive whose orders stay the same is given them anew after so long: who takes none says so."""


class MksMotion(MksBeside):
    """Drives segments by steering."""

    def drive_along(self, request: MoveAlong) -> Ending:
        """Steer the drives along segments, until all is driven or something ends it."""
        hindrance = yield from self.prepare()
        if hindrance is not None:
            return hindrance
        track = Track(Motors(drive.target for drive in self.drives))
        back = request.held_back
        trip = Trip(request.segments, request.ahead_s, request.let_go, track, back)
        self.ahead_s = max(request.ahead_s, self.settings.segment_s)
        for drive in self.drives:
            drive.heard_s = drive.answered_s = self.now_s
            drive.unanswered = 0
            drive.denials.forget()
        while not trip.sent_all:
            if self.stop_asked or request.let_go():
                return (yield from self.halted())
            if not self.held_up and trip.is_due(self.now_s, self.settings.segment_s):
                trip.go_on(self.now_s)
                trip.held = trip.held_back()
                self.underruns += trip.draw()
                if (refused := self._steer(trip)) is not None:
                    yield from self.halted()
                    return refused
            self._poll(trip)
            self.urge()
            wake_s = self._poll_s(trip)
            heard = yield wake_s if self.held_up else min(trip.due_s, wake_s, self.soon_s)
            end = (yield from self._weighed(trip, heard)) if heard is not None else None
            if end is None and not self.stop_asked:  # who was suspended has heard nobody, and stops
                end = (yield from self._denied()) or (yield from self._unheard())
            if end is not None:
                return end
        return (yield from self.arrive(self.settings.segment_s, request.let_go))

    def prepare(self) -> Generator[float, Event | None, Denied | None]:
        """See to it that a motion can begin; return why it cannot, where it cannot."""
        if not self.on:
            return Denied("its motors are disabled: call `enable()`", moved=False)
        if any(drive.seen_s < self.now_s - FRESH_S for drive in self.drives):
            missing = yield from self.look()
            if missing:
                return Denied(self.absent_words(missing), moved=False)
        for drive in self.drives:
            drive.advance(self.now_s)
            if drive.moving or abs((drive.seen or 0) - drive.target) > self.reach:
                drive.rest_at(drive.seen or 0, self.now_s)
            drive.leap.begin(drive.seen, drive.seen_s)
            drive.gap.forget()  # whatever it missed while it stood, its count was read since
        return None

    @staticmethod
    def catching_up_hz(rate_hz: float) -> float:
        """Return the fastest rate that a drive is told where it is to turn this fast, but lags."""
        planned = rate_hz / COUNTS_S_PER_RPM
        return _catch_up_rpm(planned) * COUNTS_S_PER_RPM

    # -- steering -----------------------------------------------------------------------------

    def _steer(self, trip: Trip) -> Denied | None:
        """Give every drive that moves its next order."""
        ahead_s = min(trip.time_s + trip.ahead_s, trip.track.end_s)
        trip.sent_s = ahead_s
        ending = trip.exhausted or trip.held
        last = ending and trip.time_s + self.settings.segment_s >= trip.track.end_s - 1e-9
        track, motors = trip.track, range(len(self.drives))
        leads = [track.lead(motor, trip.time_s, ahead_s) for motor in motors]
        shares = shares_of([track.mean(motor, trip.time_s, leads[motor]) for motor in motors])
        for motor, (drive, lead) in enumerate(zip(self.drives, leads, strict=True)):
            drive.advance(self.now_s)
            order = self._last_order(trip, motor) if last else self._order(trip, motor, lead)
            if order is None:
                continue
            target, rpm = order
            if last or rpm < CREEP_RPM or abs(drive.behind) > FAR * self.settings.corridor_counts:
                rpm = max(rpm, self.least_rpm(drive, target))
            if (refused := self.beyond(target, drive.node)) is not None:
                return refused
            if target != drive.target or (drive.moving and self._has_news(drive, rpm)):
                acc = drive.ramp_to(target, self.settings.acceleration, shares[motor])
                self.send(drive.node, target, rpm, acc)
                self.last_said = f"F5 to {self.targets}"
        if last:
            trip.time_s = trip.sent_s = trip.track.end_s
        return None

    def _has_news(self, drive: Drive, rpm: int) -> bool:
        """Tell whether a drive is told its speed: a new one, or to show that it obeys still."""
        shows_s = drive.ordered_s + SHOWS_PERIODS * self.settings.segment_s
        return rpm * COUNTS_S_PER_RPM != drive.told or self.now_s >= shows_s

    def _order(self, trip: Trip, motor: int, lead: Lead) -> tuple[int, int] | None:
        """Return a drive's next target and speed; None where it goes on as it is."""
        drive, period_s = self.drives[motor], self.settings.segment_s
        if not lead.way:
            return self._to_rest(drive, lead) if drive.moving else None
        until_s = min(trip.time_s + period_s, lead.until_s)
        there = trip.track.at(motor, until_s)
        needed = lead.way * (there - drive.position) / max(until_s - trip.time_s, period_s / 2.0)
        here = trip.track.at(motor, trip.time_s)
        planned = abs(there - here) / max(until_s - trip.time_s, 1e-6) / COUNTS_S_PER_RPM
        most = _catch_up_rpm(planned)
        if planned < SLOW_RPM:
            target = round(there)
            ahead = lead.way * (target - drive.position) > 0.5
            rpm = whole_rpm(math.ceil(needed / COUNTS_S_PER_RPM), most)
            return (target, rpm) if ahead else None
        rpm = whole_rpm(round(needed / COUNTS_S_PER_RPM), most)
        room = min(
            lead.way * (lead.far - drive.position),
            rpm * COUNTS_S_PER_RPM * max(trip.ahead_s - period_s / 2.0, period_s),
        )
        return (round(drive.position + lead.way * room), rpm) if room > 0.5 else None

    def _to_rest(self, drive: Drive, lead: Lead) -> tuple[int, int] | None:
        """Have a drive end where its motor stands for now, unless it has been sent there."""
        rest = round(lead.far)
        if drive.target == rest:
            return None
        return rest, whole_rpm(round(drive.told / COUNTS_S_PER_RPM), SPEED_MAX_RPM)

    def _last_order(self, trip: Trip, motor: int) -> tuple[int, int] | None:
        """Return the end of the motion, and the speed that has the drive there in time."""
        drive, track = self.drives[motor], trip.track
        end = track.end[motor]
        if not drive.moving and drive.target == end:
            return None
        left_s = max(track.end_s - trip.time_s, 1e-3)
        planned = abs(end - track.at(motor, trip.time_s)) / left_s / COUNTS_S_PER_RPM
        most = _catch_up_rpm(planned)
        needed = abs(end - drive.position) / left_s / COUNTS_S_PER_RPM
        return end, min(max(math.ceil(needed), LAST_RPM), most)

    # -- looking ------------------------------------------------------------------------------

    def _poll_s(self, trip: Trip) -> float:
        return trip.polled_s + self.settings.poll_s

    def _poll(self, trip: Trip) -> None:
        """Ask every drive where it is, which also feeds its watchdog."""
        if self.now_s < self._poll_s(trip):
            return
        trip.look(self.now_s)
        for node in self.nodes:
            self.put(node, ReadEncoder())
        if any(drive.seen is not None for drive in self.drives):
            self.tell(Progress(self.registers()))

    def _weighed(self, trip: Trip, heard: Event) -> Generator[float, Event | None, Reply | None]:
        """Take in what was heard; return what the motion has come to, where it has come to one."""
        quiet_s, held_up = self.answered_last_s, self.held_up
        owed = {drive.node: drive.gap.owed for drive in self.drives} if held_up else {}
        self.heed(heard)
        match heard:
            case _ if held_up and self.answered_last_s > quiet_s:
                return (yield from self.catch_up(trip, quiet_s, owed))
            case Answered(node, _, EncoderRead(counts)):
                return (yield from self._seen(node, counts)) or (yield from self.beside(trip))
            case LimitStop(node, _):
                words = f"{self.drive(node)} has run into a limit switch, which stopped it"
                alert = Alert(AlertKind.ALARM_LOST, words)
                return (yield from self.break_off(node, alert))
            case Failed(_, MoveAbsoluteAxis()):
                pass  # an older target's end, or a denial, which is looked into a moment later
            case StoredForStart(node, motion):
                self.put(node, ArmSynchronous(on=False))
                self.put_motion(node, motion)  # type: ignore[arg-type]
            case _:
                self.weigh_unasked(heard)
        return None

    def _seen(self, node: int, counts: int) -> Generator[float, Event | None, Reply | None]:
        """Compare a drive with its model; who is off its way, and goes on no more, ends it all."""
        drive, doubt = self.drive(node), self.drive(node).doubt
        off = drive.off_by(counts, self.now_s)
        if (drive.leap.leapt or math.isfinite(drive.gap.doubted_s)) and self.began_anew(node):
            return (yield from self.break_off(node))
        if drive.leap.suspected:  # nothing is made of this look before there is another one
            self.put(node, ReadEncoder())
            return None
        astray = off > self.settings.corridor_counts
        if astray and doubt.is_too_soon(drive.questions.asked_s):
            return None
        let_pass = abs(drive.position - counts) - off + self.settings.corridor_counts
        if astray and not doubt.is_well(counts, drive.position, let_pass, self.reach):
            return (yield from self.break_off(node))
        if drive.moving:
            drive.believe(counts, GAIN)
        if astray:
            doubt.note(counts, drive.position, self.now_s)
        else:
            doubt.forget()
        return None

    def _denied(self) -> Generator[float, Event | None, Reply | None]:
        """End a motion in which a drive takes its orders no more."""
        denied = None if self.held_up else (yield from self.say_again())
        return None if denied is None else (yield from self.break_off(*denied))

    def _unheard(self) -> Generator[float, Event | None, Reply | None]:
        """End a motion in which a drive has been asked again and again, and was not heard."""
        unanswered = [drive.unanswered for drive in self.drives]
        most = MUTE_LOOKS if min(unanswered) <= 1 else ALL_MUTE_LOOKS
        if max(unanswered) <= most:
            return None
        return (yield from self.lose(self.now_s - most * self.settings.poll_s))


def _catch_up_rpm(planned: float) -> int:
    """Return the fastest speed that a drive is told where it lags, by the planned rpm."""
    return min(math.ceil(CATCH_UP * planned) + CATCH_UP_RPM, SPEED_MAX_RPM)
