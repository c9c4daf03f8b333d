"""The parser of programs, and the sentences about mistakes.

One grammar, program.lark, describes a whole program. The parser is fed line by line, so one mistake
hides no other: a line that does not fit is left out, and the parser goes on where it was before
that line. A prompt feeds the same parser with the lines as they are typed.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias, cast

from lark import Lark, Token, Transformer, UnexpectedCharacters, UnexpectedInput, v_args
from lark.parsers.lalr_interactive_parser import InteractiveParser

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
    Remark,
    Repeat,
    Statement,
    Tree,
    Use,
    While,
    negative,
)
from armdrive.programs.language.words import LINKS, OPERATORS, RESERVED, SHAPES, SPELLINGS
from armdrive.programs.problems import Problem, SourceMark, lines_of
from kinematics.errors import suggestion

# Sentences about a line that cannot be read.

# Words of other languages and of older programs, and what to write instead.
FOREIGN: Mapping[str, str] = MappingProxyType({
    "for": "`repeat 3 as i`",
    "elif": "`else if`",
    "endif": "`end`",
    "wend": "`end`",
    "next": "`end` or `continue`",
    "until": "`while not ...`",
    "print": "`type`",
    "say": "`type`",
    "sleep": "`delay`",
    "wait": "`wait_input 2` to wait for input 2, or `delay 2` to wait for 2 seconds",
    "gosub": "the name of a subprogram, as `fetch(pick)`",
    "call": "the name of a subprogram, as `fetch(pick)`",
    "def": "`define`",
    "sub": "`define`",
    "let": "`x = 3`",
    "set": "`x = 3`",
})  # fmt: skip

_CHANGES = (":=", "+=", "-=", "*=", "/=")

_FIRST = re.compile(r"\s*(?:\d+\s*:?\s*)?([A-Za-z_][A-Za-z0-9_]*)")

# Names of the terminals that the parser expects; "" for those that would only be noise.
_EXPECTED: Mapping[str, str] = MappingProxyType({
    "NUMBER": "a value", "PERCENT": "a value", "TEXT": "a value", "TRUTH": "a value",
    "JOINTS": "a value", "LPAR": "", "NOT": "a value", "MINUS": "",
    "RPAR": "`)`", "COMMA": "a comma", "EQUAL": "`=`", "NAME": "a name",
    "BREAK": "the end of the line", "$END": "the end of the line",
    "PLUS": "", "TIMES": "", "OVER": "", "OR": "", "AND": "", "COMPARE": "", "DOT": "",
    "COMMENT": "", "COLON": "", "WORD": "a word", "LINK": "",
})  # fmt: skip

# Sentences about words that the parser takes, but not where they are.
_MISPLACED: Mapping[str, str] = MappingProxyType({
    "END": "this `end` ends nothing",
    "ELSE": "this `else` belongs to no `if`; nothing comes after `else` but `end`",
    "ELSEIF": "this `else` belongs to no `if`; nothing comes after `else` but `end`",
    "DEFINE": "a subprogram cannot be defined within a block",
})  # fmt: skip


def mistake(
    error: UnexpectedInput, line: str, accepted: set[str], *, statement: bool = True
) -> tuple[int, str]:
    """Return the column of a mistake in a line, and a sentence about it.

    `accepted` are the terminals that the parser would have taken there. A `statement` begins with a
    word, values alone do not.
    """
    if isinstance(error, UnexpectedCharacters):
        return error.column, _unknown_sign(line, error.column)
    token: Token = error.token  # type: ignore[attr-defined]
    column = (token.column or 1) if token else len(line.rstrip()) + 1
    if token.type in _MISPLACED and not line[: column - 1].strip():
        return column, _MISPLACED[token.type]
    first = _first_word(line, column) if statement else None
    if first is not None:
        return first
    if not token:
        return column, f"the line ends too early{_wanted(accepted)}"
    if token.lower() in SHAPES and "NAME" in accepted:
        return column, f"`{token.lower()}` is a word of the language: choose another name"
    return column, f"{str(token)!r} does not belong here{_wanted(accepted)}"


def _unknown_sign(line: str, column: int) -> str:
    sign = line[column - 1] if column <= len(line) else ""
    if sign == '"':
        return 'the text has no end: a `"` is missing'
    if sign.isalpha():
        return f"{sign!r} cannot stand in a name: names have the letters a to z, digits and _"
    return f"{sign!r} has no meaning in a program"


def _first_word(line: str, column: int) -> tuple[int, str] | None:
    """Return the mistake in the first word of a line, if there is one."""
    match = _FIRST.match(line)
    if match is None:
        return None
    word, at = match[1], match.start(1) + 1
    rest = line[match.end(1) :].lstrip()
    low = word.lower()
    if low in RESERVED and rest.startswith("=") and not rest.startswith("=="):
        return at, f"`{low}` is a word of the language: give the value another name"
    if rest.startswith(_CHANGES):
        return at, f"to name a value, write `{word} = ...`"
    known = low in SPELLINGS or low in SHAPES or low in RESERVED
    if known or column <= at or rest.startswith(("=", ":", "(")):
        return None
    return at, unknown_word(word, (*SPELLINGS, *SHAPES)) or (
        f"there is no word {word!r}; a subprogram takes its values in brackets: `{word}(...)`"
    )


def unknown_word(word: str, known: Iterable[str]) -> str:
    """Return a sentence about an unknown word and what to write instead; "" without a guess."""
    low = word.lower()
    if low in FOREIGN:
        return f"there is no word {word!r}; write {FOREIGN[low]}"
    near = suggestion(low, known)
    return f"there is no word {word!r}{near}" if near else ""


def _wanted(expected: set[str]) -> str:
    if "NUMBER" in expected and "LPAR" in expected:
        return ": a value is missing"
    if "WORD" in expected:
        return ": a number at the beginning of a line is a label, and a word comes after it"
    named = {_EXPECTED.get(each, f"`{each.lower()}`") for each in expected} - {""}
    listed = sorted(named)
    if not listed:
        return ""
    return ": " + " or ".join(listed) + " was expected"


# Making the parts of a program as the parser finds them.

# The operator of each spelling.
SIGNS: Mapping[str, str] = MappingProxyType(
    {spelt: row.name for row in OPERATORS.values() for spelt in (row.name, *row.also)}
)

_TRUE = ("on", "true")

_Body: TypeAlias = tuple[Statement, ...]
_Branches: TypeAlias = tuple[IfBranch, ...]
# One of `into`, `by` and `within` with its values.
_Link: TypeAlias = tuple[str, tuple[Expression, ...]]


@v_args(inline=True)
class _TreeMaker(Transformer[Token, Tree]):
    """Makes lines and values, with their places, as the parser finds them.

    Each method is named after a rule of the grammar, and is called with the rule's parts. `note` is
    the comment at the end of a line, None without one.

    Whatever spans several lines is a tuple that grows by copying, and not a repetition of the
    grammar: lark extends the list of a repetition in place, and a line that turns out to be wrong
    could not be undone.
    """

    def __init__(self) -> None:
        super().__init__()
        self.file = ""

    def _mark(self, token: Token) -> SourceMark:
        return SourceMark(token.line or 1, token.column or 1, self.file)

    def program(self, lines: _Body) -> Tree:
        return Tree(lines)

    def values(self, values: list[Expression], *_: Token) -> list[Expression]:
        return values

    # -- lines -------------------------------------------------------------------------------

    def empty(self) -> _Body:
        return ()

    def joined(self, lines: _Body, more: _Body) -> _Body:
        return lines + more

    def line(self, *parts: Statement) -> _Body:
        *before, note = parts
        if not isinstance(note, Remark) or not before or note.text is None:
            return tuple(before) or parts
        return (*before[:-1], _noted(before[-1], note.text))

    def block_line(self, *parts: Label | _Body) -> _Body:
        return tuple(chain.from_iterable(p if isinstance(p, tuple) else (p,) for p in parts))

    def note(self, *tokens: Token) -> Remark:
        text = tokens[0][1:].removeprefix(" ").rstrip() if len(tokens) > 1 else None
        return Remark(text, mark=self._mark(tokens[0]))

    def end(self, note: Remark) -> _Body:
        return () if note.text is None else (note,)

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
        goto = Goto(str(target), mark=self._mark(target))
        return If((IfBranch(condition, (goto,), mark=mark),), mark=mark)

    # -- blocks: a head is a statement without a body --------------------------------------------

    def if_(self, branches: _Branches, *rest: Any) -> _Body:
        *other, end = rest
        return (If(branches + (other[0] if other else ()), mark=branches[0].mark), *end)

    def branch(self, word: Token, *parts: Any) -> _Branches:
        *condition, note, body = parts
        found = condition[0] if condition else None
        return (IfBranch(found, body, mark=self._mark(word), note=note.text or ""),)

    def other_branch(self, branches: _Branches, *parts: Any) -> _Branches:
        return branches + self.branch(*parts)

    def loop(self, head: While | Repeat, note: Remark, body: _Body, end: _Body) -> _Body:
        return (replace(head, body=body, note=note.text or ""), *end)

    def while_(self, word: Token, condition: Expression) -> While:
        return While(condition, mark=self._mark(word))

    def repeat(self, word: Token, *parts: Expression | Token) -> Repeat:
        count = next((part for part in parts if not isinstance(part, Token)), None)
        name = next((str(part) for part in parts if isinstance(part, Token)), "")
        return Repeat(count, variable=name, mark=self._mark(word))

    def definition(self, *parts: Any) -> _Body:
        *label, head, note, body, end = parts
        return (*label, replace(head, body=body, note=note.text or ""), *end)

    def define(self, name: Token, parameters: tuple[str, ...] = ()) -> Define:
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


def _noted(line: Statement, note: str) -> Statement:
    """Return a line with the comment at its end."""
    match line:
        case If(branches=(branch, *_)):  # `if ... then goto ...`
            return replace(line, branches=(replace(branch, note=note),))
        case Do() | Assign() | Call() | Label() | Goto():
            return replace(line, note=note)
        case _:
            return line


# Reading line by line.

# Characters. A longer line is a generator's mistake, and takes seconds to read.
LONGEST_LINE = 10_000

# A longer text is not a program, and reading it could take minutes.
MOST_LINES = 10_000

# The most levels of blocks.
DEEPEST_BLOCK = 30

# Operators and brackets of a line. Each may nest a value one level deeper.
MOST_OPERATORS = 60

_NESTING = frozenset({
    "LPAR", "PLUS", "MINUS", "TIMES", "OVER", "COMPARE", "AND", "OR", "NOT", "DOT",
})  # fmt: skip
# The terminals that begin a block.
_OPENING = ("IF", "WHILE", "REPEAT", "DEFINE")

_HEAD = re.compile(rf"\s*({'|'.join(_OPENING)})(?!\w)", re.IGNORECASE)


class LineMistake(Exception):
    """A line that cannot be read."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.text)
        self.problem = problem


class _SharedParser:
    """The parser of all programs. Building it takes some 20 ms, so it is built when needed."""

    def __init__(self) -> None:
        self.maker = _TreeMaker()
        self.lock = threading.Lock()
        grammar = Path(__file__).with_name("program.lark").read_text("utf-8")
        for name, words in (
            ("words", SPELLINGS),
            ("links", LINKS),
            ("shapes", (*SHAPES, "elseif")),
        ):
            longest_first = sorted(words, key=len, reverse=True)
            grammar = grammar.replace(f"@{name}@", "|".join(longest_first))
        self.lark = Lark(
            grammar,
            parser="lalr",
            lexer="contextual",
            maybe_placeholders=False,
            start=["program", "values"],
            transformer=self.maker,
        )


_shared = cache(_SharedParser)


class ProgramReader:
    """Reads a program line by line. A line that cannot be read leaves it as it was.

    `start` is the rule of the grammar that the text follows.
    """

    def __init__(self, file: str = "", start: str = "program") -> None:
        self._file = file
        self._start = start
        self._parser = _shared().lark.parse_interactive("", start=start)

    @property
    def open_blocks(self) -> list[Problem]:
        """The blocks whose `end` has not come yet; one that stands for an unread line has no text.

        They are on the parser's stack: an `if` as its word, or as its branches once there is an
        `else`; the others as statements without a body.
        """
        found: list[Problem] = []
        for value in self._parser.parser_state.value_stack:
            match value:
                case Token(type="IF"):
                    found.append(self._unended(self._mark(value.line, value.column), value))
                case (IfBranch(condition=condition) as first, *_) if condition is not None:
                    found.append(self._unended(first.mark, "if"))
                case While() | Repeat() | Define():
                    found.append(self._unended(value.mark, type(value).__name__))
                case Token(type="END"):
                    found.pop()
        return found

    def take(self, line: str, number: int = 1, end: str = "BREAK") -> object:
        """Take the next line; `end` is the terminal after it. Raises `LineMistake`."""
        if len(line) > LONGEST_LINE:
            text = f"a line has at most {LONGEST_LINE} characters"
            raise self._mistake(number, LONGEST_LINE + 1, text)
        deepest, operators = len(self.open_blocks) == DEEPEST_BLOCK, 0
        # a copy reads the line, and becomes the parser only if all of the line fits
        parser, found, last = self._copy(line), None, None
        try:
            for token in _tokens(parser, number, end):
                operators += token.type in _NESTING
                if operators > MOST_OPERATORS:
                    raise self._mistake(number, 1, "this is nested too deeply: name its parts")
                if token.type in _OPENING and deepest:
                    raise self._mistake(number, 1, f"at most {DEEPEST_BLOCK} blocks are nested")
                found = self._feed(parser, token)
                last = token
        except UnexpectedInput as error:
            accepted = (self._parser if last is None else parser).accepts()  # type: ignore[no-untyped-call] # lark's
            column, text = mistake(error, line, accepted, statement=end == "BREAK")
            raise self._mistake(number, column, text) from None
        self._parser = parser
        return found

    def _copy(self, line: str) -> InteractiveParser:
        """Return a parser that stands where this one stands, before a line."""
        copied = _shared().lark.parse_interactive(line, start=self._start)
        state, present = copied.parser_state, self._parser.parser_state
        state.state_stack, state.value_stack = [*present.state_stack], [*present.value_stack]
        return copied

    def leave_out(self, line: str, number: int) -> None:
        """Note a line that cannot be read. If it begins a block, an empty one stands for it.

        So the `else` and the `end` of that block are no mistakes.
        """
        if _HEAD.match(line) and len(self.open_blocks) < DEEPEST_BLOCK:
            for kind, text in (("IF", ""), ("TRUTH", "on"), ("BREAK", "")):
                self._feed(self._parser, Token(kind, text, line=number, column=1))

    def finish(self) -> tuple[Tree, list[Problem]]:
        """End the program; return its tree, and a problem for each block without an end."""
        blocks = self.open_blocks
        # end what is open, so that the lines that were read make a tree and are checked too
        for token in (Token("END", "end"), Token("BREAK", "")) * len(blocks):
            self._feed(self._parser, token)
        tree = cast("Tree", self._feed(self._parser, Token("$END", "")))
        return tree, [problem for problem in blocks if problem.text]

    def _unended(self, mark: SourceMark, word: str) -> Problem:
        return Problem(mark, f"this `{word.lower()}` has no `end`" if word else "")

    def _feed(self, parser: InteractiveParser, token: Token) -> object:
        shared = _shared()
        with shared.lock:
            shared.maker.file = self._file
            return parser.feed_token(token)

    def _mark(self, line: int | None, column: int | None) -> SourceMark:
        return SourceMark(line or 1, column or 1, self._file)

    def _mistake(self, number: int, column: int, text: str) -> LineMistake:
        return LineMistake(Problem(self._mark(number, column), text))


def _tokens(parser: InteractiveParser, number: int, end: str) -> Iterator[Token]:
    """Yield the tokens of a parser's line, whose number is given, and the terminal after it."""
    for token in parser.lexer_thread.lex(parser.parser_state):  # type: ignore[no-untyped-call] # lark's
        token.line = number
        yield token
    yield Token(end, "", line=number, column=1)


def read_values(line: str, number: int = 1, file: str = "") -> tuple[Expression, ...]:
    """Return the values of a line that has nothing else. Raises `LineMistake`."""
    reader = ProgramReader(file, start="values")
    return tuple(cast("list[Expression]", reader.take(line, number, end="$END")))


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
