"""Reading a program: its lines become a tree, its blocks are put together.

A line that cannot be read is left out, and the others are read on, so that all mistakes are told
at once.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from armdrive.programs.language.lines import Item, LineMistake, read_line
from armdrive.programs.language.syntax import (
    Define,
    DefineHead,
    Else,
    End,
    Expression,
    If,
    IfBranch,
    IfHead,
    Opening,
    Repeat,
    RepeatHead,
    Statement,
    Tree,
    Unread,
    While,
    WhileHead,
)
from armdrive.programs.problems import Problem, SourceMark, lines_of, program_error

DEEPEST_BLOCK = 30
"""Blocks may be nested so deep."""

MOST_LINES = 10_000
"""A longer one is no program; to read it, and to tell what is wrong with it, would take minutes."""

_OPENING = re.compile(r"\s*(if|while|repeat|define)(?!\w)", re.IGNORECASE)
_WORD = {IfHead: "if", WhileHead: "while", RepeatHead: "repeat", DefineHead: "define"}


@dataclass(slots=True)
class _Open:
    """A block whose end has not come yet."""

    head: Opening
    body: list[Statement] = field(default_factory=list)
    branches: list[IfBranch] = field(default_factory=list)
    condition: Expression | None = None
    at: SourceMark | None = None
    otherwise: bool = False


def parse(text: str, file: str = "") -> Tree:
    """Return the tree of a program. Raises `ProgramError` with every line that cannot be read."""
    tree, problems = read_tree(text, file)
    if problems:
        raise program_error(problems, text)
    return tree


def read_tree(text: str, file: str = "", first: int = 1) -> tuple[Tree, list[Problem]]:
    """Return the tree of what can be read of a program, and what cannot.

    Lines are counted from `first`.
    """
    blocks = _Blocks()
    lines = lines_of(text)
    if len(lines) > MOST_LINES:
        mark = SourceMark(MOST_LINES + 1, 1, file)
        return blocks.whole(), [Problem(mark, f"a program has at most {MOST_LINES} lines")]
    if lines[-1] == "":
        lines.pop()  # what ends with a line's end has no blank line behind it
    for number, line in enumerate(lines, start=first):
        try:
            items = read_line(line, number, file)
        except LineMistake as error:
            blocks.problems.append(error.problem)
            unread = _OPENING.match(line) is not None
            items = [Unread(mark=error.problem.mark)] if unread else []
        for item in items:
            blocks.take(item)
    return blocks.whole(), blocks.problems


class _Blocks:
    """Puts lines together to blocks, one line after the other."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self._top: list[Statement] = []
        self._open: list[_Open] = []

    def take(self, item: Item) -> None:
        """Take the next line."""
        if isinstance(item, End):
            self._end(item)
        elif isinstance(item, Else):
            self._else(item)
        elif isinstance(item, Opening):
            self._begin(item)
        else:
            self._body().append(item)

    def whole(self) -> Tree:
        """Return the tree of all lines."""
        for block in self._open:
            if not isinstance(block.head, Unread):
                word = _WORD[type(block.head)]
                self._wrong(block.head.mark, f"this `{word}` has no `end`")
        return Tree(tuple(self._top))

    def _body(self) -> list[Statement]:
        return self._open[-1].body if self._open else self._top

    def _begin(self, head: Opening) -> None:
        if isinstance(head, DefineHead) and self._open:
            self._wrong(head.mark, "a subprogram cannot be defined within a block")
        if len(self._open) == DEEPEST_BLOCK:
            self._wrong(head.mark, f"blocks are nested at most {DEEPEST_BLOCK} deep")
        self._open.append(_Open(head))
        if isinstance(head, IfHead):
            self._open[-1].condition = head.condition

    def _else(self, item: Else) -> None:
        block = self._open[-1] if self._open else None
        if block is not None and isinstance(block.head, Unread):
            return
        if block is None or not isinstance(block.head, IfHead):
            self._wrong(item.mark, "this `else` belongs to no `if`")
        elif block.otherwise:
            self._wrong(item.mark, "nothing comes after `else` but `end`")
        else:
            _close_branch(block)
            block.condition, block.at = item.condition, item.mark
            block.otherwise = item.condition is None

    def _end(self, item: End) -> None:
        if not self._open:
            self._wrong(item.mark, "this `end` ends nothing")
            return
        made = _made(self._open.pop())
        if made is not None and len(self._open) <= DEEPEST_BLOCK:
            self._body().append(made)

    def _wrong(self, mark: SourceMark, text: str) -> None:
        self.problems.append(Problem(mark, text))


def _close_branch(block: _Open) -> None:
    head = block.head
    first = not block.branches
    note = head.note if first and isinstance(head, IfHead) else ""
    branch = IfBranch(block.condition, tuple(block.body), note=note, mark=block.at or head.mark)
    block.branches.append(branch)
    block.body = []


def _made(block: _Open) -> Statement | None:
    head, body = block.head, tuple(block.body)
    match head:
        case IfHead():
            _close_branch(block)
            return If(tuple(block.branches), mark=head.mark)
        case WhileHead():
            return While(head.condition, body, note=head.note, mark=head.mark)
        case RepeatHead():
            return Repeat(head.count, body, head.variable, note=head.note, mark=head.mark)
        case DefineHead():
            return Define(head.name, head.parameters, body, note=head.note, mark=head.mark)
        case Unread():
            return None
