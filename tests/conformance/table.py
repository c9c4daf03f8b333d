"""The results as a table of behaviours by dialects, for the terminal and for the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby

from .behaviour import EVERYWHERE, Behaviour
from .running import Result, Verdict

NOT_RUN = "–"
WORDS = {
    "memory": "in process, on simulated time",
    "pty": "another process, over a pseudo-terminal (drives: over a serial CAN adapter on one)",
    "tcp": "another process, over TCP",
    "udp": "another process, over UDP, in rows of its own",
    "port": "a real arm",
}
PAGE_INTRO = """# Conformance

What an arm does, whichever controller it has. Each row of the table is a behaviour of
[tests/conformance](../../tests/conformance/behaviours.py): a function that drives an arm by
armdrive's public calls, looks at the **physical** arm, which no register knows, and says in a
sentence what was not as promised. Every dialect of the
[registry](../../armdrive/registry/__init__.py) is put on the same benches; a new row there is under test by itself. What a dialect cannot do by its
table of abilities is `n/a`, by a rule on those abilities.

Of every fault the same is asked, whenever it comes: nothing moves that was not commanded; the call
ends in time, with what was asked for or with an error that says what is wrong; the position is not
called referenced where the arm does not stand there, if the device gave any sign of it; and once
the fault is over, a reset (or connecting again) and a reference make the arm work as before, and
move nothing. A wire without check bytes can turn a number into another one, and a command that
comes twice can be obeyed twice: there, no driver can keep the arm from moving otherwise than it
was commanded, so that it is only asked that this is found out. Steppers that slip or stall without
a switch give no sign at all: there, it is only asked that the arm works once it is referenced.
What is left of a disturbed line in the ear of a device without check bytes may spoil the first
motion after the fault: that is an error, and after one more reset and reference the arm works. On
simulated time each fault comes at seven moments of a motion, in real time at one.

A pause is asked of every motion as a stop is, within what the status announces for a program that
falls silent ([sharing.md](../how-to/sharing.md)); what other programs may ask is asked by
the commands of the command line, each in a process of its own. Homing by switches and grippers on
a servo or an output are tried on arms of a file of their own, since no preset has them: switches
that stick, that never close, and a stop on the way. A simulated servo that is told nothing stays
where it is, so that only an output shows what connecting would let go. Of a wire that was lost
([reconnecting.md](../reconnecting.md)) the same connection is asked once it is back. A jog that is
held expires counted from the call that held it: on a slow wire, or a busy computer, it may have
expired before its first burst could begin, and then nothing moves. These rows renew it until the
arm is seen to move, as a keyboard does.

A word alone holds for every transport; where they differ there is one for each, in this order:
"""


def page(behaviours: Sequence[Behaviour], results: Iterable[Result], command: str) -> str:
    """Return the page: words, how it was made, the table and its notes."""
    found = tuple(results)
    transports = _transports(found)
    named = ";\n".join(f"{each}: {WORDS[each]}" for each in transports)
    lines = [f"{PAGE_INTRO}{named}.", "", f"Made by `{command}`; {summary(found)}."]
    lines += list(_markdown(behaviours, found))
    lines += ["## What is not applicable, and why", ""]
    lines += [f"- {note}" for note in notes(found, Verdict.NOT_APPLICABLE)] or ["Nothing."]
    broken = [f"- {note}" for note in notes(found, Verdict.BROKEN)]
    lines += ["", "## What is not as promised", "", *(broken or ["Nothing."])]
    return "\n".join(lines) + "\n"


def text(behaviours: Sequence[Behaviour], results: Iterable[Result]) -> str:
    """Return the table for a terminal, with the sentences of what was broken."""
    found = tuple(results)
    dialects = _dialects(found)
    width = max(len(row.name) for row in behaviours) + 2
    rows = [("", *dialects), *_rows(behaviours, found)]
    lines = [f"{name:<{width}}" + "".join(f"{cell:<18}" for cell in cells) for name, *cells in rows]
    lines += ["", *notes(found, Verdict.BROKEN), summary(found)]
    return "\n".join(line.rstrip() for line in lines)


def summary(results: Sequence[Result]) -> str:
    """Count the verdicts."""
    counts = {verdict: sum(each.verdict is verdict for each in results) for verdict in Verdict}
    return (
        f"{counts[Verdict.KEPT]} kept, {counts[Verdict.BROKEN]} broken, "
        f"{counts[Verdict.NOT_APPLICABLE]} not applicable"
    )


def notes(results: Sequence[Result], verdict: Verdict) -> list[str]:
    """Say why, once for each reason, and of which behaviours and dialects."""
    if verdict is Verdict.BROKEN:
        return [
            f"{each.behaviour} ({each.dialect}, {each.transport}): {each.words}"
            for each in results
            if each.verdict is verdict
        ]
    chosen = [each for each in results if each.verdict is verdict]
    reasons: dict[tuple[str, str], list[str]] = {}
    for each in chosen:
        reasons.setdefault((each.words, each.behaviour), []).append(each.dialect)
    return [
        f"{behaviour}: {words} ({', '.join(dict.fromkeys(dialects))})"
        for (words, behaviour), dialects in reasons.items()
    ]


def _markdown(behaviours: Sequence[Behaviour], results: Sequence[Result]) -> Iterable[str]:
    for family, members in groupby(behaviours, lambda row: row.family):
        yield from ("", f"## {family[0].upper() + family[1:]}", "")
        yield f"| behaviour | {' | '.join(_dialects(results))} |"
        yield "|---" * (1 + len(_dialects(results))) + "|"
        for cells in _rows(tuple(members), results):
            yield f"| {' | '.join(cells)} |"
    yield ""


def _rows(behaviours: Sequence[Behaviour], results: Sequence[Result]) -> list[tuple[str, ...]]:
    known = {(each.behaviour, each.dialect, each.transport): each for each in results}
    reached = {(each.dialect, each.transport) for each in results}
    return [
        (
            row.name,
            *(
                _cell(
                    [
                        known.get((row.name, dialect, each))
                        for each in _columns(row, results)
                        if (dialect, each) in reached
                    ]
                )
                for dialect in _dialects(results)
            ),
        )
        for row in behaviours
    ]


def _columns(row: Behaviour, results: Sequence[Result]) -> tuple[str, ...]:
    """Return the transports that a row's cells tell of: those of most rows, or its own alone."""
    everywhere = any(row.meant_for(each) for each in EVERYWHERE)
    return tuple(
        each
        for each in _transports(results)
        if (each in EVERYWHERE if everywhere else row.meant_for(each))
    )


def _cell(results: Sequence[Result | None]) -> str:
    """Return one word where all transports agree, else one for each."""
    words = [NOT_RUN if each is None else each.verdict.value for each in results]
    if not words:
        return Verdict.NOT_APPLICABLE.value
    return words[0] if len(set(words)) == 1 else " · ".join(words)


def _dialects(results: Sequence[Result]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(each.dialect for each in results))


def _transports(results: Sequence[Result]) -> tuple[str, ...]:
    return tuple(each for each in WORDS if any(one.transport == each for one in results))
