"""The end of a motion of MKS drives: that they stand at their targets, whatever they say of it.

"Done" may never come. A drive has arrived when it stands and its encoder is at its target; one
that stands elsewhere has lost its last order, which is said again, or cannot go on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Mapping

from armdrive.dialects.mks.contact import MksContact
from armdrive.dialects.mks.drive import ASKED_S, COUNTS_S_PER_RPM, MksDrive, counts_anew
from armdrive.dialects.mks.exchange import TRIES
from armdrive.dialects.mks.stops import ALL_MUTE_LOOKS, MUTE_LOOKS
from armdrive.tasks import Alert, AlertKind, Done, Halted, Progress, Reply, RequestRejected, Timeout
from firmware_protocol.mks import SPEED_MAX_RPM, TARGET_MAX, Event, MotorState

# What keeps an MKS drive from taking its orders while others go on: it is found, and named.
#
# Motors can be coupled: where one of a wrist's two stands, the other turns a joint that nobody
# meant to turn, beyond its limit perhaps. So a denial is not waited out, till the drive is far
# behind.


class MksRejecting(MksContact):
    """Says an order that was denied again, and looks into a drive that denies that too."""

    ahead_s = math.inf
    """How far ahead drives are sent; in a burst, as far as their speeds take them."""

    @property
    def denial_s(self) -> float:
        """When a drive is to be spoken to next, because it denies what it was told."""
        return min(drive.denials.due_s for drive in self.drives)

    def say_again(self) -> Generator[float, Event | None, tuple[int, Alert] | None]:
        """Give drives that deny it their order again; return who takes none and why, if it does.

        An order may be said twice: it is absolute.
        """
        for drive in self.drives:
            if self.now_s < drive.denials.due_s:
                continue
            if not drive.denials.confirm():
                self.repeat(drive)
            elif (alert := (yield from self.hindered(drive.node))) is not None:
                return drive.node, alert
        return None

    def repeat(self, drive: MksDrive) -> None:
        """Say a drive's last order again, if it is sent anywhere."""
        if drive.moving:
            rpm = max(1, round(drive.told / COUNTS_S_PER_RPM), self.least_rpm(drive, drive.target))
            self.send(drive.node, drive.target, rpm, drive.acc)

    def least_rpm(self, drive: MksDrive, target: int) -> int:
        """Return the speed by which a drive that was seen behind is at a target when announced."""
        if abs(drive.behind) <= self.settings.rest_counts:
            return 0
        return min(drive.rpm_within(target, self.ahead_s), SPEED_MAX_RPM)

    def hindered(self, node: int) -> Generator[float, Event | None, Alert | None]:
        """Find what keeps a drive from moving: a stall, no current, or a mode; None for nothing."""
        if (yield from self.stalled((node,))) or (yield from self.off((node,))):
            return (yield from self.found_at(node))
        words = yield from self.mode_words(node)
        return Alert(AlertKind.ASTRAY, words) if words else None


ARRIVE_POLL_S = 0.015
"""How often drives that should arrive are looked at."""
PATIENCE_S = 1.0
SILENT_S = 0.1
LATE_S = 0.1
"""A look that takes so much longer than its answers may: this computer was busy meanwhile."""
DRAIN_S = 0.03
"""What was kept on the bus has come so long after its first frame, at least."""
OWED_S = 0.3
"""So long after it, what has not been answered will not be."""
SHORT_LOOKS = 3
"""A drive that stands short of its target at so many looks will not go on by itself."""

Ending = Generator[float, Event | None, Reply]


class MksArrival(MksRejecting):
    """Sees to it that drives get where they were sent."""

    def arrive(self, expected_s: float, let_go: Callable[[], bool]) -> Ending:
        """Wait until every drive that was sent somewhere stands there."""
        began_s = seen_s = self.now_s
        given_up_s = began_s + 2.0 * expected_s + self.ramp_s + PATIENCE_S
        short: dict[int, int] = {}
        mute: dict[int, int] = {}
        quiet: tuple[float, Mapping[int, int]] | None = None
        while left := self.under_way:
            if self.stop_asked or let_go():
                return (yield from self.halted())
            asked_s = self.now_s
            states = yield from self._look_at(left, mute)
            if self.stop_asked:
                continue  # after a suspension the look is an old one, and no drive is to blame
            if self.answered_last_s < asked_s:
                quiet = quiet or (asked_s, {each.node: each.gap.owed for each in self.drives})
            elif quiet is not None:
                yield from self.weigh_silence(*quiet)
                quiet = None
                continue  # where they are now says whether they began anew
            for node in left:
                if self.drive(node).seen_s < asked_s:
                    continue
                if self.began_anew(node):
                    return (yield from self.break_off(node))
                self._weigh(node, states.get(node), short)
            if (denied := (yield from self.say_again())) is not None and not self.stop_asked:
                return (yield from self.break_off(*denied))
            most = MUTE_LOOKS if any(not mute.get(node) for node in left) else ALL_MUTE_LOOKS
            if any(count >= most for count in mute.values()):
                return (yield from self.lose(began_s))
            stuck = [node for node in self.under_way if short.get(node, 0) >= SHORT_LOOKS * TRIES]
            if self.now_s > seen_s + 2.0 * self.settings.answer_s + LATE_S:
                given_up_s += self.now_s - seen_s  # no drive is to blame for that
            seen_s = self.now_s
            overdue = self.under_way if self.now_s >= given_up_s else ()
            if stuck or overdue:
                return (yield from self.break_off((*stuck, *overdue)[0]))
            yield from self.pause(asked_s + ARRIVE_POLL_S)
        return Done()

    def weigh_silence(
        self, quiet_s: float, owed: Mapping[int, int]
    ) -> Generator[float, Event | None, None]:
        """Doubt those that never answer what they were told since nobody was heard.

        They had no power, perhaps. `owed` says how many answers of each were outstanding before.
        Late ones are waited for: one that is of a moment ago would be taken for one of now.
        """
        until_s = self.now_s + OWED_S
        yield from self.pause(self.now_s + DRAIN_S)
        while self._owing(owed) and self.now_s < until_s and not self.stop_asked:
            yield from self.pause(self.now_s + DRAIN_S)
        owing = self._owing(owed)
        for drive in self.drives:
            drive.gap.forget()
            if drive.node in owing:
                drive.gap.doubted_s = quiet_s

    def _owing(self, owed: Mapping[int, int]) -> tuple[int, ...]:
        """Return those that have left unanswered what they were told since."""
        return tuple(each.node for each in self.drives if each.gap.outstanding > owed[each.node])

    @property
    def answered_last_s(self) -> float:
        """When any drive answered something last."""
        return max(drive.answered_s for drive in self.drives)

    @property
    def under_way(self) -> tuple[int, ...]:
        """The ids of the drives that were sent somewhere and not seen to stand since."""
        return tuple(drive.node for drive in self.drives if drive.moving)

    def _look_at(
        self, nodes: Collection[int], mute: dict[int, int]
    ) -> Generator[float, Event | None, Mapping[int, MotorState]]:
        """Read positions and states once; a drive that tells neither is noted.

        One that is under way alone has another one to be its witness: that the bus works.
        """
        witness = tuple(node for node in self.nodes if node not in nodes)[: len(nodes) == 1]
        missing = yield from self.look_once((*nodes, *witness))
        states = yield from self.states_once(nodes)
        for node in nodes:
            mute[node] = mute.get(node, 0) + 1 if node in missing else 0
        self.tell(Progress(self.registers()))
        return states

    def began_anew(self, node: int) -> bool:
        """Tell whether a drive began anew: it leapt, or was gone, or counts far off its way.

        One whose count denies that it did is believed.
        """
        drive = self.drive(node)
        if drive.leap.leapt:
            return True
        far = not drive.passes(drive.seen or 0, self.settings.corridor_counts)
        gone = math.isfinite(drive.gap.doubted_s)
        if (far or gone) and counts_anew(drive, self.reach, self.now_s):
            return True
        drive.gap.doubted_s = math.inf
        return False

    def is_near(self, node: int) -> bool:
        """Tell whether a drive was seen at its target."""
        drive = self.drive(node)
        return drive.seen is not None and abs(drive.seen - drive.target) <= self.reach

    @property
    def reach(self) -> int:
        """How far from its target a drive stands that has arrived."""
        return self.settings.rest_counts

    def _weigh(self, node: int, state: MotorState | None, short: dict[int, int]) -> None:
        drive = self.drive(node)
        if state is not MotorState.STOPPED or drive.gap.pending:
            return  # perhaps it counts from elsewhere now
        if self.is_near(node):
            self._host.settle(node)
            drive.rest_at(drive.target, self.now_s)
            return
        short[node] = short.get(node, 0) + 1
        on_its_way = drive.passes(drive.seen or 0, self.settings.corridor_counts)
        if short[node] % SHORT_LOOKS == 0 and on_its_way:  # its order may have been lost
            self.repeat(drive)

    # -- what ends it early -------------------------------------------------------------------

    def halted(self) -> Ending:
        """End a motion that somebody stopped, or a jog that was let go of."""
        nodes = self.under_way
        if not nodes:
            return Halted()
        return (yield from self.halt(nodes, hard=self.stop_hard)) or Halted()

    def lose(self, since_s: float) -> Ending:
        """End a motion in which drives fell silent; the others are stopped."""
        nodes = self.under_way
        asked_s = min(each.gap.since_s for each in self.drives)
        all_silent = self.answered_last_s <= asked_s + ASKED_S and math.isfinite(asked_s)
        silent = [each for each in self.drives if each.heard_s < self.now_s - SILENT_S]
        self._say_stop(nodes, hard=False)  # those that are silent may hear us still
        missing = yield from self.look()
        back = [each for each in silent if each.node not in missing]
        astray = [each for each in back if self._is_astray(each, all_silent)]
        if astray and not missing:  # it was reset, most likely
            return (yield from self.break_off(astray[0].node))
        answering = [node for node in nodes if node not in missing]
        yield from self.settled(answering, self.now_s)
        if set(missing) == set(self.nodes):
            return self.silence(since_s)
        if missing:
            return RequestRejected(self.absent_words(missing), silent=True)
        named = ", ".join(map(str, silent)) or "a drive"
        what = f"{named} did not answer for a while"
        if all_silent:
            what = "no drive was heard for a while"
        return RequestRejected(f"{what}: look at the bus's wiring and its load", silent=True)

    def _is_astray(self, drive: MksDrive, all_silent: bool) -> bool:
        """Tell whether a drive that was silent is elsewhere; where all were, orders have waited."""
        if all_silent:
            return counts_anew(drive, self.reach, self.now_s)
        return drive.off_by(drive.seen or 0, self.now_s) > self.reach

    def break_off(self, node: int, alert: Alert | None = None) -> Ending:
        """End a motion that a drive does not make; say what is wrong with it."""
        nodes = self.under_way
        self._say_stop(nodes, hard=False)
        if alert is None:
            alert = yield from self.found_at(node)
        self.tell(alert)
        unstopped = yield from self.settled(nodes, self.now_s)
        if isinstance(unstopped, Timeout):
            return unstopped
        return RequestRejected(alert.text)

    def beyond(self, target: int, node: int) -> RequestRejected | None:
        """Refuse a target that a drive cannot be given."""
        if abs(target) <= TARGET_MAX:
            return None
        return RequestRejected(
            f"{self.drive(node)} would turn to {target} counts, beyond the 512 turns that can be "
            "commanded: bring it near its zero and set that anew (`armdrive can setup`)",
            moved=False,
        )
