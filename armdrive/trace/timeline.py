"""A recording for people: one line an entry, the bytes with what they mean."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.trace.describe import talk
from armdrive.trace.entries import Entry, Kind

if TYPE_CHECKING:
    from armdrive.trace.files import Recording
    from armdrive.trace.replay import Parting, Replayed

TEXT_AT = 34
"""The column where the meaning of bytes begins, where the bytes are shorter."""

ARROWS: Mapping[Kind, str] = MappingProxyType({Kind.SENT: "->", Kind.HEARD: "<-"})
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

    def meaning(self, entry: Entry) -> str:
        """Return what the bytes of an entry mean: of what is heard, the messages it completes."""
        data = entry.what if isinstance(entry.what, bytes) else b""
        if entry.kind is Kind.SENT:
            return self._talk.words(data, self._talk.sent)
        heard = self._splitter.feed(data)
        return "; ".join(self._talk.words(each.data, self._talk.heard) for each in heard)

    def shown(self, entry: Entry) -> str:
        """Return the bytes of an entry as people write them; nothing where it has none."""
        return self._talk.shown(entry.what) if isinstance(entry.what, bytes) else ""

    def line(self, entry: Entry) -> str:
        """Return an entry in a line."""
        if not isinstance(entry.what, bytes):
            return f"{entry.time_s:12.4f} s     {entry.kind.value}: {entry.what}"
        text = f"{self._talk.shown(entry.what):<{TEXT_AT}}  {self.meaning(entry)}".rstrip()
        return f"{entry.time_s:12.4f} s  {ARROWS[entry.kind]} {text}"

    def view(self, entry: Entry) -> dict[str, Any]:
        """Return an entry as plain data, the bytes in hexadecimal."""
        view: dict[str, Any] = {"time_s": entry.time_s, "kind": entry.kind.value}
        if not isinstance(entry.what, bytes):
            return view | {"text": entry.what}
        shown = {"hex": entry.what.hex(), "text": self._talk.shown(entry.what)}
        return view | shown | {"words": self.meaning(entry)}


def lines(recording: Recording, parting: Parting | None = None) -> Iterator[tuple[float, str]]:
    """Return each entry's time and words, and the parting where it came."""
    teller = Teller(recording.header.dialect)
    for index, entry in enumerate(recording.entries):
        yield entry.time_s, teller.line(entry)
        if parting is not None and parting.index == index:
            yield entry.time_s, f">>> {parting}"


def replayed_view(recording: Recording, replayed: Replayed) -> dict[str, Any]:
    """Return what a replay found as plain data."""
    header, parting = recording.header, replayed.parting
    return {
        "arm": header.arm,
        "dialect": header.dialect,
        "link": header.link,
        "began": header.began,
        "why": header.why,
        "entries": len(recording.entries),
        "agree": parting is None,
        "compared": replayed.compared,
        "twin_late_s": round(replayed.late_s, 6),
        "notes": list(replayed.notes),
        "parting": None
        if parting is None
        else {
            "time_s": parting.time_s,
            "entry": parting.index,
            "why": parting.why,
            "arm": parting.arm,
            "twin": parting.twin,
            "twin_state": dict(parting.twin_view),
        },
    }
