"""Stop MKS drives, see that they stand, and relieve those that push against an obstacle."""

from __future__ import annotations

import math
from collections.abc import Collection

from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.exchange import MksExchange, MksScript
from armdrive.tasks import Progress
from firmware_protocol.mks import (
    ANGLE_ERROR_PER_TURN,
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    HARD_STOP_MAX_RPM,
    TARGET_MAX,
    Ability,
    AngleErrorRead,
    EmergencyStop,
    MoveAbsoluteAxis,
    ReadAngleError,
    Stop,
    acc_of,
    ramp_rpm_s,
    slope_of,
)
from kinematics.text import counted

# How often braking drives are polled, and get the stop again.
STOP_POLL_S = 0.02
# A drive stands if its count has not changed for this long. At 1 rpm, a count changes by 10.
STANDS_S = 0.04
# How much longer than its ramp a drive may take to come to rest.
PATIENCE_S = 1.5
# The speed at which a set-point returns to its shaft, and the time it has for that.
RELIEF_RPM, RELIEF_S = 300, 0.3
# How much steeper than necessary a drive brakes at its target.
BRAKING_MARGIN = 1.1
# The longest time until an order takes effect: its frame, those before it, a late loop.
ORDER_DELAY_S = 0.003
# A slow drive's ramp is at least this share of the steepest: it has corners to follow.
MIN_RAMP_SHARE = 0.1


def halt(io: MksExchange, drives: Collection[MksDrive], *, hard: bool) -> MksScript[list[MksDrive]]:
    """Stop drives, and wait until they stand; return those that are not known to.

    The stop is repeated until a drive stands: no reply shows that it was received, since an
    order before it is answered alike.
    """
    left, most = list(drives), io.settings.acceleration
    if not left:
        return left
    for drive in drives:
        drive.reckon(io.now_s)
    fastest = max(abs(drive.speed) for drive in drives) or 1.0
    ramps = {each: ramp_to(each, each.target, most, abs(each.speed) / fastest) for each in drives}
    for drive in drives:
        drive.order = None  # no reply makes it be sent again
    began_s, due_s, end_s = io.now_s, io.now_s, io.listened.s + 2.0 * io.ramp_s + PATIENCE_S
    while left and io.listened.s < end_s:
        at_once = io.stop_hard and not hard
        hard = hard or io.stop_hard
        if io.now_s >= due_s or at_once:
            for drive in left:
                _send(io, drive, ramps[drive], hard=hard)
            io.notify(Progress(io.registers()))
            due_s = io.now_s + STOP_POLL_S
        yield from io.hear(min(io.poll(left, STOP_POLL_S), due_s))
        for drive in tuple(left):
            if drive.stands(began_s, STANDS_S) and not drive.questions.owes:
                left.remove(drive)
        if all(drive.questions.lost(io.listened.s) for drive in left):
            break
    return left


def _send(io: MksExchange, drive: MksDrive, ramp: int, *, hard: bool) -> None:
    # fast drives must not do without a ramp; those that home ignore it, and are stopped hard
    hard = hard and abs(drive.speed) / COUNTS_S_PER_RPM <= HARD_STOP_MAX_RPM
    if hard and io.can(Ability.EMERGENCY_STOP):
        io.put(drive, EmergencyStop(), "EMERGENCY STOP")
    else:
        io.put(drive, Stop(0 if hard else ramp), "STOP")


def relieve(io: MksExchange, drives: Collection[MksDrive]) -> MksScript[dict[MksDrive, int]]:
    """Give drives that push their places as targets; return how far off their targets were.

    A position loop pushes towards its set-point for as long as the shaft is held away from it,
    and springs there as soon as the shaft comes free. Drives report that distance (39). They
    are relieved once only: a shaft that always hangs off its set-point would be followed away.
    """
    pushing = dict[MksDrive, int]()
    found = yield from io.read(ReadAngleError(), drives)
    for drive, answer in found.items():
        error = answer.error if isinstance(answer, AngleErrorRead) else 0
        off = round(error * COUNTS_PER_TURN / ANGLE_ERROR_PER_TURN)
        if abs(off) > drive.rest and abs(drive.count) <= TARGET_MAX:
            pushing[drive] = off
            drive.rejected_s = math.inf
            rpm = max(1, min(RELIEF_RPM, round(abs(off) / COUNTS_S_PER_RPM / RELIEF_S * 3)))
            io.send(drive, MoveAbsoluteAxis(drive.count, rpm, io.settings.acceleration))
    if pushing:
        end_s = io.now_s + RELIEF_S
        while io.now_s < end_s:
            yield from io.hear(min(io.poll(pushing, STOP_POLL_S), end_s))
        for drive in pushing:
            drive.stand(io.now_s)
    return pushing


def shared_acc(acc: int, share: float) -> int:
    """Return the ramp of a drive that moves at a share of the fastest one's speed.

    So all drives reach their speeds, and come to rest, in the same time and stay in proportion.
    """
    return acc_of(max(share, MIN_RAMP_SHARE) * ramp_rpm_s(acc)) if acc else 0


def ramp_to(drive: MksDrive, target: int, acc: int, share: float) -> int:
    """Return a drive's ramp to a target: its share, or a steeper one if it must brake harder.

    A ramp gentler than the one that gave it its speed would make it overshoot. So would one gentler
    than that by which it already brakes, since it may be behind its reckoned place.
    """
    ramp, speed = shared_acc(acc, share), abs(drive.speed)
    if drive.order is not None and drive.order.counts == target:
        ramp = max(ramp, min(drive.order.acc, acc))
    left = abs(target - drive.place) - speed * ORDER_DELAY_S
    needed = BRAKING_MARGIN * speed**2 / (2.0 * max(left, 1.0))
    if not acc or needed <= slope_of(ramp):
        return ramp
    return min(acc_of(needed / COUNTS_S_PER_RPM) + 1, acc)


def pushing_words(drive: MksDrive, off: int) -> str:
    """Return that a drive pushed against something, or still does if it rejected its relief."""
    where = f"{counted(abs(off), 'count')} from its target"
    if math.isfinite(drive.rejected_s):
        return (
            f"{drive} presses against something, {where}, and rejects the order to stay where it "
            "is: its shaft springs when it comes free. Support the arm, switch the motors' supply "
            "off, and find out why (`armdrive doctor`)"
        )
    return (
        f"{drive} pressed against something as it stopped, {where}: it is blocked, overloaded, or "
        "was turned by force. Its target is now where it stands, so it pushes no more"
    )
