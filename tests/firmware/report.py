"""Results as plain text: a line for each row and stop."""

from collections.abc import Iterable, Sequence

from tests.conformance.running import RowResult, Verdict

from .measuring import Stopped

KEEPS_PACE = 0.98
"""Below this ratio of simulated to real time, measurements are distorted."""
WORDS = {Verdict.KEPT: "passed", Verdict.BROKEN: "FAILED", Verdict.NOT_APPLICABLE: "n/a"}


def row_line(result: RowResult) -> str:
    """Return the line of one behaviour."""
    why = f": {result.words}" if result.words else ""
    return f"{WORDS[result.verdict]:<7} {result.took_s:5.1f} s  {result.behaviour}{why}"


def row_summary(results: Sequence[RowResult]) -> str:
    """Count the rows by verdict."""
    counts = (
        f"{sum(each.verdict is verdict for each in results)} {word}"
        for verdict, word in WORDS.items()
    )
    return ", ".join(counts)


def pace_line(ratio: float) -> str:
    """Report how well the simulated processor kept real time."""
    line = f"processor time: {ratio:.3f} s per second"
    if ratio >= KEEPS_PACE:
        return line
    return f"WARNING: {line}. The computer is too slow or too busy for valid measurements."


def stop_table(stops: Sequence[Stopped]) -> str:
    """Return the worst stop of each kind and the announced bounds."""
    rows = [
        ("how", "steps/s", "actual", "announced", "last step", "steps", "announced", "went", "kept")
    ]
    for how, rate_hz in dict.fromkeys((each.how, each.rate_hz) for each in stops):
        tries = [each for each in stops if (each.how, each.rate_hz) == (how, rate_hz)]
        good = [each for each in tries if each.announced_s]
        wrong = "; ".join(dict.fromkeys(each.wrong for each in tries if each.wrong))
        if not good:
            rows.append((how, f"{rate_hz:g}", *"------", f"NO: {wrong}"))
            continue
        announced_s = min(each.announced_s for each in good)
        took_s, pulses = max(each.took_s for each in good), max(each.pulses for each in good)
        announced_mm = min(each.announced_mm for each in good)
        way_mm = max(each.way_mm for each in good)
        late = [] if all(each.within for each in good) else ["beyond the announced bound"]
        told = "; ".join([*late, *([wrong] if wrong else [])])
        rows.append(
            (
                how,
                f"{rate_hz:g}",
                f"{sum(each.actual_hz for each in good) / len(good):.0f}",
                _seconds(announced_s),
                _seconds(took_s),
                str(pulses),
                f"{announced_mm:.1f} mm",
                f"{way_mm:.1f} mm",
                f"NO: {told}" if told else "yes",
            )
        )
    return _table(rows)


def _seconds(time_s: float) -> str:
    return f"{time_s:.3f} s" if time_s else "-"


def _table(rows: Iterable[Sequence[str]]) -> str:
    lines = list(rows)
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]) - 1)]
    return "\n".join(
        "  ".join(
            [*(f"{cell:<{w}}" for cell, w in zip(line, widths, strict=False)), line[-1]]
        ).rstrip()
        for line in lines
    )
