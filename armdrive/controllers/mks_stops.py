"""How MKS drives are brought to a stand-still, and how it is seen that they stand.

By a speed of zero with the drive's ramp, or at once where that was asked for. That a drive stands
is believed when its state says so and its encoder twice the same. One that pushes against something
then is eased.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Generator, Iterable
from dataclasses import replace

from armdrive.abilities import Abilities
from armdrive.controllers.mks_anew import anew_words, counts_anew
from armdrive.controllers.mks_drive import Drive
from armdrive.controllers.mks_insisting import MksInsisting, runs
from armdrive.controllers.mks_settings import MksSettings
from armdrive.controllers.requests import Alert, AlertKind, Denied, Progress, Silence
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    Ability,
    Answered,
    Code,
    Event,
    Mode,
    MotorState,
    ReadSetting,
    ReadStall,
    ReadState,
    SetMode,
    SettingRead,
    StallRead,
    StateRead,
    as_setting,
)

STOP_POLL_S = 0.02
"""How often drives that brake are looked at."""
STOP_AGAIN_S = 0.06
"""A stop without effect by then was lost."""
MUTE_LOOKS = 4
"""A drive that answers none of so many looks is mute, where another one answers."""
ALL_MUTE_LOOKS = 10
"""So many are given to drives that all are silent: then it is the computer that is late, mostly."""


class MksStopping(MksInsisting):
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
    ) -> Generator[float, Event | None, Silence | Denied | None]:
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
    ) -> Generator[float, Event | None, Silence | Denied | None]:
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

    def _began_anew(self, drive: Drive) -> bool:
        gone = math.isfinite(drive.gap.doubted_s)
        return gone and counts_anew(drive, self.settings.rest_counts, self.now_s)

    def _astray_words(self, drive: Drive) -> str:
        return (
            f"{drive} came to rest at {drive.seen} counts, off its way from "
            f"{round(drive.stopped_at)}: it was reset or lost its power, is blocked, or was turned "
            "by force"
        )

    def _unstopped(self, left: Collection[int], began_s: float) -> Silence | Denied | None:
        if not left:
            return None
        mute = [node for node in self.nodes if self._mute.get(node, 0) >= MUTE_LOOKS]
        if mute and set(mute) >= set(left):
            absence = self.absence(mute, began_s)
            if isinstance(absence, Silence):
                return absence
            return replace(absence, moved=True, silent=True)
        return Denied(f"{self.drive(min(left))} was told to stop, and does not come to rest")

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
