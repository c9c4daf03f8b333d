"""Stop MKS drives, see that they stand, and relieve those that push against an obstacle.

A stop is a speed of zero with the drive's ramp, or an immediate one. The bus may lose a stop, and
the reply to it as well. So a drive that has not reported braking gets the stop, and a question,
every `STOP_POLL_S`; a drive that reports running gets it again at once.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

from armdrive.dialects.bus.intervals import DriveFinding
from armdrive.dialects.bus.paths import Course
from armdrive.dialects.bus.phases import Act, Braking, Phase, run_phases
from armdrive.dialects.bus.questions import MUTE_POLLS
from armdrive.dialects.exchange import Obstructed
from armdrive.dialects.mks.drive import APART_S, RUNNING, MksDrive
from armdrive.dialects.mks.exchange import MksExchange, MksScript
from armdrive.tasks import Alert, AlertKind, Progress, RequestRejected, Timeout
from firmware_protocol.mks import (
    ANGLE_ERROR_PER_TURN,
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    HARD_STOP_MAX_RPM,
    TARGET_MAX,
    Ability,
    AngleErrorRead,
    Code,
    EmergencyStop,
    MotorState,
    MoveAbsoluteAxis,
    ReadAngleError,
    ReadEncoder,
    ReadState,
    Stop,
    acc_of,
    ramp_rpm_s,
    slope_of,
)
from kinematics.text import counted

# How often braking drives are polled, and get the stop again if they have not confirmed it.
STOP_POLL_S = 0.02
# How long a set-point takes to return to its shaft, ramps excluded.
RELIEF_S = 0.1
# The speed limit of a shaft that comes free meanwhile.
RELIEF_MAX_RPM = 300
# How often a drive is asked for its angle error: firmware without that answer costs the wait.
RELIEF_TRIES = 2
# A slow drive's ramp is at least this share of the steepest: it has corners to follow.
MIN_RAMP_SHARE = 0.1
# How much steeper than necessary a drive brakes at its target.
BRAKING_MARGIN = 1.1
# The longest time until an order takes effect: its frame, those before it, a late loop.
ORDER_DELAY_S = 0.003


class MksBraking(Braking[MksDrive]):
    """How MKS drives are stopped, and seen to stand.

    The stop is repeated until each drive reports braking, and if it reports running after that,
    because the stop has overtaken an order; unless `repeats` is off: then they come to rest by
    themselves. With `judged`, a drive that comes to rest off its path is reported, because no other
    check would find that.
    """

    def __init__(
        self,
        io: MksExchange,
        stops: MksStops,
        drives: Collection[MksDrive],
        *,
        hard: bool = False,
        judged: bool = False,
        repeats: bool = True,
    ) -> None:
        patience_s = 2.0 * stops.ramp_s + 20.0 * io.settings.answer_s + 0.5
        super().__init__(drives, io.listened, patience_s)
        self._io, self._stops = io, stops
        self._hard, self._judged, self._repeats = hard, judged, repeats
        self._unconfirmed = tuple(drives) if repeats else ()
        self._began_s = self._due_s = io.now_s
        for drive in drives:
            drive.state = None

    def step(self, now_s: float) -> float:
        """Send the stop to drives that do not brake, and ask all that do not stand."""
        io, left = self._io, self.left
        if io.stop_hard and not self._hard and self._repeats:
            self._hard, self._unconfirmed = True, tuple(left)
            self._stops.send(left, hard=True)
        for drive in left if self._repeats else ():
            if drive.state in RUNNING:  # another motor of the same joint brakes already
                drive.state = None
                self._unconfirmed = (*self._unconfirmed, drive)
                self._stops.send((drive,), hard=self._hard)
                io.put(drive, ReadState())
        self._unconfirmed = tuple(
            drive for drive in left if drive in self._unconfirmed and drive.state is None
        )
        if now_s >= self._due_s:
            if self._unconfirmed and now_s > self._began_s:
                self._stops.send(self._unconfirmed, hard=self._hard)
            for drive in (*left, *io.witness(left)):
                io.put(drive, ReadState())
                io.put(drive, ReadEncoder())
            io.notify(Progress(io.registers()))
            self._due_s = now_s + STOP_POLL_S
        return self._due_s

    def stands(self, drive: MksDrive) -> bool:
        """Return whether a drive reports that it stands and two separate readings agree.

        Not while it may have been away: it may still answer what it was sent meanwhile.
        """
        stands = drive.state is MotorState.STOPPED
        still_s = max(drive.still_s, self._began_s)
        return stands and drive.asked_s >= still_s + APART_S and not drive.absence.suspected

    def settle(self, drive: MksDrive, now_s: float) -> None:
        """Record that a drive stands, and report one that stands off its path."""
        super().settle(drive, now_s)
        if self._judged and drive.course.max_speed:  # a homing drive has no path
            if drive.finding is DriveFinding.RESTARTED:
                self._io.notify(Alert(AlertKind.RESTARTED, restarted_words(drive)))
            elif drive.is_elsewhere or drive.rests_off_path:
                self._io.notify(Alert(AlertKind.OFF_PATH, _off_path_words(drive)))
        drive.rest_at(drive.count, now_s)

    def is_mute(self, drive: MksDrive) -> bool:
        """Return whether a drive has left too many questions unanswered."""
        return drive.ledger.unanswered_polls >= 2 * MUTE_POLLS

    def absence(self, mute: Sequence[MksDrive]) -> Timeout | RequestRejected:
        """Return the reply that names missing drives."""
        return self._io.absence(mute, self._began_s)


class MksStops:
    """Sends stops, and relieves drives that stand and push."""

    def __init__(self, io: MksExchange, ramp_s: float) -> None:
        self._io = io
        self.ramp_s = ramp_s
        """How long the arm's fastest drive brakes."""

    def send(self, drives: Iterable[MksDrive], *, hard: bool) -> None:
        """Send drives a stop, with ramps in proportion to their speeds: all stop together.

        One that would pass its target brakes harder.
        """
        io = self._io
        for each in io.drives:
            each.course.advance(io.now_s)
        fastest = max(abs(each.course.speed) for each in io.drives)
        for drive in drives:
            speed = abs(drive.course.speed)
            immediate = hard and speed / COUNTS_S_PER_RPM <= HARD_STOP_MAX_RPM
            if immediate and io.can(Ability.EMERGENCY_STOP):
                io.put(drive, EmergencyStop(), "EMERGENCY STOP")
            else:
                share = speed / fastest if speed else 1.0
                most = io.settings.acceleration
                ramp = 0 if immediate else ramp_to(drive.course, drive.goal, most, share)
                io.put(drive, Stop(Code.ABSOLUTE_AXIS, ramp), "STOP")

    def brake(
        self, drives: Collection[MksDrive], *, hard: bool = False, judged: bool = False
    ) -> Braking[MksDrive]:
        """Send drives a stop; return the stage that sees to it."""
        for drive in drives:
            drive.stop(self._io.now_s)
        self.send(drives, hard=hard)
        return MksBraking(self._io, self, drives, hard=hard, judged=judged)

    def halt(self, drives: Collection[MksDrive]) -> MksScript[None]:
        """Stop drives and wait until they stand. Raises `Obstructed` if that is not known.

        Drives that home ignore ramps.
        """
        homes = any(drive.state is MotorState.HOMING for drive in drives)
        braking = self.brake(drives, hard=homes, judged=True)
        stages = {Phase.STOPPING: lambda: braking}
        hold = {Act.HOLD: lambda: self.hold(braking, judged=True)}
        yield from run_phases(self._io, Phase.STOPPING, stages, hold)
        if (unstopped := braking.unstopped()) is not None:
            raise Obstructed(unstopped)

    # -- drives that push ---------------------------------------------------------------------
    #
    # A position loop pushes towards its set-point for as long as the shaft is held away from it,
    # and springs there as soon as the shaft comes free. So a drive that came to rest elsewhere gets
    # its own position as the target. It reports the distance between the two (39).

    def hold(self, braking: Braking[MksDrive], *, judged: bool) -> MksScript[None]:
        """Relieve drives that stand and push; report them if they are `judged`."""
        pushing = yield from self.relieve(braking.standing)
        braking.left += yield from self.relieved(pushing)
        for drive, off in pushing.items():
            if judged:
                self._io.notify(Alert(AlertKind.OFF_PATH, pushing_words(drive, off)))

    def relieve(self, drives: Collection[MksDrive]) -> MksScript[dict[MksDrive, int]]:
        """Send drives that push to where they stand; return how far off each one's target was.

        Once only: a shaft that always hangs off its set-point would be followed away.
        """
        io, pushing = self._io, dict[MksDrive, int]()
        found = yield from io.read(ReadAngleError(), drives, tries=RELIEF_TRIES, patient=False)
        for drive, answer in found.items():
            if not isinstance(answer, AngleErrorRead):
                continue
            here = drive.count
            off = round(answer.error * COUNTS_PER_TURN / ANGLE_ERROR_PER_TURN)
            if abs(off) <= io.settings.in_position_counts:
                continue
            if abs(here) > TARGET_MAX:  # no target can be commanded there
                continue
            pushing[drive] = off
            rpm = min(rpm_within(abs(off), RELIEF_S), RELIEF_MAX_RPM)
            drive.rejected_s = math.inf
            io.send(drive, MoveAbsoluteAxis(here, rpm, io.settings.acceleration))
        return pushing

    def relieved(self, drives: Collection[MksDrive]) -> MksScript[list[MksDrive]]:
        """Wait until relieved drives stand; return those that do not.

        They get no stop, not even an emergency stop: it would leave them pushing.
        """
        braking = MksBraking(self._io, self, drives, repeats=False)
        if drives:
            stages = {Phase.STOPPING: lambda: braking}
            yield from run_phases(self._io, Phase.STOPPING, stages, {Act.HOLD: lambda: None})
        return braking.left


def shared_acc(acc: int, share: float) -> int:
    """Return the ramp of a drive that moves at a share of the fastest one's speed.

    So all drives reach their speeds, and come to rest, in the same time and stay in proportion.
    """
    return acc_of(max(share, MIN_RAMP_SHARE) * ramp_rpm_s(acc)) if acc else 0


def rpm_within(counts: float, time_s: float) -> int:
    """Return the lowest whole rpm at which a drive turns this far in a time, ramps excluded."""
    return math.ceil(counts / time_s / COUNTS_S_PER_RPM)


def ramp_to(course: Course, target: int, acc: int, share: float, kept: int = 0) -> int:
    """Return a drive's ramp to a target: its share, or a steeper one if it must brake harder.

    A ramp gentler than the one that gave it its speed would make it overshoot. So would one gentler
    than that by which it already brakes (`kept`), since its course may be ahead of it.
    """
    shared = max(shared_acc(acc, share), min(kept, acc))
    left = abs(target - course.place) - abs(course.speed) * ORDER_DELAY_S
    brakes = BRAKING_MARGIN * course.speed**2 / (2.0 * max(left, 1.0))
    if not acc or brakes <= slope_of(shared):
        return shared
    needed = acc_of(brakes / COUNTS_S_PER_RPM)
    return min(needed + (slope_of(needed) < brakes), acc)


def pushing_words(drive: MksDrive, off: int) -> str:
    """Return that a drive pushed against something, or still does if it rejected its relief."""
    if math.isfinite(drive.rejected_s):
        return (
            f"{drive} presses against something, {counted(abs(off), 'count')} from its "
            "target, and rejects "
            "the order to stay where it is: its shaft springs when it comes free. Support the arm, "
            "switch the motors' supply off, and find out why (`armdrive doctor`)"
        )
    return (
        f"{drive} pressed against something as it stopped, {counted(abs(off), 'count')} "
        "from its target: it "
        "is blocked, overloaded, or was turned by force. Its target is now where it stands, so it "
        "pushes no more"
    )


def restarted_words(drive: MksDrive) -> str:
    """Return that a drive has restarted, and how certain that is."""
    if math.isinf(drive.absence.since_s):
        return f"{drive} was reset or lost its power: it counts from zero again"
    if drive.is_within_reach:
        return (
            f"{drive} did not answer for a while in motion. Its orders can have taken it to where "
            f"it counts now, {drive.count}, but a drive that was reset or lost its power meanwhile "
            "can count the same. Check its supply and its plug"
        )
    return (
        f"{drive} was gone for a moment in motion, and counts {drive.count}: most likely it was "
        "reset or lost its power, and counts from zero again. Check its supply and its plug"
    )


def _off_path_words(drive: MksDrive) -> str:
    return (
        f"{drive} came to rest at {drive.count} counts, off its path: it was reset or lost its "
        "power, is blocked, or was turned by force"
    )
