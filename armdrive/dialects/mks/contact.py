"""Finding the drives of an arm, learning what they can do, and switching them on. Nothing moves."""

from __future__ import annotations

from collections.abc import Callable, Collection

from armdrive.dialects.mks.inquiry import MksInquiry, Words, firmware_of, shared_words
from armdrive.dialects.mks.stops import MksStops, pressing_words
from armdrive.dialects.mks.wire import TRIES, Asking, Hindrance, MksWire, Script, meant
from armdrive.tasks import Done, ProtocolWarning, RequestRejected
from firmware_protocol.mks import (
    LATEST,
    Ability,
    ArmSynchronous,
    ClearStall,
    Code,
    Enable,
    MotorState,
    ReadSetting,
    ReplyMode,
    SetReplies,
    SettingRead,
    SilenceWatchdog,
    abilities_of,
)
from firmware_protocol.mks import Done as Taken
from firmware_protocol.mks import Request as Message

REPLIES_OFF = (
    "answers questions, but no orders: its replies are off. Set them to full (`armdrive doctor "
    "--mend`, or code 8C with 01 01)"
)
NO_SUCH_ORDER = "it may be in a mode in which the bus moves nothing: set SR_vFOC (Menu > Mode)"
CALM_S = 1.0
"""A motion that a program before this one left behind is waited for so long."""
BUSY = (MotorState.HOMING, MotorState.CALIBRATING)
TURNING = (MotorState.ACCELERATING, MotorState.DECELERATING, MotorState.FULL_SPEED)


class MksContact:
    """The way to drives that stand, hear and hold."""

    def __init__(
        self, wire: MksWire, stops: MksStops, inquiry: MksInquiry, learnt: Callable[[], None]
    ) -> None:
        self._wire, self._stops, self._inquiry = wire, stops, inquiry
        self._learnt = learnt
        self.made = False
        """Whether all drives were found, and stand."""
        self.on = False
        """Whether all were switched on."""
        self.watched = False
        """Whether every drive is known to stop when the bus is silent."""
        self.firmware = ""

    def make(self) -> Hindrance:
        """Find every drive and wait until all stand; return what stands against it."""
        wire = self._wire
        began_s, wire.said = wire.now_s, "READ ENCODER"
        wire.surplus.clear()
        for _ in range(TRIES):
            if missing := (yield from wire.look()):
                return (yield from self._absent_or_shared(missing, began_s))
        yield from wire.pause(wire.now_s + wire.settings.answer_s)  # the answers of a second drive
        if words := shared_words(wire.surplus.shared):
            return RequestRejected(words, moved=False)
        yield from self._recognise()
        hindrance = yield from self._calm_down()
        if hindrance is None:
            hindrance = yield from self.take_up()
        if hindrance is None:
            for drive in wire.drives:
                drive.rest_at(drive.count or 0, wire.now_s)
                drive.fresh = True
        self.made = hindrance is None
        return hindrance

    def _absent_or_shared(self, missing: Collection[int], since_s: float) -> Hindrance:
        """Say that drives do not answer: perhaps because they have the ids of others."""
        wire = self._wire
        absence = wire.absence(missing, since_s)
        if not isinstance(absence, RequestRejected):
            return absence
        there = [node for node in wire.nodes if node not in missing]
        for _ in range(TRIES):
            yield from wire.look(there)
        yield from wire.pause(wire.now_s + wire.settings.answer_s)
        shared = shared_words(wire.surplus.shared)
        return (
            RequestRejected(f"{absence.reason}. And {shared}", moved=False) if shared else absence
        )

    def _recognise(self) -> Asking[None]:
        """Learn what the drives can do: what the oldest firmware among them can."""
        wire = self._wire
        version = wire.settings.version
        if version is None:
            found = yield from firmware_of(wire, wire.nodes)
            version = min(LATEST, *(each.version for each in found.values()))
        self.firmware = ".".join(map(str, version))
        wire.able = abilities_of(version)
        self._learnt()

    def _calm_down(self) -> Hindrance:
        """Wait for the end of what an earlier program left in motion, then end it."""
        wire = self._wire
        end_s = wire.now_s + CALM_S
        while True:
            states = yield from self._inquiry.states()
            busy = [node for node, state in states.items() if state in BUSY]
            if busy:
                what = "homing or calibrating" if len(busy) == 1 else "at work"
                return RequestRejected(
                    f"{wire.drive(busy[0])} is {what}: wait for its end", moved=False
                )
            turning = [node for node, state in states.items() if state in TURNING]
            if not turning:
                return None
            if wire.now_s >= end_s:
                return (yield from self._stops.halt(turning))
            yield from wire.pause(wire.now_s + wire.settings.poll_s)

    # -- where they stand ---------------------------------------------------------------------

    def take_up(self) -> Hindrance:
        """Take every drive for standing where it is."""
        wire = self._wire
        began_s = wire.now_s
        if missing := (yield from wire.look()):
            return wire.absence(missing, began_s)
        for drive in wire.drives:
            wire.host.settle(drive.node)
            if drive.moving or drive.register != drive.goal:
                drive.rest_at(drive.count or 0, wire.now_s)
        return None

    def _take_up_at_rest(self) -> Hindrance:
        """Take drives for standing where they are, and have none push towards anywhere else.

        One may have been blocked as its last program, or its cable, was lost: nobody eased it then,
        and it would spring to its set-point whenever it comes free.
        """
        hindrance = yield from self.take_up()
        if hindrance is not None:
            return hindrance
        pushing = yield from self._stops.ease(self._wire.nodes)
        if not pushing:
            return None
        yield from self._stops.eased(pushing)
        for node, off in pushing.items():
            if why := (yield from self._inquiry.mode_words(node)):  # it does not hear, and pushes
                return RequestRejected(why, moved=False)
            self._wire.tell(ProtocolWarning(pressing_words(self._wire.drive(node), off)))
        return (yield from self.take_up())

    # -- current ------------------------------------------------------------------------------

    def switch_on(self) -> Script:
        """Have every drive hold its motor where it is, and guard against a silent bus."""
        self.on = False
        wire, inquiry = self._wire, self._inquiry
        if hindrance := (yield from self.take_up()):
            return hindrance
        if stalled := (yield from inquiry.stalled(wire.nodes)):
            return RequestRejected(
                f"{inquiry.stall_words(stalled[0])}; `reset()` clears that", moved=False
            )
        if unfit := (yield from self._unfit_words()):
            return RequestRejected(unfit, moved=False)
        if wire.can(Ability.SYNCHRONOUS_START):
            yield from wire.ask(dict.fromkeys(wire.nodes, ArmSynchronous(on=False)))
        refused = yield from self._command(Enable(on=True), "ENABLE")
        if refused is not None:
            return refused
        if off := (yield from inquiry.off(wire.nodes)):
            return RequestRejected(
                f"{wire.drive(off[0])} does not switch its motor on", moved=False
            )
        self.watched = yield from self._watch()
        self.on = True
        return (yield from self._take_up_at_rest()) or Done()

    def switch_off(self) -> Script:
        """Have every drive let its motor go."""
        self.on = False
        return (yield from self._command(Enable(on=False), "DISABLE")) or Done()

    def _watch(self) -> Asking[bool]:
        """Switch the drives' silence watchdog on; tell whether it is on for certain in all."""
        wire = self._wire
        timeout = SilenceWatchdog(round(wire.settings.watchdog_s * 1000.0))
        if not timeout.timeout_ms or not wire.can(Ability.SILENCE_WATCHDOG):
            return False
        found = yield from wire.ask(dict.fromkeys(wire.nodes, timeout), text="WATCHDOG")
        if not all(isinstance(found.get(node), Taken) for node in wire.nodes):
            return False
        fits = [SettingRead(timeout.code, value) for value in (None, timeout.payload)]
        for _ in range(TRIES):  # a late answer to the setting looks like its value
            told = yield from wire.read(ReadSetting(timeout.code))
            if all(told.get(node) in (None, *fits) for node in wire.nodes):
                return True
        return False

    def _command(self, message: Message, text: str) -> Hindrance:
        """Have every drive do something that may be said twice; return why one did not."""
        wire = self._wire
        began_s = wire.now_s
        found = yield from wire.ask(dict.fromkeys(wire.nodes, message), text=text)
        if missing := [node for node in wire.nodes if node not in found]:
            unheard = yield from self._unheard_words(missing)
            return (
                RequestRejected(unheard, moved=False) if unheard else wire.absence(missing, began_s)
            )
        for node, heard in found.items():
            if not isinstance(heard, Taken):
                why = yield from self._inquiry.mode_words(node)
                refused = f"{wire.drive(node)} refused {text}: {NO_SUCH_ORDER}"
                return RequestRejected(why or refused, moved=False)
        return None

    # -- how they are set up ------------------------------------------------------------------
    #
    # Modes and replies are asked for before any is switched on: else some would hold, others not.

    def _unfit_words(self) -> Words:
        """Say which drive is set up so that it would not be switched on; empty where none is."""
        for node in self._wire.nodes:
            if words := (yield from self._inquiry.mode_words(node)):
                return words
        return (yield from self._mute_words(self._wire.nodes))

    def _unheard_words(self, missing: Collection[int]) -> Words:
        """Say why drives did not answer an order; empty where they answer nothing else either."""
        if words := (yield from self._mute_words(missing)):
            return words
        silent = yield from self._wire.look(missing)
        heard = [node for node in missing if node not in silent]
        return f"{self._wire.drive(heard[0])} {REPLIES_OFF}" if heard and not silent else ""

    def _mute_words(self, nodes: Collection[int]) -> Words:
        if not self._wire.can(Ability.READ_SETTINGS):
            return ""
        found = yield from self._wire.read(ReadSetting(Code.REPLIES), nodes)
        none = SetReplies(ReplyMode.NONE)
        off = [node for node, told in found.items() if meant(told) == none]
        return f"{self._wire.drive(off[0])} {REPLIES_OFF}" if off else ""

    # -- faults -------------------------------------------------------------------------------

    def clear(self) -> Script:
        """Clear stalls; the drives stand, and hold or not as they did. Moves nothing."""
        inquiry = self._inquiry
        hindrance = yield from self._calm_down()
        if hindrance is not None:
            return hindrance
        stalled = yield from inquiry.stalled(self._wire.nodes)
        if stalled:
            yield from self._wire.ask(dict.fromkeys(stalled, ClearStall()), text="CLEAR STALL")
            if left := (yield from inquiry.stalled(stalled)):
                return RequestRejected(
                    f"{inquiry.stall_words(left[0])}, and does not clear it", moved=False
                )
        rest = self._take_up_at_rest if self.on else self.take_up
        return (yield from rest()) or Done()
