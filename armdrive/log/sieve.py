"""Which lines of a log somebody wants to see, and the latest of them, kept within a bound."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, replace

from armdrive.log.lines import LogLine, Topic

KEPT = 2000
"""So many lines are kept to be looked at; the oldest go."""
BETWEEN = ","
"""Stands between words that have all to be in a line: the space bar stops the arm."""


@dataclass(frozen=True, slots=True)
class Sieve:
    """Topics that are wanted, and a text that every line must have (no matter its capitals)."""

    topics: frozenset[Topic] = frozenset(Topic)
    text: str = ""

    def turned(self, topic: Topic) -> Sieve:
        """Return a sieve with one topic more, or less."""
        return replace(self, topics=self.topics ^ {topic})

    def passes(self, line: LogLine) -> bool:
        """Tell whether a line is wanted."""
        if line.topic not in self.topics:
            return False
        said = f"{line.told} {line.shown} {line.code}".lower()
        return all(part in said for part in self.text.lower().split(BETWEEN))


class LogBook:
    """The latest lines, and those of them that pass. What a new line costs is bounded."""

    def __init__(self, kept: int = KEPT) -> None:
        self.sieve = Sieve()
        self._all: deque[LogLine] = deque(maxlen=kept)
        self._passed: deque[LogLine] = deque(maxlen=kept)
        self.kept = kept

    @property
    def lines(self) -> deque[LogLine]:
        """The lines that pass, the oldest first."""
        return self._passed

    @property
    def total(self) -> int:
        """How many lines there are, passed or not."""
        return len(self._all)

    def take(self, lines: Iterable[LogLine]) -> int:
        """Take new lines; return how many of them pass."""
        before = 0
        for line in lines:
            self._all.append(line)
            if self.sieve.passes(line):
                self._passed.append(line)
                before += 1
        oldest = self._all[0].number if self._all else 0
        while self._passed and self._passed[0].number < oldest:
            self._passed.popleft()
        return before

    def choose(self, sieve: Sieve) -> None:
        """Have other lines pass."""
        self.sieve = sieve
        self._passed = deque(filter(sieve.passes, self._all), maxlen=self.kept)

    def clear(self) -> None:
        """Forget all lines; those to come are not touched."""
        self._all.clear()
        self._passed.clear()
