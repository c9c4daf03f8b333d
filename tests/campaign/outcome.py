"""The outcome of a mission, and the table of faults by outcome."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum


class Outcome(IntEnum):
    """The worst event of a mission. The arm was brought back after all but a violation."""

    ENDED_WELL = 0
    REFUSED = 1
    ERROR_STOP = 2
    PROGRAM_ENDED = 3
    LINK_LOST = 4
    VIOLATION = 5


TITLES = {
    Outcome.ENDED_WELL: "ended well",
    Outcome.REFUSED: "refused",
    Outcome.ERROR_STOP: "error-stop, recovered",
    Outcome.PROGRAM_ENDED: "program ended, recovered",
    Outcome.LINK_LOST: "link lost, recovered",
    Outcome.VIOLATION: "VIOLATION",
}


@dataclass(frozen=True, slots=True)
class Result:
    """The result of one mission; `broken` has a sentence for each law that it broke."""

    dialect: str
    seed: int
    outcome: Outcome
    faults: tuple[str, ...]
    broken: tuple[str, ...] = ()
    log: tuple[str, ...] = ()
    simulated_s: float = 0.0

    @property
    def command(self) -> str:
        """The command that repeats the mission."""
        return f"python -m tests.campaign --dialect {self.dialect} --only {self.seed}"


def counts(results: Iterable[Result]) -> Counter[tuple[str, Outcome]]:
    """Count missions by fault and outcome; one with several faults counts for each."""
    found: Counter[tuple[str, Outcome]] = Counter()
    for each in results:
        for name in each.faults:
            found[name, each.outcome] += 1
    return found


def rows(
    found: Counter[tuple[str, Outcome]], names: Iterable[str]
) -> list[tuple[str, tuple[int, ...]]]:
    """Return the table: for each fault that struck, its missions by outcome."""
    table = [(name, tuple(found[name, each] for each in Outcome)) for name in names]
    return [(name, numbers) for name, numbers in table if any(numbers)]


def markdown(table: Iterable[tuple[str, tuple[int, ...]]]) -> str:
    """Return the table as Markdown."""
    lines = ["| fault | " + " | ".join(TITLES.values()) + " |", "|---" * (1 + len(Outcome)) + "|"]
    lines += [f"| {name} | " + " | ".join(map(str, numbers)) + " |" for name, numbers in table]
    return "\n".join(lines)
