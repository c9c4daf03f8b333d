"""The results as a table of behaviours by dialect, for the terminal and for the page."""

from collections.abc import Iterable, Sequence
from itertools import groupby

from .behaviour import EVERYWHERE, Behaviour
from .running import RowResult, Verdict

NOT_RUN = "–"
EVERYWHERE_KEPT = "yes"
IN_MOTION, STANDING, BOTH = ", in motion", ", standing", ", in motion and standing"
WORDS = {
    "memory": "in process, on simulated time",
    "pty": "another process, over a pseudo-terminal (drives: over a serial CAN adapter on one)",
    "tcp": "another process, over TCP",
    "udp": "another process, over UDP, in rows of its own",
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
that changes or repeats a command, and a stepper that slips without a switch. In simulated time a
fault occurs at seven moments of a motion, in real time at one.

`tests/conformance/faults.py` lists the error and the remaining trust after each fault, for every
arm. The everyday tests run each row on one dialect of each kind: in bursts, by a queue, and over a
bus. With THOROUGH=1 they run on all, and on other boards and firmware (`VARIANTS` in
`tests/conformance/memory_bench.py`), of which a third of the rows run every day.

A single word holds for every transport. Otherwise there is one word for each, in this order:
"""


def page(behaviours: Sequence[Behaviour], results: Iterable[RowResult], command: str) -> str:
    """Return the page: its introduction, the command that wrote it, the table and the notes."""
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


def text(behaviours: Sequence[Behaviour], results: Iterable[RowResult]) -> str:
    """Return the table for a terminal, with a sentence for each broken row."""
    found = tuple(results)
    dialects = _dialects(found)
    width = max(len(row.name) for row in behaviours) + 2
    rows = [("", *dialects), *_rows(behaviours, found)]
    lines = [f"{name:<{width}}" + "".join(f"{cell:<18}" for cell in cells) for name, *cells in rows]
    lines += ["", *notes(found, Verdict.BROKEN), summary(found)]
    return "\n".join(line.rstrip() for line in lines)


def summary(results: Sequence[RowResult]) -> str:
    """Return the number of each verdict, in words."""
    counts = {verdict: sum(each.verdict is verdict for each in results) for verdict in Verdict}
    return (
        f"{counts[Verdict.KEPT]} kept, {counts[Verdict.BROKEN]} broken, "
        f"{counts[Verdict.NOT_APPLICABLE]} not applicable"
    )


def notes(results: Sequence[RowResult], verdict: Verdict) -> list[str]:
    """Return a sentence for each broken row; for other verdicts each reason with its dialects."""
    if verdict is Verdict.BROKEN:
        return [
            f"{each.behaviour} ({each.dialect}, {each.transport}): {each.words}"
            for each in results
            if each.verdict is verdict
        ]
    reasons: dict[str, dict[str, None]] = {}
    for each in results:
        if each.verdict is verdict:
            reasons.setdefault(each.words, {})[each.dialect] = None
    return [f"{words} ({', '.join(dialects)})" for words, dialects in reasons.items()]


def _markdown(behaviours: Sequence[Behaviour], results: Sequence[RowResult]) -> Iterable[str]:
    """Yield the rows by family: as a list if every dialect keeps them, else as a table."""
    for family, members in groupby(behaviours, lambda row: row.family):
        rows = list(_paired(_rows(tuple(members), results)))
        kept = [row for row in rows if set(row[1:]) == {EVERYWHERE_KEPT}]
        others = [row for row in rows if row not in kept]
        yield from ("", f"## {family[0].upper() + family[1:]}", "")
        if kept:
            yield from ("Every controller:", "", *(f"- {name}" for name, *_ in kept))
        if others:
            yield from ([""] if kept else [])
            yield f"| behaviour | {' | '.join(_dialects(results))} |"
            yield "|---" * (1 + len(_dialects(results))) + "|"
            yield from (f"| {' | '.join(cells)} |" for cells in others)
    yield ""


def _paired(rows: Sequence[tuple[str, ...]]) -> Iterable[tuple[str, ...]]:
    """Yield the rows; a fault with the same results in motion and standing gets one row."""
    known = set(rows)
    for name, *cells in rows:
        fault, moving, _ = name.partition(IN_MOTION)
        standing = (name.removesuffix(STANDING) + IN_MOTION, *cells)
        if moving and (fault + STANDING, *cells) in known:
            yield (fault + BOTH, *cells)
        elif not (name.endswith(STANDING) and standing in known):
            yield (name, *cells)


def _rows(behaviours: Sequence[Behaviour], results: Sequence[RowResult]) -> list[tuple[str, ...]]:
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


def _columns(row: Behaviour, results: Sequence[RowResult]) -> tuple[str, ...]:
    """Return the transports that a row's cells show: those of most rows, or only its own."""
    everywhere = any(row.runs_over(each) for each in EVERYWHERE)
    return tuple(
        each
        for each in _transports(results)
        if (each in EVERYWHERE if everywhere else row.runs_over(each))
    )


def _cell(results: Sequence[RowResult | None]) -> str:
    """Return one word if all transports agree, else one for each."""
    words = [NOT_RUN if each is None else each.verdict.value for each in results]
    if not words:
        return Verdict.NOT_APPLICABLE.value
    return words[0] if len(set(words)) == 1 else " · ".join(words)


def _dialects(results: Sequence[RowResult]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(each.dialect for each in results))


def _transports(results: Sequence[RowResult]) -> tuple[str, ...]:
    return tuple(each for each in WORDS if any(one.transport == each for one in results))
