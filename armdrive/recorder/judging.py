"""Holding what an arm said beside what its twin says: the first difference is the parting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from armdrive.controllers.requests import AlertKind
from armdrive.recorder.bench import Bench
from armdrive.recorder.entries import Entry, Kind
from armdrive.recorder.messages import Talk
from armdrive.recorder.placing import counts_of
from armdrive.recorder.weighing import Message, Weight
from armdrive.sim.saved import Json

GRACE_S = 1.0
"""An answer of the twin that the arm has not given by then, with nothing asked, is a difference."""
_APART = frozenset((Weight.PASSING, Weight.SELF))


@dataclass(frozen=True, slots=True)
class Parting:
    """The first difference: at which entry, what each said, and how the twin stands then."""

    index: int
    time_s: float
    why: str
    arm: str
    twin: str
    twin_state: str
    twin_view: Mapping[str, Json]

    def __str__(self) -> str:
        return (
            f"they part at {self.time_s:.3f} s: {self.why}. The arm: {self.arm}. The twin: "
            f"{self.twin}. The twin stands like this: {self.twin_state}"
        )


class Judge:
    """Compares entry after entry, up to the first difference; `compared` counts what agreed."""

    def __init__(self, bench: Bench, talk: Talk) -> None:
        self.compared = 0
        self.parting: Parting | None = None
        self._bench = bench
        self._talk = talk
        self._splitter = talk.splitter()
        self._told = False
        self._heard_s = 0.0
        self._passing: Message | None = None

    def resume(self) -> None:
        """Begin to listen behind a gap: a message that had begun before it is none."""
        self._splitter = self._talk.splitter()

    def heard(self, index: int, entry: Entry, asked: str) -> None:
        """Compare the messages that the bytes of an entry complete."""
        data = entry.what if isinstance(entry.what, bytes) else b""
        for message in self._splitter.feed(data):
            self._heard_s = entry.time_s
            if message.weight is Weight.PASSING:
                self._passing = message
            beginning = message.weight is Weight.BANNER and not self._told
            if message.weight not in _APART and not beginning and self.parting is None:
                self._compare(index, entry, message, asked)

    def _compare(self, index: int, entry: Entry, message: Message, asked: str) -> None:
        said = self._talk.said(message.data)
        banner = message.weight is Weight.BANNER
        answer = (self._bench.banner if banner else self._bench.answer)(entry.time_s)
        if answer is None:
            self._part(index, entry, "the arm said what the twin does not say", said, "nothing")
        elif not self._agrees(message, answer, asked):
            its = self._talk.said(answer.data)
            self._part(index, entry, "they answered otherwise", said, its)
        else:
            self.compared += 1

    def _agrees(self, message: Message, answer: Message, asked: str) -> bool:
        if message.data == answer.data or message.weight is Weight.BANNER:
            return True
        of_moment = message.weight is answer.weight is Weight.MOMENT
        turning = asked.startswith("Move") or self._bench.moving
        return of_moment and turning and message.kind == answer.kind

    def counts(self, index: int, entry: Entry) -> None:
        """Compare the counts of motors that stand."""
        if not self._told:
            self._told = True
            self._bench.forget_banners()
        counts = counts_of(entry)
        stands = self._bench.stand(entry.time_s)
        twin = self._bench.registers
        if stands and counts == twin:
            self.compared += 1
            return
        why = "the motors were counted otherwise" if stands else "the twin still moves"
        self._part(index, entry, why, _words(counts), _words(twin))

    def silence(self, index: int, entry: Entry) -> None:
        """Look whether the twin has spoken since the arm fell silent."""
        self._bench.advance(entry.time_s)
        self.unasked(index, entry, entry.time_s)
        said = self._bench.passing
        if said is not None and self._bench.passing_s > self._heard_s + GRACE_S / 4:
            why = f"the arm was silent from {self._heard_s:.3f} s on, and the twin was not"
            self._part(index, entry, why, str(entry.what), self._talk.said(said.data))

    def alerted(self, index: int, entry: Entry) -> None:
        """Compare the last reports of a motion, where the arm's were of something else."""
        words = str(entry.what)
        ours, its = (
            "nothing" if each is None else self._talk.said(each.data)
            for each in (self._passing, self._bench.passing)
        )
        if words.startswith(AlertKind.RESTARTED.value):
            self._part(index, entry, "the arm began anew, the twin did not", words, its)
        elif words.startswith(AlertKind.ASTRAY.value) and ours != its:
            self._part(index, entry, "the arm was seen off the way that was sent", ours, its)

    def unasked(self, index: int, entry: Entry, before_s: float) -> None:
        """Look whether the twin has said by then what the arm never said."""
        message = self._bench.unasked(before_s)
        if message is not None:
            silent = str(entry.what) if entry.kind is Kind.SILENCE else "nothing"
            its = self._talk.said(message.data)
            self._part(index, entry, "the twin said what the arm did not say", silent, its)

    def _part(self, index: int, entry: Entry, why: str, arm: str, twin: str) -> None:
        if self.parting is None:
            bench = self._bench
            self.parting = Parting(index, entry.time_s, why, arm, twin, bench.words, bench.view)


def _words(counts: tuple[int, ...]) -> str:
    return " ".join(map(str, counts))
