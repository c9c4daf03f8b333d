"""How MKS drives are brought to a stand-still, and how it is seen that they stand.

By a speed of zero with the drive's ramp, or at once where that was asked for. A bus may lose a
stop, and with it the question whether it was heard. So whoever has not said that it brakes is told,
and asked, every `STOP_POLL_S`; one that says that it runs is told at once.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace

from armdrive.dialects.bus.group import Act, Phase, Signal, lead
from armdrive.dialects.bus.observer import MUTE_LOOKS, ObservedDrive
from armdrive.dialects.mks.wire import Asking, Hindrance, MksWire
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
)

STOP_POLL_S = 0.02
"""How often drives that brake are looked at, and told to stop where they have not said so."""
EASE_S = 0.1
"""A set-point takes so long to come back to its shaft, ramps apart."""
EASE_MAX_RPM = 300
"""A shaft that comes free meanwhile goes no faster."""
ASKED = 2
"""How often a drive is asked how far off it is: firmware that cannot tell costs two answers."""
LEAST_SHARE = 0.1
"""A slow drive's ramp is at least this share of the steepest: it has corners to follow."""
RUNNING = (MotorState.ACCELERATING, MotorState.FULL_SPEED)
"""Whoever says this behind a stop has not heard it."""


class Braking:
    """The stage in which drives are told to stop, and looked at until all stand.

    Who is `insisting` says the stop until each has been heard to brake. `judged` says that a drive
    which rests off its way is told of: nobody else looks for that.
    """

    def __init__(
        self,
        wire: MksWire,
        stops: MksStops,
        nodes: Collection[int],
        *,
        hard: bool = False,
        judged: bool = False,
        insisting: bool = True,
    ) -> None:
        self._wire, self._stops = wire, stops
        self._hard, self._insisting = hard, insisting
        self.judged = judged
        self.standing: list[int] = []
        self.left = set(nodes)
        self._deaf = set(nodes) if insisting else set[int]()
        self.began_s = wire.now_s
        patience_s = 20.0 * wire.settings.answer_s + 0.5
        self._given_up_s = self.began_s + 2.0 * stops.ramp_s + patience_s
        self._due_s = self.began_s
        self._still: dict[int, tuple[int, float]] = {}
        for node in nodes:
            wire.states.pop(node, None)
            wire.drive(node).ledger.alone = True  # those that stand are not asked

    @property
    def mute(self) -> tuple[int, ...]:
        """Return those that have left all questions of a while unanswered."""
        return tuple(
            node
            for node in self._wire.nodes
            if node in self.left and self._wire.drive(node).ledger.unheard_looks >= 2 * MUTE_LOOKS
        )

    def speak(self, now_s: float) -> float:
        """Say the stop to those that do not brake, and ask all that do not stand."""
        wire = self._wire
        if wire.stop_hard and not self._hard and self._insisting:
            self._hard, self._deaf = True, set(self.left)
            self._stops.say(self.left, hard=True)
        running = [node for node in self._deaf if wire.states.get(node) in RUNNING]
        for node in running:  # another motor of the same joint brakes already
            del wire.states[node]
            self._stops.say((node,), hard=self._hard)
            wire.put(node, ReadState())
        self._deaf = {node for node in self._deaf & self.left if node not in wire.states}
        if now_s >= self._due_s:
            if self._deaf and now_s > self.began_s:
                self._stops.say(sorted(self._deaf), hard=self._hard)
            witness = [node for node in wire.nodes if node not in self.left][:1]
            for node in (*sorted(self.left), *witness):
                wire.put(node, ReadState())
                wire.put(node, ReadEncoder())
            wire.tell(Progress(wire.registers()))
            self._due_s = now_s + STOP_POLL_S
        return self._due_s

    def signal(self, now_s: float) -> Signal | None:
        """Return whether all stand, or why that will not be known."""
        for node in tuple(self.left):
            if self._stands(self._wire.drive(node)):
                self._settle(self._wire.drive(node), now_s)
        if not self.left:
            return Signal.STAND
        return Signal.LOST if self.mute or now_s >= self._given_up_s else None

    def _stands(self, drive: ObservedDrive) -> bool:
        """Tell whether its state says so, and two looks one behind the other find no turning.

        Of one that may have been away it is not known: what it was told may be answered yet.
        """
        if drive.count is None or drive.read_s < self.began_s:
            return False
        first = self._still.get(drive.node)
        if first is None or abs(drive.count - first[0]) > drive.bounds.rest // 4 + 1:
            self._still[drive.node] = drive.count, drive.read_s
            return False
        stands = self._wire.states.get(drive.node) is MotorState.STOPPED
        return stands and drive.asked_s > first[1] and not drive.ledger.pending

    def _settle(self, drive: ObservedDrive, now_s: float) -> None:
        self._wire.host.settle(drive.node)
        self.left.discard(drive.node)
        self.standing.append(drive.node)
        if self.judged and drive.course.told:  # who homes goes where nobody sent it
            if drive.has_restarted:
                self._wire.tell(Alert(AlertKind.RESTARTED, restarted_words(drive)))
            elif drive.is_elsewhere or drive.rests_astray:
                self._wire.tell(Alert(AlertKind.ASTRAY, _astray_words(drive)))
        drive.rest_at(drive.count or 0, now_s)


class MksStops:
    """Says stops, and has drives that stand push against nothing."""

    def __init__(self, wire: MksWire, ramp_s: float) -> None:
        self._wire = wire
        self.ramp_s = ramp_s
        """How long the fastest drive of the arm brakes."""

    def say(self, nodes: Collection[int], *, hard: bool) -> None:
        """Tell drives to stop, by ramps in proportion to their speeds: all stand at once."""
        wire = self._wire
        for drive in wire.drives:
            drive.course.advance(wire.now_s)
        fastest = max(abs(drive.course.speed) for drive in wire.drives)
        for node in nodes:
            speed = abs(wire.drive(node).course.speed)
            dead = hard and speed / COUNTS_S_PER_RPM <= HARD_STOP_MAX_RPM
            if dead and wire.can(Ability.EMERGENCY_STOP):
                wire.put(node, EmergencyStop(), "EMERGENCY STOP")
            else:
                share = speed / fastest if speed else 1.0
                ramp = 0 if dead else shared_acc(wire.settings.acceleration, share)
                wire.put(node, Stop(Code.ABSOLUTE_AXIS, ramp), "STOP")

    def brake(self, nodes: Collection[int], *, hard: bool = False, judged: bool = False) -> Braking:
        """Tell drives to stop; return the stage in which that is seen to."""
        for node in nodes:
            self._wire.drive(node).stop(self._wire.now_s)
        self.say(nodes, hard=hard)
        return Braking(self._wire, self, nodes, hard=hard, judged=judged)

    def halt(self, nodes: Collection[int], *, hard: bool = False, judged: bool = True) -> Hindrance:
        """Stop drives and wait until they stand; return why that is not known, where it is not."""
        braking = self.brake(nodes, hard=hard, judged=judged)
        stages = {Phase.STOPPING: lambda: braking}
        hold = {Act.HOLD: lambda: self.hold(braking)}
        yield from lead(self._wire, Phase.STOPPING, stages, hold)
        return self.unstopped(braking)

    # -- what pushes on -----------------------------------------------------------------------
    #
    # A closed loop pushes towards its set-point for as long as it is held off it, and springs there
    # when it is let free, whenever that may be. So a drive that came to rest elsewhere is sent to
    # where its shaft is. It tells how far that is off (39).

    def hold(self, braking: Braking) -> Asking[None]:
        """Have drives that stand, and push, be where they are."""
        pushing = yield from self.ease(braking.standing)
        for node, off in pushing.items():
            if braking.judged:
                words = pressing_words(self._wire.drive(node), off)
                self._wire.tell(Alert(AlertKind.ASTRAY, words))
        braking.left |= yield from self.eased(pushing)

    def ease(self, nodes: Collection[int]) -> Asking[dict[int, int]]:
        """Send drives that stand, and push, to where they are; return how far off each was.

        Once only: one that hangs off its set-point wherever that is would be followed away.
        """
        wire = self._wire
        found = yield from wire.read(ReadAngleError(), nodes, tries=ASKED, patient=False)
        errors = {
            node: round(told.error * COUNTS_PER_TURN / ANGLE_ERROR_PER_TURN)
            for node, told in found.items()
            if isinstance(told, AngleErrorRead)
        }
        pushing = {node: off for node, off in errors.items() if self._pushes(node, off)}
        for node, off in pushing.items():
            rpm = min(math.ceil(abs(off) / EASE_S / COUNTS_S_PER_RPM), EASE_MAX_RPM)
            here = wire.drive(node).count or 0
            wire.send(node, MoveAbsoluteAxis(here, rpm, wire.settings.acceleration))
        return pushing

    def eased(self, nodes: Mapping[int, int]) -> Asking[set[int]]:
        """Wait until eased drives stand; return those that do not.

        No stop is said to them, hard or not: it would leave them pushing.
        """
        braking = Braking(self._wire, self, nodes, insisting=False)
        if nodes:
            stages = {Phase.STOPPING: lambda: braking}
            yield from lead(self._wire, Phase.STOPPING, stages, {Act.HOLD: lambda: None})
        return braking.left

    def _pushes(self, node: int, off: int) -> bool:
        reachable = abs(self._wire.drive(node).count or 0) <= TARGET_MAX
        return reachable and abs(off) > self._wire.settings.rest_counts

    def unstopped(self, braking: Braking) -> Timeout | RequestRejected | None:
        """Return why it is not known that drives stand; None where all do."""
        left, mute = braking.left, braking.mute
        if not left:
            return None
        if set(mute) >= left:
            absence = self._wire.absence(mute, braking.began_s)
            if isinstance(absence, Timeout):
                return absence
            return replace(absence, moved=True, silent=True)
        words = f"{self._wire.drive(min(left))} was told to stop, and does not come to rest"
        return RequestRejected(words)


def shared_acc(acc: int, share: float) -> int:
    """Return the ramp of a drive that goes at a share of the fastest one's speed.

    So all come to their speeds, and to rest, in the same time, and stay in proportion.
    """
    return acc_of(max(share, LEAST_SHARE) * ramp_rpm_s(acc)) if acc else 0


def pressing_words(drive: ObservedDrive, off: int) -> str:
    """Say that a drive pressed against something."""
    return (
        f"{drive} pressed against something as it stopped, {abs(off)} counts from where it "
        "would stand: it is blocked, overloaded, or was turned by force. It was told to stay "
        "where it is, and pushes no more"
    )


def restarted_words(drive: ObservedDrive) -> str:
    """Say that a drive has restarted, and how surely that is known."""
    if math.isinf(drive.ledger.away_s):
        return f"{drive} was reset or lost its power: it counts from zero again"
    return (
        f"{drive} was gone for a moment in motion, and counts {drive.count}: it was reset or lost "
        "its power, most likely, and counts from zero again. Look at its supply and its plug"
    )


def _astray_words(drive: ObservedDrive) -> str:
    return (
        f"{drive} came to rest at {drive.count} counts, off its way: it was reset or lost its "
        "power, is blocked, or was turned by force"
    )
