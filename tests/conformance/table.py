"""The results as Markdown: for each family of behaviours a table by dialect."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from .behaviour import Behaviour
from .running import RowResult, Verdict

EVERYWHERE_KEPT = "yes"
WORDS = {
    "memory": "in process, on simulated time",
    "pty": "another process, over a pseudo-terminal (drives: over a serial CAN adapter on one)",
    "tcp": "another process, over TCP",
    "udp": "another process, over UDP",
    "port": "a real arm",
}
PAGE_INTRO = """# Conformance

What every arm does, whichever controller it has. Each row is a function in `tests/conformance`. It
drives an arm through armdrive's public calls and observes the **physical** arm, not the registers.
A new dialect in the registry is tested automatically. `n/a`: the abilities of the dialect rule the
behaviour out.

After every fault nothing moves without a command, and the call ends in time, with its result or an
error that says what is wrong. If the device gave any evidence of a wrong position, the position is
not trusted. After a reset (or a new connection) and a reference, the arm works as before. Two
things that no driver can prevent are excused ([testing](testing.md)): a wire without check bytes
that changes or repeats a command, and a stepper that slips without a switch. A fault strikes a
standing arm and a moving one: in simulated time at seven moments of a motion, in real time at one.

`tests/conformance/faults.py` lists the error and the remaining trust after each fault, for every
arm. The everyday tests run each row on one dialect of each kind: in bursts, by a queue, and over a
bus. With THOROUGH=1 they run on all, and on other boards and firmware (`VARIANTS` in
`tests/conformance/memory_bench.py`), of which a quarter of the rows run every day.

A single word holds for every transport of a row. Otherwise there is one for each, in this order:
"""


def page(behaviours: Sequence[Behaviour], results: Iterable[RowResult], command: str) -> str:
    """Return the page: its introduction, the command that wrote it, the table and the notes."""
    found = tuple(results)
    transports = [each for each in WORDS if any(one.transport == each for one in found)]
    named = ";\n".join(f"{each}: {WORDS[each]}" for each in transports)
    reasons: dict[str, dict[str, None]] = {}
    for each in found:
        if each.verdict is Verdict.NOT_APPLICABLE:
            reasons.setdefault(each.words, {})[each.dialect] = None
    notes = [f"- {words} ({', '.join(dialects)})" for words, dialects in reasons.items()]
    lines = [f"{PAGE_INTRO}{named}.", "", f"Made by `{command}`."]
    lines += list(markdown(behaviours, found))
    lines += ["## What is not applicable, and why", "", *(notes or ["Nothing."])]
    lines += ["", "## What is not as promised", "", *(broken(found) or ["Nothing."])]
    return "\n".join(lines) + "\n"


def summary(results: Sequence[RowResult]) -> str:
    """Return the number of each verdict, in words."""
    counts = {verdict: sum(each.verdict is verdict for each in results) for verdict in Verdict}
    return (
        f"{counts[Verdict.KEPT]} kept, {counts[Verdict.BROKEN]} broken, "
        f"{counts[Verdict.NOT_APPLICABLE]} not applicable"
    )


def broken(results: Sequence[RowResult]) -> list[str]:
    """Return a line for each broken row."""
    return [
        f"- {each.behaviour} ({each.dialect}, {each.transport}): {each.words}"
        for each in results
        if each.verdict is Verdict.BROKEN
    ]


def markdown(behaviours: Sequence[Behaviour], results: Sequence[RowResult]) -> Iterator[str]:
    """Yield the rows by family: as a list if every dialect keeps them, else as a table."""
    dialects = tuple(dict.fromkeys(each.dialect for each in results))
    for family, members in groupby(behaviours, lambda row: row.family):
        rows = [(row.name, *(_cell(row, name, results) for name in dialects)) for row in members]
        kept = [row for row in rows if set(row[1:]) == {EVERYWHERE_KEPT}]
        others = [row for row in rows if row not in kept]
        yield from ("", f"## {family[0].upper() + family[1:]}", "")
        if kept:
            yield from ("Every controller:", "", *(f"- {name}" for name, *_ in kept))
        if others:
            yield from ([""] if kept else [])
            yield f"| behaviour | {' | '.join(dialects)} |"
            yield "|---" * (1 + len(dialects)) + "|"
            yield from (f"| {' | '.join(cells)} |" for cells in others)
    yield ""


def _cell(row: Behaviour, dialect: str, results: Sequence[RowResult]) -> str:
    """Return one word if all transports of a row agree, else one for each."""
    words = {
        each.transport: each.verdict.value
        for each in results
        if (each.behaviour, each.dialect) == (row.name, dialect)
    }
    found = [words[each] for each in WORDS if each in words]
    return " · ".join(found if len(set(found)) > 1 else found[:1]) or Verdict.NOT_APPLICABLE.value
