"""Reading one line: the parser's tree becomes statements, and what it trips over a sentence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, TypeAlias

from lark import Token, Tree, UnexpectedInput

from armdrive.programs.acts import Mark
from armdrive.programs.expressions import Expressions
from armdrive.programs.grammar import line_parser
from armdrive.programs.heads import (
    DefineHead,
    Else,
    End,
    Head,
    IfHead,
    RepeatHead,
    Unread,
    WhileHead,
)
from armdrive.programs.problems import Problem
from armdrive.programs.syntax import (
    Assign,
    Branch,
    Call,
    Do,
    Goto,
    If,
    Label,
    Remark,
    Statement,
)
from armdrive.programs.terms import (
    Expression,
)
from armdrive.programs.vocabulary import SPELLINGS
from armdrive.programs.wording import mistake

DEEPEST_VALUE = 60
"""Values may be nested so deep: what is deeper is unreadable, and a mistake of a generator."""

LONGEST_LINE = 10_000
"""Characters. A longer line is a mistake of a generator, and takes seconds to be read."""

Item: TypeAlias = Statement | Head


class LineMistake(Exception):
    """A line that cannot be read."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.text)
        self.problem = problem


def read_line(line: str, number: int = 1, file: str = "") -> list[Item]:
    """Return what a line says: perhaps a label, a statement or the head of a block, a comment.

    Raises `LineMistake`.
    """
    if not line.strip(" \t"):
        return [Remark(mark=Mark(number, 1, file))]
    if len(line) > LONGEST_LINE:
        mark = Mark(number, LONGEST_LINE + 1, file)
        raise LineMistake(Problem(mark, f"a line has at most {LONGEST_LINE} characters"))
    try:
        tree = line_parser().parse(line)
    except UnexpectedInput as error:
        column, text = mistake(error, line)
        raise LineMistake(Problem(Mark(number, column, file), text)) from None
    if _depth(tree) > DEEPEST_VALUE:
        raise LineMistake(
            Problem(Mark(number, 1, file), "this is nested too deeply: give its parts names")
        )
    return _Reader(number, file).items(tree)


def _depth(tree: Tree[Token]) -> int:
    deepest, waiting = 0, [(tree, 1)]
    while waiting:
        found, depth = waiting.pop()
        deepest = max(deepest, depth)
        waiting += [(each, depth + 1) for each in found.children if isinstance(each, Tree)]
    return deepest


class _Reader(Expressions):
    """Turns the parser's tree of one line into statements."""

    def items(self, tree: Tree[Token]) -> list[Item]:
        found: list[Item] = []
        note: Token | None = None
        for child in tree.children:
            if isinstance(child, Token):
                note = child
            else:
                found.append(_STATEMENTS[child.data](self, child))
        return found if note is None else self._noted(found, note)

    def _noted(self, found: list[Item], note: Token) -> list[Item]:
        text = note[1:].removeprefix(" ").rstrip()
        last = found[-1] if found else End()
        if isinstance(last, If):
            (branch,) = last.branches
            return [*found[:-1], replace(last, branches=(replace(branch, note=text),))]
        if isinstance(last, End | Remark | Else | Unread):
            return [*found, Remark(text, mark=self.mark(note))]
        return [*found[:-1], replace(last, note=text)]

    def label(self, tree: Tree[Token]) -> Label:
        (name,) = tree.children
        return Label(str(name), mark=self.mark(name))

    def do(self, tree: Tree[Token]) -> Do:
        word, *rest = tree.children
        arguments: tuple[Expression, ...] = ()
        links = []
        for part in rest:
            assert isinstance(part, Tree)  # noqa: S101 - the grammar's own promise
            if part.data == "link":
                link, values = part.children
                links.append((str(link).lower(), self.arguments(values)))
            else:
                arguments = self.arguments(part)
        return Do(SPELLINGS[str(word).lower()], arguments, tuple(links), mark=self.mark(word))

    def assign(self, tree: Tree[Token]) -> Assign:
        name, value = tree.children[-2:]
        return Assign(str(name), self.value(value), tree.data == "point", mark=self.mark(name))

    def call(self, tree: Tree[Token]) -> Call:
        name, *rest = tree.children
        arguments = self.arguments(rest[0]) if rest else ()
        return Call(str(name), arguments, mark=self.mark(name))

    def goto(self, tree: Tree[Token]) -> Goto:
        target = _tree(tree.children[-1]).children[0]
        return Goto(str(target), mark=self.mark(target))

    def if_goto(self, tree: Tree[Token]) -> If:
        mark = self.mark(tree)
        condition = self.value(tree.children[0])
        return If((Branch(condition, (self.goto(tree),), mark=mark),), mark=mark)

    def if_head(self, tree: Tree[Token]) -> IfHead:
        return IfHead(self.value(tree.children[-1]), mark=self.mark(tree))

    def else_head(self, tree: Tree[Token]) -> Else:
        condition = self.value(tree.children[-1]) if tree.children else None
        return Else(condition, mark=self.mark(tree))

    def while_head(self, tree: Tree[Token]) -> WhileHead:
        return WhileHead(self.value(tree.children[-1]), mark=self.mark(tree))

    def repeat_head(self, tree: Tree[Token]) -> RepeatHead:
        name = next((str(each) for each in tree.children if isinstance(each, Token)), "")
        count = next((self.value(each) for each in tree.children if isinstance(each, Tree)), None)
        return RepeatHead(count, name, mark=self.mark(tree))

    def define_head(self, tree: Tree[Token]) -> DefineHead:
        name, *rest = tree.children
        parameters = tuple(str(each) for each in _tree(rest[0]).children) if rest else ()
        return DefineHead(str(name), parameters, mark=self.mark(name))

    def end(self, tree: Tree[Token]) -> End:
        return End(mark=self.mark(tree))


def _tree(child: Tree[Token] | Token) -> Tree[Token]:
    assert isinstance(child, Tree)  # noqa: S101 - the grammar's own promise
    return child


_STATEMENTS: Mapping[str, Callable[[_Reader, Tree[Token]], Any]] = MappingProxyType({
    "label": _Reader.label,
    "do": _Reader.do,
    "assign": _Reader.assign,
    "point": _Reader.assign,
    "call": _Reader.call,
    "goto": _Reader.goto,
    "if_goto": _Reader.if_goto,
    "if_": _Reader.if_head,
    "else_if": _Reader.else_head,
    "else_": _Reader.else_head,
    "while_": _Reader.while_head,
    "repeat": _Reader.repeat_head,
    "define": _Reader.define_head,
    "end": _Reader.end,
})  # fmt: skip
