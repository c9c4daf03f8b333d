"""Whether MKS drives can be driven as they are set up: their ids, a mode, and their replies.

The last two are asked for before any is switched on: else some would hold, and others not.
"""

from __future__ import annotations

from collections.abc import Collection, Generator

from armdrive.controllers.mks_resting import Hindrance, MksResting
from armdrive.controllers.mks_talk import TRIES
from armdrive.controllers.requests import Denied
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    Ability,
    Answered,
    Code,
    Event,
    ReadSetting,
    ReplyMode,
    SetReplies,
    SettingRead,
    as_setting,
)

REPLIES_OFF = (
    "answers questions, but no orders: its replies are off. Set them to full (`armdrive doctor "
    "--mend`, or code 8C with 01 01)"
)
NO_SUCH_ORDER = "it may be in a mode in which the bus moves nothing: set SR_vFOC (Menu > Mode)"

Words = Generator[float, Event | None, str]


class MksFit(MksResting):
    """Knows why a drive would not obey."""

    def absent_or_shared(self, missing: Collection[int], since_s: float) -> Hindrance:
        """Say that drives do not answer: perhaps because they have the ids of others."""
        absence = self.absence(missing, since_s)
        if not isinstance(absence, Denied):
            return absence
        there = [node for node in self.nodes if node not in missing]
        for _ in range(TRIES):
            yield from self.look(there)
        yield from self.pause(self.now_s + self.settings.answer_s)
        shared = self.shared_words()
        return Denied(f"{absence.reason}. And {shared}", moved=False) if shared else absence

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
