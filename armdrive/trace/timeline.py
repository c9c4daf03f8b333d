"""A recording for people: one line an entry, the bytes with what they mean."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from armdrive.trace.describe import talk
from armdrive.trace.entries import EntryKind, TraceEntry
from armdrive.trace.files import Recording

TEXT_AT = 34
"""The column where the meaning of bytes begins, where the bytes are shorter."""

ARROWS: Mapping[EntryKind, str] = MappingProxyType({EntryKind.SENT: "->", EntryKind.HEARD: "<-"})
"""Which way bytes went: to the arm, from the arm."""


def heading(recording: Recording) -> str:
    """Say whose recording it is, when it was made, and why."""
    header = recording.header
    span_s = recording.entries[-1].time_s - header.began_s if recording.entries else 0.0
    return (
        f"{header.arm} ({header.title}) on {header.link}, connected {header.began}, "
        f"{span_s:.1f} s, {len(recording.entries)} entries, written: {header.why}, "
        f"by armdrive {header.version}"
    )


class Teller:
    """Puts entries into words, one after another: a message may come in several pieces."""

    def __init__(self, dialect: str) -> None:
        self._talk = talk(dialect)
        self._splitter = self._talk.splitter()

    def meaning(self, entry: TraceEntry) -> str:
        """Return what the bytes of an entry mean: of what is heard, the messages it completes."""
        data = entry.what if isinstance(entry.what, bytes) else b""
        if entry.kind is EntryKind.SENT:
            return self._talk.words(data, self._talk.sent)
        heard = self._splitter.feed(data)
        return "; ".join(self._talk.words(each.data, self._talk.heard) for each in heard)

    def shown(self, entry: TraceEntry) -> str:
        """Return the bytes of an entry as people write them; nothing where it has none."""
        return self._talk.shown(entry.what) if isinstance(entry.what, bytes) else ""

    def line(self, entry: TraceEntry) -> str:
        """Return an entry in a line."""
        if not isinstance(entry.what, bytes):
            return f"{entry.time_s:12.4f} s     {entry.kind.value}: {entry.what}"
        text = f"{self._talk.shown(entry.what):<{TEXT_AT}}  {self.meaning(entry)}".rstrip()
        return f"{entry.time_s:12.4f} s  {ARROWS[entry.kind]} {text}"

    def view(self, entry: TraceEntry) -> dict[str, Any]:
        """Return an entry as plain data, the bytes in hexadecimal."""
        view: dict[str, Any] = {"time_s": entry.time_s, "kind": entry.kind.value}
        if not isinstance(entry.what, bytes):
            return view | {"text": entry.what}
        shown = {"hex": entry.what.hex(), "text": self._talk.shown(entry.what)}
        return view | shown | {"words": self.meaning(entry)}


@dataclass(frozen=True, slots=True)
class Parting:
    """The first difference: at which entry, what each said, and how the twin stands then."""

    index: int
    time_s: float
    why: str
    arm: str
    twin: str
    twin_state: str
    twin_view: Mapping[str, object]

    def __str__(self) -> str:
        return (
            f"they part at {self.time_s:.3f} s: {self.why}. The arm: {self.arm}. The twin: "
            f"{self.twin}. The twin stands like this: {self.twin_state}"
        )


def lines(recording: Recording, parting: Parting | None = None) -> Iterator[tuple[float, str]]:
    """Return each entry's time and words, and the parting where it came."""
    teller = Teller(recording.header.dialect)
    for index, entry in enumerate(recording.entries):
        yield entry.time_s, teller.line(entry)
        if parting is not None and parting.index == index:
            yield entry.time_s, f">>> {parting}"
