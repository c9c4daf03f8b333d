"""How MKS drives are brought to a stand-still, and how it is seen that they stand.

By a speed of zero with the drive's ramp, or at once where that was asked for. That a drive stands
is believed when its state says so and its encoder twice the same. One that pushes against something
then is eased.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Generator, Iterable
from dataclasses import replace
from typing import TypeVar

from armdrive.abilities import Abilities
from armdrive.dialects.mks.drive import (
    COUNTS_S_PER_RPM,
    MksDrive,
    anew_words,
    counts_anew,
    shared_acc,
)
from armdrive.dialects.mks.exchange import MksTalk
from armdrive.dialects.mks.settings import MksSettings
from armdrive.tasks import Alert, AlertKind, Progress, ProtocolWarning, RequestRejected, Timeout
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    ANGLE_ERROR_PER_TURN,
    COUNTS_PER_TURN,
    HARD_STOP_MAX_RPM,
    TARGET_MAX,
    Ability,
    AngleErrorRead,
    Answered,
    Code,
    EmergencyStop,
    Event,
    Mode,
    MotorState,
    MoveAbsoluteAxis,
    ReadAngleError,
    ReadSetting,
    ReadStall,
    ReadState,
    SetMode,
    SettingRead,
    StallRead,
    StateRead,
    Stop,
    as_setting,
)

# What keeps pushing after it has stopped: a drive whose shaft something holds aside is eased.
#
# A closed loop pushes towards its set-point for as long as it is held off it, and springs there
# when it is let free, whenever that may be. So a drive that came to rest elsewhere is sent to
# where its shaft is. It tells how far that is off (39).

EASE_S = 0.1
"""A set-point takes so long to come back to its shaft, ramps apart."""
EASE_MAX_RPM = 300
"""A shaft that comes free meanwhile goes no faster."""
ASKED = 2
"""How often a drive is asked how far off it is: firmware that cannot tell costs two answers."""


class MksWindupRelease(MksTalk):
    """Sends drives to a count, and those that push to where they are."""

    def send(self, node: int, target: int, rpm: int, acc: int) -> None:
        """Send a drive to a count, at a speed and by a ramp."""
        self.put_motion(node, MoveAbsoluteAxis(target, rpm, acc))
        self.drive(node).send_to(target, rpm, acc, self.now_s)

    @property
    def targets(self) -> str:
        """Where all drives were sent last, for whoever reads what was said."""
        return " ".join(str(drive.target) for drive in self.drives)

    def put_motion(self, node: int, message: MoveAbsoluteAxis) -> None:
        """Say a motion; what the host still waits for of older ones is not waited for."""
        for earlier in self._host.unanswered(node):
            if isinstance(earlier, MoveAbsoluteAxis):
                self._host.forget(node, earlier)
        self.put(node, message)

    def ease(self, nodes: Collection[int]) -> Generator[float, Event | None, dict[int, int]]:
        """Send drives that stand, and push, to where they are; return how far off each was.

        Once only: one that hangs off its set-point wherever that is would be followed away.
        """
        messages = dict.fromkeys(nodes, ReadAngleError())
        found = yield from self.ask(messages, tries=ASKED, patient=False)
        errors = {node: _counts_off(heard) for node, heard in found.items()}
        pushing = {node: off for node, off in errors.items() if self._pushes(node, off)}
        for node, off in pushing.items():
            rpm = math.ceil(abs(off) / EASE_S / COUNTS_S_PER_RPM)
            here = self.drive(node).seen or 0
            self.send(node, here, min(rpm, EASE_MAX_RPM), self.settings.acceleration)
        return pushing

    def _pushes(self, node: int, off: int) -> bool:
        reachable = abs(self.drive(node).seen or 0) <= TARGET_MAX
        return reachable and abs(off) > self.settings.rest_counts

    def pressing_words(self, drive: MksDrive, off: int) -> str:
        """Say that a drive pressed against something."""
        return (
            f"{drive} pressed against something as it stopped, {abs(off)} counts from where it "
            "would stand: it is blocked, overloaded, or was turned by force. It was told to stay "
            "where it is, and pushes no more"
        )


def _counts_off(heard: Event) -> int:
    """Return how far a shaft is from its set-point, in counts; 0 where that was not told."""
    if not isinstance(heard, Answered) or not isinstance(heard.answer, AngleErrorRead):
        return 0
    return round(heard.answer.error * COUNTS_PER_TURN / ANGLE_ERROR_PER_TURN)


# How MKS drives are told to stop, again and again, until each has been heard to brake.
#
# A bus may lose a stop, and with it the question whether it was heard. Waiting for that answer
# would let the drive run on: whoever has not said that it brakes is told, and asked, every
# `INSIST_S`.

T = TypeVar("T")
INSIST_S = 0.02
"""A drive that is not known to brake is told so often: some frames a turn, on any bus."""
RUNNING = (MotorState.ACCELERATING, MotorState.FULL_SPEED)
"""Whoever says this behind a stop has not heard it."""


class MksStopRetry(MksWindupRelease):
    """Says stops, and insists on them."""

    able: frozenset[Ability] = frozenset()

    def insisting(
        self, inquiry: Generator[float, Event | None, T], deaf: set[int], *, hard: bool
    ) -> Generator[float, Event | None, T]:
        """Carry out an inquiry; meanwhile say the stop to those who have not said that they brake.

        Who says so is taken out of `deaf`.
        """
        again_s, heard = self.now_s + INSIST_S, None
        while True:
            try:
                until_s = inquiry.send(heard)
            except StopIteration as ended:
                return ended.value  # type: ignore[no-any-return]
            heard = yield min(until_s, again_s) if deaf else until_s
            if _brakes(heard):
                deaf.discard(heard.node)  # type: ignore[union-attr]
            elif deaf and self.now_s >= again_s:
                again_s = self.now_s + INSIST_S
                self._insist(sorted(deaf), hard or self.stop_hard)

    def _insist(self, nodes: Collection[int], hard: bool) -> None:
        self._say_stop(nodes, hard)
        witness = tuple(node for node in self.nodes if node not in nodes)[:1]
        for node in (*nodes, *witness):  # who is gone is told from a bus that loses frames
            self.put(node, ReadState())

    def _say_stop(self, nodes: Collection[int], hard: bool) -> None:
        for drive in self.drives:
            drive.advance(self.now_s)
        fastest = max((abs(drive.speed) for drive in self.drives), default=0.0)
        for node in nodes:
            speed = abs(self.drive(node).speed)
            rpm = speed / COUNTS_PER_TURN * 60.0
            if hard and rpm <= HARD_STOP_MAX_RPM and Ability.EMERGENCY_STOP in self.able:
                self.put(node, EmergencyStop(), "EMERGENCY STOP")
            else:
                share = speed / fastest if speed else 1.0
                ramp = shared_acc(self.settings.acceleration, share)
                dead = hard and rpm <= HARD_STOP_MAX_RPM
                self.put(node, Stop(Code.ABSOLUTE_AXIS, 0 if dead else ramp), "STOP")


def runs(heard: Event | None) -> bool:
    """Tell whether a drive says that it does not brake: the stop before the question was lost."""
    state = heard.answer if isinstance(heard, Answered) else None
    return isinstance(state, StateRead) and state.state in RUNNING


def _brakes(heard: Event | None) -> bool:
    state = heard.answer if isinstance(heard, Answered) else None
    return isinstance(state, StateRead) and state.state not in RUNNING


STOP_POLL_S = 0.02
"""How often drives that brake are looked at."""
STOP_AGAIN_S = 0.06
"""A stop without effect by then was lost."""
MUTE_LOOKS = 4
"""A drive that answers none of so many looks is mute, where another one answers."""
ALL_MUTE_LOOKS = 10
"""So many are given to drives that all are silent: then it is the computer that is late, mostly."""


class MksStopping(MksStopRetry):
    """The ways to a stand-still, and what may keep a drive from moving."""

    firmware = ""
    ramp_s = 1.0
    """How long the fastest drive of the arm brakes."""

    def __init__(self, abilities: Abilities, settings: MksSettings, names: Iterable[str]) -> None:
        super().__init__(abilities, settings, names)
        self._mute: dict[int, int] = {}

    def choose(self) -> None:
        """Choose the ways of moving by what the drives can do."""

    def halt(
        self, nodes: Collection[int], *, hard: bool = False
    ) -> Generator[float, Event | None, Timeout | RequestRejected | None]:
        """Stop drives and wait until they stand; return why that is not known, where it is not."""
        began_s = self.now_s
        for node in nodes:
            self.drive(node).stop(self.settings.corridor_counts, self.now_s)
        self._say_stop(nodes, hard)
        return (yield from self.settled(nodes, began_s, hard=hard, doubtful=True))

    def settled(
        self,
        nodes: Collection[int],
        began_s: float,
        *,
        hard: bool = False,
        doubtful: bool = False,
    ) -> Generator[float, Event | None, Timeout | RequestRejected | None]:
        """Wait until stopped drives stand; say it again to those that do not hear.

        Who is `doubtful` alerts where one came to rest off its way: nobody else looks for that.
        """
        given_up_s = began_s + 2.0 * self.ramp_s + 20.0 * self.settings.answer_s + 0.5
        left = yield from self.brake(nodes, given_up_s, hard=hard, doubtful=doubtful)
        pushing = yield from self.ease([node for node in nodes if node not in left])
        for node, off in pushing.items():
            if doubtful:
                self.tell(Alert(AlertKind.ASTRAY, self.pressing_words(self.drive(node), off)))
        if pushing:
            left |= yield from self.eased(pushing, given_up_s)
        return self._unstopped(left, began_s)

    def brake(
        self,
        nodes: Collection[int],
        given_up_s: float,
        *,
        hard: bool = False,
        doubtful: bool = False,
        again_s: float = STOP_AGAIN_S,
    ) -> Generator[float, Event | None, set[int]]:
        """Wait until drives stand, and say a stop `again_s` later; return those that do not."""
        said_s, left, last = self.now_s, set(nodes), dict[int, int | None]()
        insists = math.isfinite(again_s)
        deaf = set(nodes) if insists else set[int]()
        self._mute.clear()
        for node in nodes:
            self.drive(node).gap.alone = True  # those that stand are not asked
        while left and self.now_s < given_up_s:
            asked_s = self.now_s
            if self.stop_hard and not hard:
                hard, said_s = True, self.now_s
                self._say_stop(left, hard)
            asking = self.ask(dict.fromkeys(left, ReadState()), tries=1)
            found = yield from self.insisting(asking, deaf, hard=hard)
            yield from self.insisting(self.look(left, patient=False), deaf, hard=hard)
            self.tell(Progress(self.registers()))
            for node in tuple(left):
                if self._stands(node, found.get(node), last, doubtful):
                    left.discard(node)
            deaf &= left
            if any(self._mute.get(node, 0) >= MUTE_LOOKS for node in left):
                break
            running = [node for node in left if insists and runs(found.get(node))]
            if left and self.now_s >= said_s + again_s:
                said_s = self.now_s
                self._say_stop(left, hard)
            elif running:  # another motor of the same joint brakes already
                self._say_stop(running, hard)
            yield from self._wait(asked_s + STOP_POLL_S)
        return left

    def eased(
        self, nodes: Collection[int], until_s: float
    ) -> Generator[float, Event | None, set[int]]:
        """Wait until eased drives stand. A stop, hard or not, would leave them pushing."""
        return (yield from self.brake(nodes, until_s, hard=True, again_s=math.inf))

    def _stands(
        self, node: int, heard: Event | None, last: dict[int, int | None], doubtful: bool
    ) -> bool:
        drive = self.drive(node)
        state = heard.answer if isinstance(heard, Answered) else None
        if not isinstance(state, StateRead):
            self._mute[node] = self._mute.get(node, 0) + 1
            return False
        self._mute[node] = 0
        before, last[node] = last.get(node), drive.seen
        if state.state is not MotorState.STOPPED or before is None or drive.seen is None:
            return False
        if drive.gap.pending:  # was it gone for a moment? What it was told may be answered yet
            return False
        if abs(before - drive.seen) > self.settings.rest_counts // 4 + 1:
            return False
        self._host.settle(node)
        doubtful = doubtful and bool(drive.told)  # who homes goes where nobody sent it
        if doubtful and self._began_anew(drive):
            self.tell(Alert(AlertKind.RESTARTED, anew_words(drive)))
        elif doubtful and (drive.rests_off(drive.seen) or drive.leap.leapt):
            self.tell(Alert(AlertKind.ASTRAY, self._astray_words(drive)))
        drive.rest_at(drive.seen, self.now_s)
        return True

    def _began_anew(self, drive: MksDrive) -> bool:
        gone = math.isfinite(drive.gap.doubted_s)
        return gone and counts_anew(drive, self.settings.rest_counts, self.now_s)

    def _astray_words(self, drive: MksDrive) -> str:
        return (
            f"{drive} came to rest at {drive.seen} counts, off its way from "
            f"{round(drive.stopped_at)}: it was reset or lost its power, is blocked, or was turned "
            "by force"
        )

    def _unstopped(self, left: Collection[int], began_s: float) -> Timeout | RequestRejected | None:
        if not left:
            return None
        mute = [node for node in self.nodes if self._mute.get(node, 0) >= MUTE_LOOKS]
        if mute and set(mute) >= set(left):
            absence = self.absence(mute, began_s)
            if isinstance(absence, Timeout):
                return absence
            return replace(absence, moved=True, silent=True)
        return RequestRejected(
            f"{self.drive(min(left))} was told to stop, and does not come to rest"
        )

    def _wait(self, until_s: float) -> Generator[float, Event | None, None]:
        """Let time pass, stop or no stop."""
        while self.now_s < until_s:
            heard = yield until_s
            if heard is not None:
                self.unasked(heard)

    # -- what keeps a drive from moving -------------------------------------------------------

    def stalled(self, nodes: Collection[int]) -> Generator[float, Event | None, list[int]]:
        """Return those of some drives whose protection has let the shaft go."""
        found = yield from self.read(ReadStall(), nodes)
        return [
            node
            for node, heard in found.items()
            if isinstance(heard, Answered) and heard.answer == StallRead(on=True)
        ]

    def stall_words(self, node: int) -> str:
        """Say that a drive's protection has acted."""
        return (
            f"{self.drive(node)} has stalled, and its protection has let the shaft go: look what "
            "blocked it, or give it more current or less speed"
        )

    def mode_words(self, node: int) -> Generator[float, Event | None, str]:
        """Say that a drive is in a mode in which the bus cannot move it; empty where it is not."""
        if Ability.READ_SETTINGS not in self.able:
            return ""
        found = yield from self.read(ReadSetting(Code.MODE), (node,))
        heard = found.get(node)
        read = heard.answer if isinstance(heard, Answered) else None
        try:
            mode = as_setting(read) if isinstance(read, SettingRead) else None
        except RemoteProtocolError:
            return ""
        if not isinstance(mode, SetMode) or mode.mode.on_bus:
            return ""
        return (
            f"{self.drive(node)} is in mode {int(mode.mode)} ({mode.mode.name}), in which the bus "
            f"moves nothing: set mode {int(Mode.BUS_FOC)} (Menu > Mode > SR_vFOC, or `armdrive "
            "doctor --mend`)"
        )


# Taking MKS drives for standing where they are, with none that pushes towards anywhere else.

EASED_S = 1.5
"""A drive that was sent to where its shaft is stands there long before."""

Hindrance = Generator[float, Event | None, Timeout | RequestRejected | None]


class MksStartupCheck(MksStopping):
    """Knows where drives stand, before they are moved."""

    def take_up(self) -> Hindrance:
        """Take every drive for standing where it is."""
        began_s = self.now_s
        if missing := (yield from self.look()):
            return self.absence(missing, began_s)
        for drive in self.drives:
            self._host.settle(drive.node)
            if drive.moving or drive.count(self.settings.rest_counts) != drive.target:
                drive.rest_at(drive.seen or 0, self.now_s)
        return None

    def take_up_at_rest(self) -> Hindrance:
        """Take drives for standing where they are, and have none push towards anywhere else.

        One may have been blocked as its last program, or its cable, was lost: nobody eased it then,
        and it would spring to its set-point whenever it comes free.
        """
        hindrance = yield from self.take_up()
        if hindrance is not None:
            return hindrance
        pushing = yield from self.ease(self.nodes)
        if not pushing:
            return None
        yield from self.eased(pushing, self.now_s + EASED_S)
        for node, off in pushing.items():
            if why := (yield from self.mode_words(node)):  # it does not hear, and pushes on
                return RequestRejected(why, moved=False)
            self.tell(ProtocolWarning(self.pressing_words(self.drive(node), off)))
        return (yield from self.take_up())
