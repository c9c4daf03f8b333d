"""Asking MKS drives: one request to each of several, all at once, until all have answered.

What cannot do harm twice is asked again where its answer did not come: frames can be lost.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from typing import TypeAlias

from armdrive.dialects.mks.receive import MksReceiving
from armdrive.tasks import Registers, Reply, RequestRejected, Timeout
from firmware_protocol.mks import (
    Answered,
    Done,
    Event,
    Failed,
    Motion,
    MoveAbsoluteAxis,
    Read,
    ReadEncoder,
    ReadSetting,
    Started,
    Stop,
    StoredForStart,
)
from firmware_protocol.mks import Request as Message
from firmware_protocol.mks.expecting import answer_code
from kinematics.spaces import Motors

Script: TypeAlias = Generator[float, Event | None, Reply]
Asking: TypeAlias = Generator[float, Event | None, dict[int, Event]]

TRIES = 3
"""How often something that may be said twice is said."""
PATIENT_S = 0.25
"""How much longer than any other the last answer to that is waited for."""
SHARED = 2
"""So many more answers than questions are those of two drives; late ones are as many."""


class MksTalk(MksReceiving):
    """Asks, and waits for answers."""

    def put(self, node: int, message: Message, text: str = "") -> None:
        """Say something to a drive; what it was asked before, and would answer alike, is forgotten.

        Of motions, the same one alone: they may follow each other unanswered.
        """
        for earlier in self._host.unanswered(node):
            alike = answer_code(earlier) == answer_code(message) and not isinstance(message, Motion)
            if earlier == message or alike:
                self._give_up(node, earlier)
        self.say(self._host.send(node, message), text)
        self.said_s = self.now_s
        self._expect(node, message)
        if isinstance(message, ReadEncoder):
            self._count(node, -1)
            self.drive(node).ask(self.now_s)

    def _expect(self, node: int, message: Message) -> None:
        """Note that a drive has something to answer; of orders, if it does answer such."""
        gap = self.drive(node).gap
        if gap.obedient or not isinstance(message, Motion):
            others = (each.answered_s for each in self.drives if each.node != node)
            counts = isinstance(message, ReadEncoder | MoveAbsoluteAxis | Stop)
            gap.asked(self.now_s, max(others, default=0.0), counts=counts)

    def ask(
        self,
        messages: Mapping[int, Message],
        *,
        tries: int = TRIES,
        text: str = "",
        patient: bool = True,
    ) -> Asking:
        """Say one thing to each of some drives; return what they answered, as far as they did.

        A drive that does not answer is asked again, at once: waiting for it takes the time. Who is
        `patient` waits longer for the last answer of several: computers are busy.
        """
        found: dict[int, Event] = {}
        for left in range(tries, 0, -1):
            missing = {node: each for node, each in messages.items() if node not in found}
            if not missing:
                break
            for node, message in missing.items():
                self.put(node, message, text)
            patient_s = PATIENT_S if patient and left == 1 < tries else 0.0
            yield from self._collect(missing, found, patient_s)
            for node, message in missing.items():
                if node not in found and message in self._host.unanswered(node):
                    self._give_up(node, message)
        return found

    def _collect(
        self, wanted: Mapping[int, Message], found: dict[int, Event], patient_s: float
    ) -> Generator[float, Event | None, None]:
        until_s = self.now_s + self.settings.answer_s + patient_s
        left = set(wanted)
        while left:  # what was read late has come in time, perhaps: it is heard to its end
            heard = yield until_s
            if heard is None:
                if self.now_s >= until_s:
                    return
                continue
            node = getattr(heard, "node", None)
            answers = isinstance(heard, Answered | Done | Failed | Started | StoredForStart)
            if answers and node in left and heard.request == wanted[node]:  # type: ignore[union-attr]
                self.heed(heard)
                found[node] = heard
                left.discard(node)
            else:
                self.unasked(heard)

    def read(self, message: Read | ReadSetting, nodes: Collection[int] | None = None) -> Asking:
        """Ask the same of some drives, or of all."""
        return self.ask(dict.fromkeys(self.nodes if nodes is None else nodes, message))

    def look_once(self, nodes: Collection[int]) -> Generator[float, Event | None, tuple[int, ...]]:
        """Read where drives are, once; return the ids of those that did not tell."""
        found = yield from self.ask(dict.fromkeys(nodes, ReadEncoder()), tries=1)
        return tuple(node for node in nodes if node not in found)

    def look(
        self, nodes: Collection[int] | None = None, *, patient: bool = True
    ) -> Generator[float, Event | None, tuple[int, ...]]:
        """Read where drives are; return the ids of those that did not tell."""
        asked = self.nodes if nodes is None else tuple(nodes)
        found = yield from self.ask(dict.fromkeys(asked, ReadEncoder()), patient=patient)
        return tuple(node for node in asked if node not in found)

    # -- words --------------------------------------------------------------------------------

    def registers(self) -> Registers:
        """Return where the drives were seen last, by their encoders.

        One that stands within reach of where it was sent is there: an encoder trembles.
        """
        return Registers(Motors(drive.count(self.settings.rest_counts) for drive in self.drives))

    def absence(self, missing: Collection[int], since_s: float) -> Timeout | RequestRejected:
        """Say that drives do not answer; silence where it is all of them."""
        if set(missing) == set(self.nodes):
            return self.silence(since_s)
        return RequestRejected(self.absent_words(missing), moved=False)

    def absent_words(self, missing: Collection[int]) -> str:
        """Say which drives do not answer, and what to look at."""
        named = ", ".join(str(self.drive(node)) for node in missing)
        verb = "does" if len(missing) == 1 else "do"
        return (
            f"{named} {verb} not answer, while others on the bus do: check that it has power, "
            "that its CAN plug sits, and that its id and bit rate are those of the arm file"
        )

    def shared_words(self) -> str:
        """Say which ids two drives answer to; empty where none is."""
        shared = [node for node, count in self.extra.items() if count >= SHARED]
        if not shared:
            return ""
        named = ", ".join(map(str, shared))
        return (
            f"more than one drive answers to the id {named}: every drive ships with id 1. Unplug "
            "all but one and give each an id of its own, one at a time"
        )
