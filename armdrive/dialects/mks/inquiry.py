"""What is wrong with an MKS drive that does not do what it was told: it is asked, and named."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping

from armdrive.dialects.bus.observer import Finding, ObservedDrive, Verdict
from armdrive.dialects.mks.stops import restarted_words
from armdrive.dialects.mks.wire import MksWire
from armdrive.tasks import Alert, AlertKind
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    Ability,
    Answered,
    Code,
    EnabledRead,
    Event,
    Mode,
    MotorState,
    ReadEnabled,
    ReadSetting,
    ReadStall,
    ReadState,
    SetMode,
    Setting,
    SettingRead,
    StallRead,
    StateRead,
    as_setting,
)

Words = Generator[float, Event | None, str]


class MksInquiry:
    """Asks drives what keeps them from moving."""

    def __init__(self, wire: MksWire) -> None:
        self._wire = wire

    def states(
        self, nodes: Collection[int] | None = None
    ) -> Generator[float, Event | None, Mapping[int, MotorState]]:
        """Ask drives what they do."""
        found = yield from self._wire.read(ReadState(), nodes)
        return {
            node: heard.answer.state
            for node, heard in found.items()
            if isinstance(heard, Answered) and isinstance(heard.answer, StateRead)
        }

    def stalled(self, nodes: Collection[int]) -> Generator[float, Event | None, list[int]]:
        """Return those of some drives whose protection has let the shaft go."""
        found = yield from self._wire.read(ReadStall(), nodes)
        return [
            node
            for node, heard in found.items()
            if isinstance(heard, Answered) and heard.answer == StallRead(on=True)
        ]

    def off(self, nodes: Collection[int]) -> Generator[float, Event | None, list[int]]:
        """Return those of some drives whose motors have no current."""
        found = yield from self._wire.read(ReadEnabled(), nodes)
        return [
            node
            for node, heard in found.items()
            if isinstance(heard, Answered) and heard.answer == EnabledRead(on=False)
        ]

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
        found = yield from self._wire.read(ReadSetting(Code.MODE), (node,))
        mode = setting_in(found.get(node))
        if not isinstance(mode, SetMode) or mode.mode.on_bus:
            return ""
        return (
            f"{self._wire.drive(node)} is in mode {int(mode.mode)} ({mode.mode.name}), in which "
            f"the bus moves nothing: set mode {int(Mode.BUS_FOC)} (Menu > Mode > SR_vFOC, or "
            "`armdrive doctor --mend`)"
        )

    def hindered(self, node: int) -> Generator[float, Event | None, Alert | None]:
        """Find what keeps a drive from moving: a stall, no current, or a mode; None for nothing."""
        if (yield from self.stalled((node,))):
            return Alert(AlertKind.SWITCHED_OFF, self.stall_words(node))
        if (yield from self.off((node,))):
            words = f"{self._wire.drive(node)} has switched its motor off"
            return Alert(AlertKind.SWITCHED_OFF, words)
        mode = yield from self.mode_words(node)
        return Alert(AlertKind.ASTRAY, mode) if mode else None

    def explain(self, verdict: Verdict) -> Generator[float, Event | None, Alert]:
        """Find out why a drive is where it should not be, and what that means for the arm."""
        drive = self._wire.drive(verdict.node)
        if verdict.finding is Finding.RESTARTED:
            stalled = yield from self.stalled((drive.node,))
            if not stalled:
                return Alert(AlertKind.RESTARTED, restarted_words(drive))
        hindered = yield from self.hindered(drive.node)
        return hindered or Alert(AlertKind.ASTRAY, _off_words(drive, verdict))

    def found_at_rest(self, drive: ObservedDrive) -> Generator[float, Event | None, Alert]:
        """Find out why a drive that was not sent anywhere is elsewhere."""
        now_s, count = self._wire.now_s, drive.count or 0
        anew = drive.counts_from_zero(now_s, now_s)
        finding = Finding.RESTARTED if anew else Finding.ELSEWHERE
        verdict = Verdict(drive.node, finding, count, drive.goal)
        return (yield from self.explain(verdict))


def setting_in(heard: Event | None) -> Setting | None:
    """Return a setting that was read; None where it was not told, or is none that is known."""
    read = heard.answer if isinstance(heard, Answered) else None
    try:
        return as_setting(read) if isinstance(read, SettingRead) else None
    except RemoteProtocolError:
        return None


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
