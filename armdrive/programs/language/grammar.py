"""The parser of programs, and the sentences about mistakes.

The grammar, program.lark, describes one line, and `ProgramReader` nests the lines in blocks. So one
mistake hides no other: a line that does not fit is left out. A prompt gives the same reader the
lines as they are typed.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias, cast

from lark import Lark, Token, Transformer, UnexpectedCharacters, UnexpectedInput, v_args

from armdrive.programs.language.syntax import (
    Assign,
    Call,
    Define,
    Do,
    Expression,
    Goto,
    If,
    IfBranch,
    JointsOf,
    Label,
    Literal,
    Name,
    Repeat,
    Statement,
    Tree,
    Use,
    While,
    negative,
)
from armdrive.programs.language.words import LINKS, OPERATORS, RESERVED, SHAPES, SPELLINGS, WORDS
from armdrive.programs.problems import Problem, SourceMark, lines_of
from kinematics.errors import suggestion

# Sentences about a line that cannot be read.

_FIRST = re.compile(r"\s*(?:\d+\s*:?\s*)?([A-Za-z_][A-Za-z0-9_]*)")


def mistake(error: UnexpectedInput, line: str, accepted: set[str]) -> tuple[int, str]:
    """Return the column of a mistake in a line, and a sentence about it.

    `accepted` are the terminals that the parser would have taken there.
    """
    if isinstance(error, UnexpectedCharacters):
        return error.column, _unknown_sign(line, error.column)
    token: Token = error.token  # type: ignore[attr-defined]
    column = (token.column or 1) if token else len(line.rstrip()) + 1
    first = _FIRST.match(line)
    if first is not None:
        found = _first_word(first, column)
        if found:
            return first.start(1) + 1, found
    if token.lower() in SHAPES and "NAME" in accepted:
        return column, f"`{token.lower()}` is a word of the language: choose another name"
    what = f"{str(token)!r} does not belong here" if token else "the line ends too early"
    if {"NUMBER", "LPAR"} <= accepted:
        what += ": a value is missing"
    elif "RPAR" in accepted:
        what += ": a `)` is missing"
    word = SPELLINGS.get(first[1].lower()) if first else None
    return column, f"{what}, as in `{WORDS[word].example}`" if word else what


def _unknown_sign(line: str, column: int) -> str:
    sign = line[column - 1] if column <= len(line) else ""
    if sign == '"':
        return 'the text has no end: a `"` is missing'
    return f"{sign!r} has no meaning in a program: names have the letters a to z, digits and _"


def _first_word(first: re.Match[str], column: int) -> str:
    """Return what is wrong with the first word of a line; "" if it is not to blame."""
    word, low = first[1], first[1].lower()
    rest = first.string[first.end(1) :].lstrip()
    if low in RESERVED and rest.startswith("=") and not rest.startswith("=="):
        return f"`{low}` is a word of the language: give the value another name"
    if low in RESERVED or column <= first.start(1) + 1 or rest.startswith(("=", ":", "(")):
        return ""
    meant = suggestion(low, (*SPELLINGS, *SHAPES))
    calls = f"; `{word} = ...` names a value, and `{word}(...)` calls a subprogram"
    return f"there is no word {word!r}{meant or calls}"


# Making a line from the tree that the parser finds.

# The operator of each spelling.
SIGNS: Mapping[str, str] = MappingProxyType(
    {spelt: row.name for row in OPERATORS.values() for spelt in (row.name, *row.also)}
)

_TRUE = ("on", "true")

# One of `into`, `by` and `within` with its values.
_Link: TypeAlias = tuple[str, tuple[Expression, ...]]
# The head of a block is a statement with an empty body; `else` is a branch, `end` its token.
_Core: TypeAlias = Statement | IfBranch | Token


@v_args(inline=True)
class _LineMaker(Transformer[Token, object]):
    """Makes a line of the program. Each method is named after a rule of the grammar."""

    def __init__(self, number: int, file: str) -> None:
        super().__init__()
        self._number = number
        self._file = file

    def _mark(self, token: Token) -> SourceMark:
        return SourceMark(self._number, token.column or 1, self._file)

    def line(self, *parts: Label | _Core) -> tuple[Label | _Core, ...]:
        return parts

    def label(self, name: Token) -> Label:
        return Label(str(name), mark=self._mark(name))

    def do(self, word: Token, *parts: list[Expression] | _Link) -> Do:
        arguments = tuple(value for part in parts if isinstance(part, list) for value in part)
        links = tuple(part for part in parts if isinstance(part, tuple))
        return Do(SPELLINGS[str(word).lower()], arguments, links, mark=self._mark(word))

    def link(self, word: Token, values: list[Expression]) -> _Link:
        return str(word).lower(), tuple(values)

    def assign(self, name: Token, value: Expression) -> Assign:
        return Assign(str(name), value, mark=self._mark(name))

    def point(self, name: Token, value: Expression) -> Assign:
        return Assign(str(name), value, point=True, mark=self._mark(name))

    def call(self, name: Token, values: Iterable[Expression] = ()) -> Call:
        return Call(str(name), tuple(values), mark=self._mark(name))

    def goto(self, target: Token) -> Goto:
        return Goto(str(target), mark=self._mark(target))

    def if_goto(self, word: Token, condition: Expression, target: Token) -> If:
        mark = self._mark(word)
        return If((IfBranch(condition, (self.goto(target),), mark=mark),), mark=mark)

    def if_(self, word: Token, condition: Expression) -> If:
        mark = self._mark(word)
        return If((IfBranch(condition, mark=mark),), mark=mark)

    def else_if(self, word: Token, condition: Expression) -> IfBranch:
        return IfBranch(condition, mark=self._mark(word))

    def else_(self, word: Token) -> IfBranch:
        return IfBranch(None, mark=self._mark(word))

    def while_(self, word: Token, condition: Expression) -> While:
        return While(condition, mark=self._mark(word))

    def repeat(self, word: Token, *parts: Expression | Token) -> Repeat:
        count = next((part for part in parts if not isinstance(part, Token)), None)
        name = next((str(part) for part in parts if isinstance(part, Token)), "")
        return Repeat(count, variable=name, mark=self._mark(word))

    def define(self, _: Token, name: Token, parameters: tuple[str, ...] = ()) -> Define:
        return Define(str(name), parameters, mark=self._mark(name))

    def names(self, *names: Token) -> tuple[str, ...]:
        return tuple(map(str, names))

    # -- values ------------------------------------------------------------------------------

    def arguments(self, *values: Expression) -> list[Expression]:
        return list(values)

    def number(self, text: Token) -> Literal:
        return Literal(float(text), mark=self._mark(text))

    def percent(self, text: Token) -> Literal:
        return Literal(float(text.rstrip("% \t")) / 100.0, percent=True, mark=self._mark(text))

    def text(self, quoted: Token) -> Literal:
        return Literal(quoted[1:-1].replace('""', '"'), mark=self._mark(quoted))

    def truth(self, word: Token) -> Literal:
        return Literal(word.lower() in _TRUE, mark=self._mark(word))

    def name(self, name: Token) -> Name:
        return Name(str(name), mark=self._mark(name))

    def use(self, name: Token, values: Iterable[Expression] = ()) -> Use:
        return Use(str(name).lower(), tuple(values), mark=self._mark(name))

    def joints(self, word: Token, *angles: tuple[str, Expression]) -> JointsOf:
        return JointsOf(angles, mark=self._mark(word))

    def joint(self, name: Token, angle: Expression) -> tuple[str, Expression]:
        return str(name).lower(), angle

    def field(self, value: Expression, name: Token) -> Use:
        return Use(f".{name.lower()}", (value,), mark=value.mark)

    def unary(self, sign: Token, value: Expression) -> Expression:
        mark = self._mark(sign)
        return negative(value, mark) if sign == "-" else Use("not", (value,), mark=mark)

    def binary(self, left: Expression, sign: Token, right: Expression) -> Use:
        spelling = " ".join(str(sign).lower().split())
        return Use(SIGNS[spelling], (left, right), mark=self._mark(sign))


# Reading a line.

# Characters. A longer line is a generator's mistake, and takes seconds to read.
LONGEST_LINE = 10_000

# Operators and brackets of a line. Each may nest a value one level deeper.
MOST_OPERATORS = 60

_NESTING = frozenset({
    "LPAR", "PLUS", "MINUS", "TIMES", "OVER", "COMPARE", "AND", "OR", "NOT", "DOT",
})  # fmt: skip


class LineMistake(Exception):
    """A line that cannot be read."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.text)
        self.problem = problem


@cache
def _grammar() -> Lark:
    """Return the parser of lines. Building it takes some 20 ms, so it is built when needed."""
    grammar = Path(__file__).with_name("program.lark").read_text("utf-8")
    shapes = (*SHAPES, "elseif")
    for name, words in (("words", SPELLINGS), ("links", LINKS), ("shapes", shapes)):
        longest_first = sorted(words, key=len, reverse=True)
        grammar = grammar.replace(f"@{name}@", "|".join(longest_first))
    return Lark(
        grammar,
        parser="lalr",
        lexer="contextual",
        maybe_placeholders=False,
        start="line",
    )


def _read(line: str, number: int, file: str) -> tuple[Label | _Core, ...]:
    """Return what a line says: a label, a statement, or both. Raises `LineMistake`."""

    def wrong(column: int, text: str) -> LineMistake:
        return LineMistake(Problem(SourceMark(number, column, file), text))

    if len(line) > LONGEST_LINE:
        raise wrong(LONGEST_LINE + 1, f"a line has at most {LONGEST_LINE} characters")
    parser, operators = _grammar().parse_interactive(line), 0
    try:
        for token in parser.iter_parse():
            operators += token.type in _NESTING
            if operators > MOST_OPERATORS:  # making the values would nest too many calls
                raise wrong(1, "this is nested too deeply: name its parts")
        found = parser.feed_eof()  # type: ignore[no-untyped-call] # lark's
    except UnexpectedInput as error:
        accepted = parser.accepts()  # type: ignore[no-untyped-call] # lark's
        column, text = mistake(error, line, accepted)
        raise wrong(column, text) from None
    made = _LineMaker(number, file).transform(found)
    return cast("tuple[Label | _Core, ...]", made)


# Nesting the lines.

# A longer text is not a program, and reading it could take minutes.
MOST_LINES = 10_000

# The most levels of blocks.
DEEPEST_BLOCK = 30

_HEADS = (If, While, Repeat, Define)
_HEAD = re.compile(r"\s*(if|while|repeat|define)(?!\w)", re.IGNORECASE)


_PROGRAM = Define("", ())


@dataclass(slots=True)
class _OpenBlock:
    """A block whose end has not come yet; `lines` are those of the last branch of an `if`.

    The first one is the program itself. One that could not be read stands for what it may be.
    """

    head: If | While | Repeat | Define
    lines: list[Statement] = field(default_factory=list)
    unread: bool = False

    def closed(self) -> If | While | Repeat | Define:
        """Return its head with its lines."""
        body = tuple(self.lines)
        if isinstance(self.head, If):
            *before, last = self.head.branches
            return replace(self.head, branches=(*before, replace(last, body=body)))
        return replace(self.head, body=body)


class ProgramReader:
    """Reads a program line by line. A line that cannot be read leaves it as it was."""

    def __init__(self, file: str = "") -> None:
        self._file = file
        self._open = [_OpenBlock(_PROGRAM)]

    @property
    def unfinished(self) -> bool:
        """Whether the end of a block has not come yet."""
        return len(self._open) > 1

    def take(self, line: str, number: int = 1) -> None:
        """Take the next line. Raises `LineMistake`."""
        parts = _read(line, number, self._file)
        wrong = "".join(map(self._misplaced, parts))
        if wrong:
            column = len(line) - len(line.lstrip()) + 1
            raise LineMistake(Problem(SourceMark(number, column, self._file), wrong))
        for part in parts:
            block = self._open[-1]
            match part:
                case Token():  # `end`
                    self._open.pop()
                    self._open[-1].lines.append(block.closed())
                case IfBranch():
                    before = cast("If", block.closed()).branches
                    block.head, block.lines = If((*before, part), mark=before[0].mark), []
                case If(branches=(IfBranch(body=()),)) | While() | Repeat() | Define():
                    self._open.append(_OpenBlock(part))
                case _:
                    block.lines.append(part)

    def _misplaced(self, core: Label | _Core) -> str:
        """Return why a line cannot stand where it does, if it is so."""
        head = self._open[-1].head
        if isinstance(core, Token) and head is _PROGRAM:
            return "this `end` ends nothing"
        if isinstance(core, IfBranch) and not (
            isinstance(head, If) and head.branches[-1].condition is not None
        ):
            return "this `else` belongs to no `if`; nothing comes after `else` but `end`"
        if isinstance(core, Define) and head is not _PROGRAM:
            return "a subprogram cannot be defined within a block"
        if isinstance(core, _HEADS) and len(self._open) > DEEPEST_BLOCK:
            return f"at most {DEEPEST_BLOCK} blocks are nested"
        return ""

    def leave_out(self, line: str, number: int) -> None:
        """Note a line that cannot be read. If it begins a block, an empty one stands for it.

        So the `else` and the `end` of that block are no mistakes.
        """
        if _HEAD.match(line) and len(self._open) <= DEEPEST_BLOCK:
            mark = self._mark(number)
            some = If((IfBranch(Literal(True, mark=mark), mark=mark),), mark=mark)
            self._open.append(_OpenBlock(some, unread=True))

    def finish(self) -> tuple[Tree, list[Problem]]:
        """End the program; return its tree, and a problem for each block without an end."""
        problems = []
        while self.unfinished:
            block = self._open.pop()
            whole = block.closed()
            if not block.unread:
                word = type(whole).__name__.lower()
                problems.append(Problem(whole.mark, f"this `{word}` has no `end`"))
            # so that the lines that were read make a tree and are checked too
            self._open[-1].lines.append(whole)
        return Tree(tuple(self._open[0].lines)), problems

    def _mark(self, number: int) -> SourceMark:
        return SourceMark(number, 1, self._file)


def read_tree(text: str, file: str = "") -> tuple[Tree, list[Problem]]:
    """Return the tree of the readable lines of a program, and the problems of the others."""
    reader, problems = ProgramReader(file), list[Problem]()
    lines = lines_of(text)
    if len(lines) > MOST_LINES:
        mark = SourceMark(MOST_LINES + 1, 1, file)
        return Tree(()), [Problem(mark, f"a program has at most {MOST_LINES} lines")]
    if lines[-1] == "":
        lines.pop()  # a line break at the end is not followed by a blank line
    for number, line in enumerate(lines, start=1):
        try:
            reader.take(line, number)
        except LineMistake as error:
            problems.append(error.problem)
            reader.leave_out(line, number)
    tree, unended = reader.finish()
    return tree, [*problems, *unended]
