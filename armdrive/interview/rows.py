"""Questions as rows of a table, and what a row becomes once earlier answers are known."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from armdrive.interview.draft import Draft
from armdrive.interview.readers import Question, Reader

Fill = Callable[[Draft, str], str | None]
"""Makes a default, as somebody would type it, from the answers and the row's own `each`."""


def _always(_draft: Draft) -> bool:
    return True


def _once(_draft: Draft) -> Sequence[str]:
    return ("",)


def _no_default(_draft: Draft, _one: str) -> str | None:
    return None


def _no_choices(_draft: Draft) -> tuple[tuple[str, str], ...]:
    return ()


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the table: `{one}` in its key and words stands for each name of `each`.

    `read` makes the check from the answers before; `when` says whether the question is asked.
    """

    key: str
    words: str
    why: str
    read: Callable[[Draft], Reader]
    default: Fill = _no_default
    when: Callable[[Draft], bool] = _always
    each: Callable[[Draft], Sequence[str]] = _once
    choices: Callable[[Draft], tuple[tuple[str, str], ...]] = _no_choices

    def questions(self, draft: Draft) -> Iterator[Question]:
        """Give the questions that this row asks after these answers."""
        if not self.when(draft):
            return
        for one in self.each(draft):
            yield Question(
                self.key.replace("{one}", one),
                self.words.replace("{one}", one.replace("_", " ")),
                self.why,
                self.read(draft),
                self.default(draft, one),
                self.choices(draft),
            )


def fixed(reader: Reader) -> Callable[[Draft], Reader]:
    """Return what makes the same check whatever was answered."""
    return lambda _draft: reader


def plain(text: str) -> Fill:
    """Return what makes the same default whatever was answered."""
    return lambda _draft, _one: text


def gate(opens: str) -> Fill:
    """Return the default of "keep these?": yes, unless an answer behind the gate is given."""
    return lambda draft, _one: (
        "no" if any(k.startswith(opens) for k in draft.around.given) else "yes"
    )


def typed(values: Sequence[float]) -> str:
    """Return numbers as somebody would type them on one line."""
    return " ".join(f"{value:.6g}" for value in values)
