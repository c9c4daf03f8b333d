"""What is wrong with an MKS drive that does not do what it was told: it is asked, and named."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TypeAlias

from armdrive.dialects.bus.observer import Finding, ObservedDrive, Verdict
from armdrive.dialects.mks.stops import restarted_words
from armdrive.dialects.mks.wire import Asking, MksWire
from armdrive.tasks import Alert, AlertKind
from firmware_protocol.mks import (
    Ability,
    Code,
    EnabledRead,
    Mode,
    MotorState,
    ReadEnabled,
    ReadStall,
    ReadState,
    SetMode,
    StallRead,
    StateRead,
)

Words: TypeAlias = Asking[str]


class MksInquiry:
    """Asks drives what keeps them from moving."""

    def __init__(self, wire: MksWire) -> None:
        self._wire = wire

    def states(self, nodes: Collection[int] | None = None) -> Asking[Mapping[int, MotorState]]:
        """Ask drives what they do."""
        found = yield from self._wire.read(ReadState(), nodes)
        return {node: told.state for node, told in found.items() if isinstance(told, StateRead)}

    def stalled(self, nodes: Collection[int]) -> Asking[list[int]]:
        """Return those of some drives whose protection has let the shaft go."""
        found = yield from self._wire.read(ReadStall(), nodes)
        return [node for node, told in found.items() if told == StallRead(on=True)]

    def off(self, nodes: Collection[int]) -> Asking[list[int]]:
        """Return those of some drives whose motors have no current."""
        found = yield from self._wire.read(ReadEnabled(), nodes)
        return [node for node, told in found.items() if told == EnabledRead(on=False)]

    def stall_words(self, node: int) -> str:
        """Say that a drive's protection has acted."""
        return (
            f"{self._wire.drive(node)} has stalled, and its protection has let the shaft go: look "
            "what blocked it, or give it more current or less speed"
        )

    def mode_words(self, node: int) -> Words:
        """Say that a drive is in a mode in which the bus cannot move it; empty where it is not."""
        if not self._wire.can(Ability.READ_SETTINGS):
            return ""
        mode = yield from self._wire.setting(node, Code.MODE)
        if not isinstance(mode, SetMode) or mode.mode.on_bus:
            return ""
        return (
            f"{self._wire.drive(node)} is in mode {int(mode.mode)} ({mode.mode.name}), in which "
            f"the bus moves nothing: set mode {int(Mode.BUS_FOC)} (Menu > Mode > SR_vFOC, or "
            "`armdrive doctor --mend`)"
        )

    def hindered(self, node: int) -> Asking[Alert | None]:
        """Find what keeps a drive from moving: a stall, no current, or a mode; None for nothing."""
        if (yield from self.stalled((node,))):
            return Alert(AlertKind.SWITCHED_OFF, self.stall_words(node))
        if (yield from self.off((node,))):
            words = f"{self._wire.drive(node)} has switched its motor off"
            return Alert(AlertKind.SWITCHED_OFF, words)
        mode = yield from self.mode_words(node)
        return Alert(AlertKind.ASTRAY, mode) if mode else None

    def explain(self, verdict: Verdict) -> Asking[Alert]:
        """Find out why a drive is where it should not be, and what that means for the arm."""
        drive = self._wire.drive(verdict.node)
        if verdict.finding is Finding.RESTARTED:
            stalled = yield from self.stalled((drive.node,))
            if not stalled:
                return Alert(AlertKind.RESTARTED, restarted_words(drive))
        hindered = yield from self.hindered(drive.node)
        return hindered or Alert(AlertKind.ASTRAY, _off_words(drive, verdict))

    def found_at_rest(self, drive: ObservedDrive) -> Asking[Alert]:
        """Find out why a drive that was not sent anywhere is elsewhere."""
        now_s, count = self._wire.now_s, drive.count or 0
        anew = drive.counts_from_zero(now_s, now_s)
        finding = Finding.RESTARTED if anew else Finding.ELSEWHERE
        verdict = Verdict(drive.node, finding, count, drive.goal)
        return (yield from self.explain(verdict))


def _off_words(drive: ObservedDrive, verdict: Verdict) -> str:
    if verdict.finding in (Finding.OFF_WAY, Finding.WEAK):
        return (
            f"{drive} is {verdict.off:.0f} counts beside its way, which the others keep: it is "
            "overloaded, or its supply is too weak for its speed"
        )
    return (
        f"{drive} is at {verdict.count}, not at {round(verdict.place)} counts: it is blocked, "
        "overloaded, was turned by force, or was reset"
    )
