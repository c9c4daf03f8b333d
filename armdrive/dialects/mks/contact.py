"""Finding the drives of an arm, learning what they can do, and switching them on. Nothing moves."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping

from armdrive.dialects.mks.drive import anew_words, counts_anew
from armdrive.dialects.mks.exchange import TRIES, Script
from armdrive.dialects.mks.stops import Hindrance, MksStartupCheck
from armdrive.tasks import Alert, AlertKind, Done, RequestRejected
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    LATEST,
    Ability,
    Answered,
    ArmSynchronous,
    ClearStall,
    Code,
    Enable,
    EnabledRead,
    Event,
    MotorState,
    ReadEnabled,
    ReadSetting,
    ReadState,
    ReadVersion,
    ReplyMode,
    SetReplies,
    SettingRead,
    SilenceWatchdog,
    StateRead,
    VersionRead,
    abilities_of,
    as_setting,
)
from firmware_protocol.mks import Done as Taken
from firmware_protocol.mks import Request as Message

# Whether MKS drives can be driven as they are set up: their ids, a mode, and their replies.
#
# The last two are asked for before any is switched on: else some would hold, and others not.

REPLIES_OFF = (
    "answers questions, but no orders: its replies are off. Set them to full (`armdrive doctor "
    "--mend`, or code 8C with 01 01)"
)
NO_SUCH_ORDER = "it may be in a mode in which the bus moves nothing: set SR_vFOC (Menu > Mode)"

Words = Generator[float, Event | None, str]


class MksFit(MksStartupCheck):
    """Knows why a drive would not obey."""

    def absent_or_shared(self, missing: Collection[int], since_s: float) -> Hindrance:
        """Say that drives do not answer: perhaps because they have the ids of others."""
        absence = self.absence(missing, since_s)
        if not isinstance(absence, RequestRejected):
            return absence
        there = [node for node in self.nodes if node not in missing]
        for _ in range(TRIES):
            yield from self.look(there)
        yield from self.pause(self.now_s + self.settings.answer_s)
        shared = self.shared_words()
        return (
            RequestRejected(f"{absence.reason}. And {shared}", moved=False) if shared else absence
        )

    def unfit_words(self) -> Words:
        """Say which drive is set up so that it would not be switched on; empty where none is."""
        for node in self.nodes:
            if words := (yield from self.mode_words(node)):
                return words
        return (yield from self._mute_words(self.nodes))

    def unheard_words(self, missing: Collection[int]) -> Words:
        """Say why drives did not answer an order; empty where they answer nothing else either."""
        if words := (yield from self._mute_words(missing)):
            return words
        silent = yield from self.look(missing)
        heard = [node for node in missing if node not in silent]
        return f"{self.drive(heard[0])} {REPLIES_OFF}" if heard and not silent else ""

    def _mute_words(self, nodes: Collection[int]) -> Words:
        if Ability.READ_SETTINGS not in self.able:
            return ""
        found = yield from self.read(ReadSetting(Code.REPLIES), nodes)
        off = [node for node, heard in found.items() if _replies(heard) is ReplyMode.NONE]
        return f"{self.drive(off[0])} {REPLIES_OFF}" if off else ""


def _replies(heard: Event) -> ReplyMode | None:
    """Return how a drive replies; None where it did not tell."""
    if not isinstance(heard, Answered) or not isinstance(heard.answer, SettingRead):
        return None
    try:
        setting = as_setting(heard.answer)
    except RemoteProtocolError:  # a value that no table has
        return None
    return setting.mode if isinstance(setting, SetReplies) else None


CALM_S = 1.0
"""A motion that a program before this one left behind is waited for so long."""
BUSY = (MotorState.HOMING, MotorState.CALIBRATING)
TURNING = (MotorState.ACCELERATING, MotorState.DECELERATING, MotorState.FULL_SPEED)
UNTOLD = (1, 0, 4)
"""What is taken for the firmware of a drive that tells neither its version nor a setting."""


class MksContact(MksFit):
    """The way to drives that stand, hear and hold."""

    contacted = False
    on = False
    watched = False
    """Whether every drive is known to stop when the bus is silent."""

    def contact(self) -> Hindrance:
        """Find every drive and wait until all stand; return what stands against it."""
        began_s, self.last_said = self.now_s, "READ ENCODER"
        self.extra.clear()
        for _ in range(TRIES):
            if missing := (yield from self.look()):
                return (yield from self.absent_or_shared(missing, began_s))
        yield from self.pause(self.now_s + self.settings.answer_s)  # the answers of a second drive
        if words := self.shared_words():
            return RequestRejected(words, moved=False)
        yield from self._recognise()
        hindrance = yield from self._calm_down()
        if hindrance is None:
            hindrance = yield from self.take_up()
        if hindrance is None:
            for drive in self.drives:
                drive.rest_at(drive.seen or 0, self.now_s)
                drive.fresh = True
        self.contacted = hindrance is None
        return hindrance

    def _recognise(self) -> Generator[float, Event | None, None]:
        """Learn what the drives can do: what the oldest firmware among them can."""
        version = self.settings.version
        if version is None:
            told = yield from self.ask(dict.fromkeys(self.nodes, ReadVersion()))
            version = LATEST
            for node in self.nodes:
                its = yield from self._version(node, told.get(node))
                version = min(version, its)
        self.firmware = ".".join(map(str, version))
        self.able = abilities_of(version)
        self.choose()

    def _version(
        self, node: int, heard: Event | None
    ) -> Generator[float, Event | None, tuple[int, int, int]]:
        """Return a drive's firmware, by what it tells of it or at least by what it answers."""
        if isinstance(heard, Answered) and isinstance(heard.answer, VersionRead):
            if heard.answer.version is not None:
                return heard.answer.version
            found = yield from self.ask({node: ReadSetting(Code.WATCHDOG)})
            return (1, 0, 9) if _setting(found.get(node)) is not None else (1, 0, 8)
        found = yield from self.ask({node: ReadSetting(Code.MODE)})
        return (1, 0, 6) if node in found else UNTOLD

    def _calm_down(self) -> Hindrance:
        """Wait for the end of what an earlier program left in motion, then end it."""
        end_s = self.now_s + CALM_S
        while True:
            states = yield from self.states()
            busy = [node for node, state in states.items() if state in BUSY]
            if busy:
                what = "homing or calibrating" if len(busy) == 1 else "at work"
                return RequestRejected(
                    f"{self.drive(busy[0])} is {what}: wait for its end", moved=False
                )
            turning = [node for node, state in states.items() if state in TURNING]
            if not turning:
                return None
            if self.now_s >= end_s:
                stood = yield from self.halt(turning)
                return None if stood is None else stood
            yield from self.pause(self.now_s + self.settings.poll_s)

    def states(
        self, nodes: Collection[int] | None = None
    ) -> Generator[float, Event | None, Mapping[int, MotorState]]:
        """Ask drives what they do."""
        return _states((yield from self.read(ReadState(), nodes)))

    def states_once(
        self, nodes: Collection[int]
    ) -> Generator[float, Event | None, Mapping[int, MotorState]]:
        """Ask drives once what they do."""
        return _states((yield from self.ask(dict.fromkeys(nodes, ReadState()), tries=1)))

    # -- what is wrong ------------------------------------------------------------------------

    def off(self, nodes: Collection[int]) -> Generator[float, Event | None, list[int]]:
        """Return those of some drives whose motors have no current."""
        found = yield from self.read(ReadEnabled(), nodes)
        return [
            node
            for node, heard in found.items()
            if isinstance(heard, Answered) and heard.answer == EnabledRead(on=False)
        ]

    def found_at(self, node: int) -> Generator[float, Event | None, Alert]:
        """Find out why a drive is not where it should be, and what that means for the arm."""
        drive = self.drive(node)
        if (yield from self.stalled((node,))):
            return Alert(AlertKind.SWITCHED_OFF, self.stall_words(node))
        where = f"at {drive.seen or 0}, not at {round(drive.position)} counts"
        if counts_anew(drive, self.settings.rest_counts, self.now_s):
            return Alert(AlertKind.RESTARTED, anew_words(drive))
        if self.on and (yield from self.off((node,))):
            return Alert(AlertKind.SWITCHED_OFF, f"{drive} has switched its motor off, {where}")
        mode = yield from self.mode_words(node)
        astray = f"{drive} is {where}: it is blocked, overloaded, was turned by force, or was reset"
        return Alert(AlertKind.ASTRAY, mode or astray)

    # -- current ------------------------------------------------------------------------------

    def switch_on(self) -> Script:
        """Have every drive hold its motor where it is, and guard against a silent bus."""
        self.on = False
        if hindrance := (yield from self.take_up()):
            return hindrance
        if stalled := (yield from self.stalled(self.nodes)):
            return RequestRejected(
                f"{self.stall_words(stalled[0])}; `reset()` clears that", moved=False
            )
        if unfit := (yield from self.unfit_words()):
            return RequestRejected(unfit, moved=False)
        if Ability.SYNCHRONOUS_START in self.able:
            yield from self.ask(dict.fromkeys(self.nodes, ArmSynchronous(on=False)))
        refused = yield from self.command(Enable(on=True), "ENABLE")
        if refused is not None:
            return refused
        if off := (yield from self.off(self.nodes)):
            return RequestRejected(
                f"{self.drive(off[0])} does not switch its motor on", moved=False
            )
        self.watched = yield from self._watch()
        self.on = True
        return (yield from self.take_up_at_rest()) or Done()

    def switch_off(self) -> Script:
        """Have every drive let its motor go."""
        self.on = False
        return (yield from self.command(Enable(on=False), "DISABLE")) or Done()

    def _watch(self) -> Generator[float, Event | None, bool]:
        """Switch the drives' silence watchdog on; tell whether it is on for certain in all."""
        timeout = SilenceWatchdog(round(self.settings.watchdog_s * 1000.0))
        if not timeout.timeout_ms or Ability.SILENCE_WATCHDOG not in self.able:
            return False
        found = yield from self.ask(dict.fromkeys(self.nodes, timeout), text="WATCHDOG")
        if not all(isinstance(found.get(node), Taken) for node in self.nodes):
            return False
        for _ in range(TRIES):  # a late answer to the setting looks like its value
            told = yield from self.read(ReadSetting(Code.WATCHDOG))
            if all(_setting(told.get(node)) in (None, timeout) for node in self.nodes):
                return True
        return False

    def command(self, message: Message, text: str) -> Hindrance:
        """Have every drive do something that may be said twice; return why one did not."""
        began_s = self.now_s
        found = yield from self.ask(dict.fromkeys(self.nodes, message), text=text)
        if missing := [node for node in self.nodes if node not in found]:
            unheard = yield from self.unheard_words(missing)
            return (
                RequestRejected(unheard, moved=False) if unheard else self.absence(missing, began_s)
            )
        for node, heard in found.items():
            if not isinstance(heard, Taken):
                why = yield from self.mode_words(node)
                refused = f"{self.drive(node)} refused {text}: {NO_SUCH_ORDER}"
                return RequestRejected(why or refused, moved=False)
        return None

    # -- faults -------------------------------------------------------------------------------

    def clear(self) -> Script:
        """Clear stalls; the drives stand, and hold or not as they did. Moves nothing."""
        hindrance = yield from self._calm_down()
        if hindrance is not None:
            return hindrance
        stalled = yield from self.stalled(self.nodes)
        if stalled:
            yield from self.ask(dict.fromkeys(stalled, ClearStall()), text="CLEAR STALL")
            if left := (yield from self.stalled(stalled)):
                return RequestRejected(
                    f"{self.stall_words(left[0])}, and does not clear it", moved=False
                )
        rest = self.take_up_at_rest if self.on else self.take_up
        return (yield from rest()) or Done()


def _states(found: Mapping[int, Event]) -> dict[int, MotorState]:
    return {
        node: heard.answer.state
        for node, heard in found.items()
        if isinstance(heard, Answered) and isinstance(heard.answer, StateRead)
    }


def _setting(heard: Event | None) -> object:
    """Return a setting that was read, None where it was not told; what is none as it came."""
    if not isinstance(heard, Answered) or not isinstance(heard.answer, SettingRead):
        return None
    try:
        return as_setting(heard.answer)
    except RemoteProtocolError:
        return heard.answer
