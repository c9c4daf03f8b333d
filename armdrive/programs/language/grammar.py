"""The grammar of programs, the parser made from it, and the sentences about mistakes.

A program is read line by line, so one mistake hides no other, and a prompt reads what is typed by
the same rules. Then the lines are put together to blocks. Lines that cannot be read are left out.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from types import MappingProxyType
from typing import TypeAlias, cast

from lark import (
    Lark,
    Token,
    Transformer,
    UnexpectedCharacters,
    UnexpectedInput,
    UnexpectedToken,
    v_args,
)
from lark import Tree as ParseTree

from armdrive.programs.language.syntax import (
    Assign,
    Binary,
    Call,
    Define,
    Do,
    Expression,
    FieldOf,
    Goto,
    If,
    IfBranch,
    JointsOf,
    Label,
    Name,
    Number,
    Remark,
    Repeat,
    Statement,
    TextValue,
    Tree,
    Truth,
    Unary,
    Use,
    While,
    negative,
)
from armdrive.programs.language.values import OPERATORS
from armdrive.programs.language.words import LINKS, RESERVED, SHAPES, SPELLINGS
from armdrive.programs.problems import Problem, SourceMark, lines_of, program_error
from kinematics.errors import suggestion

GRAMMAR = r"""
start: label? statement? COMMENT?

label: (NAME | NUMBER) ":" | NUMBER

?statement: do | assign | point | call | goto | if_goto
          | define | if_ | else_if | else_ | while_ | repeat | end

do: WORD arguments? link*
link: LINK arguments
assign: NAME "=" expr
point: "point"i NAME "=" expr
call: NAME ("(" arguments? ")")?
goto: "goto"i target
target: NAME | NUMBER
if_goto: IF expr "then"i "goto"i? target
define: "define"i NAME ("(" names? ")")?
names: NAME ("," NAME)*
if_: IF expr "then"i?
else_if: (ELSE "if"i | ELSEIF) expr "then"i?
else_: ELSE
while_: WHILE expr
repeat: REPEAT expr? ("as"i NAME)?
end: END

arguments: expr ("," expr)*

?expr: expr OR both -> binary
     | both
?both: both AND negated -> binary
     | negated
?negated: NOT negated -> unary
        | comparison
?comparison: sum COMPARE sum -> binary
           | sum
?sum: sum (PLUS | MINUS) product -> binary
    | product
?product: product (TIMES | OVER) signed -> binary
        | signed
?signed: MINUS signed -> unary
       | part
?part: part "." NAME -> field
     | atom
?atom: NUMBER -> number
     | PERCENT -> percent
     | TEXT -> text
     | TRUTH -> truth
     | NAME -> name
     | NAME "(" arguments? ")" -> use
     | JOINTS "(" joint ("," joint)* ")" -> joints
     | "(" expr ")" -> inner
joint: NAME sum

IF: "if"i
ELSE: "else"i
ELSEIF: "elseif"i
WHILE: "while"i
REPEAT: "repeat"i
END: "end"i
WORD.3: /(@words@)(?![a-z0-9_])/i
LINK.3: /(@links@)(?![a-z0-9_])/i
TRUTH.3: /(true|false|on|off)(?![a-z0-9_])/i
JOINTS.3: /joints(?![a-z0-9_])/i
COMPARE.3: /==|!=|<>|<=|>=|<|>|=|(is\s+not|is|eq|ne|lt|le|gt|ge)(?![a-z0-9_])/i
OR.3: /or(?![a-z0-9_])/i
AND.3: /and(?![a-z0-9_])/i
NOT.3: /not(?![a-z0-9_])/i
NAME: /[a-z_][a-z0-9_]*/i
PERCENT.3: /(([0-9]+(\.[0-9]*)?|\.[0-9]+)(e[+-]?[0-9]+)?)[ \t]*%/i
NUMBER.2: /([0-9]+(\.[0-9]*)?|\.[0-9]+)(e[+-]?[0-9]+)?/i
TEXT: /"([^"]|"")*"/
PLUS: "+"
MINUS: "-"
TIMES: "*"
OVER: "/"
COMMENT: /#.*/s

%ignore /[ \t]+/
"""
"""In lark's notation; the words come from the vocabulary."""


def _parser(reader: _LineReader | None) -> Lark:
    """Return a parser of lines: into items with a reader, else into lark's own trees."""
    longest_first = sorted(SPELLINGS, key=len, reverse=True)
    grammar = GRAMMAR.replace("@words@", "|".join(longest_first))
    grammar = grammar.replace("@links@", "|".join(LINKS))
    return Lark(
        grammar, parser="lalr", lexer="contextual", maybe_placeholders=False, transformer=reader
    )


# Sentences about a line that cannot be read.

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
"""Words of other languages and of older programs, and what to write instead."""

_CHANGES = (":=", "+=", "-=", "*=", "/=")

_FIRST = re.compile(r"\s*(?:\d+\s*:?\s*)?([A-Za-z_][A-Za-z0-9_]*)")

_EXPECTED: Mapping[str, str] = MappingProxyType({
    "NUMBER": "a value", "PERCENT": "a value", "TEXT": "a value", "TRUTH": "a value",
    "JOINTS": "a value", "LPAR": "", "NOT": "a value", "MINUS": "",
    "RPAR": "`)`", "COMMA": "a comma", "EQUAL": "`=`", "NAME": "a name",
    "$END": "the end of the line",
    "PLUS": "", "TIMES": "", "OVER": "", "OR": "", "AND": "", "COMPARE": "", "DOT": "",
    "COMMENT": "", "COLON": "", "WORD": "a word", "LINK": "",
})  # fmt: skip
"""Names of the terminals that the parser expects; "" for those that would only be noise."""


def mistake(error: UnexpectedInput, line: str) -> tuple[int, str]:
    """Return the column of a mistake in a line, and a sentence about it."""
    if isinstance(error, UnexpectedCharacters):
        return error.column, _unknown_sign(line, error.column)
    column = getattr(error, "column", None)
    token = getattr(error, "token", None)
    if column is None or column < 1 or token is None or token.type == "$END":
        column, found = len(line.rstrip()) + 1, ""
    else:
        found = str(token)
    first = _first_word(line, column)
    if first is not None:
        return first
    expected = set(error.accepts or ()) if isinstance(error, UnexpectedToken) else set()
    wanted = _wanted(expected)
    if not found:
        return column, f"the line ends too early{wanted}"
    return column, f"{found!r} does not belong here{wanted}"


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


# Reading one line.

DEEPEST_VALUE = 60
"""The most levels of a value. Anything deeper is unreadable, and a generator's mistake."""

LONGEST_LINE = 10_000
"""Characters. A longer line is a generator's mistake, and takes seconds to read."""

SIGNS: Mapping[str, str] = MappingProxyType(
    {spelt: row.sign for row in OPERATORS.values() for spelt in (row.sign, *row.also)}
)
"""The operator of each spelling."""

_TRUE = ("on", "true")


@dataclass(frozen=True, slots=True)
class End:
    """`end`."""

    mark: SourceMark


@dataclass(frozen=True, slots=True)
class Unread:
    """The unreadable head of a block, which is left out with its `end`."""

    mark: SourceMark


Block: TypeAlias = If | While | Repeat | Define
Item: TypeAlias = Statement | IfBranch | End | Unread
"""The content of a line. A block's head is its statement without a body; `else` is a branch."""

_Link: TypeAlias = tuple[str, tuple[Expression, ...]]
"""One of `into`, `by` and `within` with its values."""


def opens(item: Item) -> bool:
    """Return whether an item begins a block, which `end` ends."""
    if isinstance(item, If):
        return not item.branches[0].body  # `if ... goto ...` is complete in one line
    return isinstance(item, While | Repeat | Define | Unread)


class LineMistake(Exception):
    """A line that cannot be read."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.text)
        self.problem = problem


def read_line(line: str, number: int = 1, file: str = "") -> list[Item]:
    """Return the items of a line: a label, a statement or the head of a block, a comment.

    Raises `LineMistake`.
    """
    if not line.strip(" \t"):
        return [Remark(mark=SourceMark(number, 1, file))]
    if len(line) > LONGEST_LINE:
        mark = SourceMark(number, LONGEST_LINE + 1, file)
        raise LineMistake(Problem(mark, f"a line has at most {LONGEST_LINE} characters"))
    try:
        if len(_NESTS.findall(line)) > DEEPEST_VALUE // 3 and _depth(line) > DEEPEST_VALUE:
            text = "this is nested too deeply: give its parts names"
            raise LineMistake(Problem(SourceMark(number, 1, file), text))
        return _line_parser().read(line, number, file)
    except UnexpectedInput as error:
        column, text = mistake(error, line)
        raise LineMistake(Problem(SourceMark(number, column, file), text)) from None


_NESTS = re.compile(r"[-(+*/<>=.]|\b(?:and|or|not|is)\b", re.IGNORECASE)
"""Signs and words of which each nests a value at most three levels deeper in lark's tree."""


class _LineParser:
    """Parses lines straight into items, one at a time."""

    def __init__(self) -> None:
        self._reader = _LineReader()
        self._lark = _parser(self._reader)
        self._lock = threading.Lock()

    def read(self, line: str, number: int, file: str) -> list[Item]:
        """Return the items of a line. Raises lark's `UnexpectedInput`."""
        with self._lock:
            self._reader.at_line, self._reader.in_file = number, file
            return cast("list[Item]", self._lark.parse(line))


_line_parser = cache(_LineParser)
"""Building a parser takes some 20 ms, so it is built when the first line is read."""

_tree_parser = cache(partial(_parser, None))
"""Builds trees of which the depth can be measured before values are made of them."""


def _depth(line: str) -> int:
    """Return how many levels the parse tree of a line has."""
    deepest, waiting = 0, [(_tree_parser().parse(line), 1)]
    while waiting:
        found, depth = waiting.pop()
        deepest = max(deepest, depth)
        waiting += [(each, depth + 1) for each in found.children if isinstance(each, ParseTree)]
    return deepest


@v_args(inline=True)
class _LineReader(Transformer[Token, list[Item]]):
    """Makes items and values, with their places, as the parser finds them.

    Each method is named after a rule of the grammar, and is called with the rule's parts.
    """

    def __init__(self) -> None:
        super().__init__()
        self.at_line = 1
        self.in_file = ""

    def _mark(self, token: Token) -> SourceMark:
        return SourceMark(self.at_line, token.column or 1, self.in_file)

    def start(self, *parts: Item | Token) -> list[Item]:
        items = [part for part in parts if not isinstance(part, Token)]
        note = next((part for part in parts if isinstance(part, Token)), None)
        if note is None:
            return items
        text = note[1:].removeprefix(" ").rstrip()
        match items[-1] if items else None:
            case If(branches=(branch,)) as last:
                return [*items[:-1], replace(last, branches=(replace(branch, note=text),))]
            case (
                Do() | Assign() | Call() | Label() | Goto() | While() | Repeat() | Define() as last
            ):
                return [*items[:-1], replace(last, note=text)]
            case _:
                return [*items, Remark(text, mark=self._mark(note))]

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

    def target(self, name: Token) -> Token:
        return name

    def if_goto(self, word: Token, condition: Expression, target: Token) -> If:
        mark = self._mark(word)
        goto = Goto(str(target), mark=self._mark(target))
        return If((IfBranch(condition, (goto,), mark=mark),), mark=mark)

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

    def define(self, name: Token, parameters: tuple[str, ...] = ()) -> Define:
        return Define(str(name), parameters, mark=self._mark(name))

    def names(self, *names: Token) -> tuple[str, ...]:
        return tuple(map(str, names))

    def end(self, word: Token) -> End:
        return End(self._mark(word))

    # -- values ------------------------------------------------------------------------------

    def arguments(self, *values: Expression) -> list[Expression]:
        return list(values)

    def number(self, text: Token) -> Number:
        return Number(float(text), mark=self._mark(text))

    def percent(self, text: Token) -> Number:
        return Number(float(text.rstrip("% \t")) / 100.0, percent=True, mark=self._mark(text))

    def text(self, quoted: Token) -> TextValue:
        return TextValue(quoted[1:-1].replace('""', '"'), mark=self._mark(quoted))

    def truth(self, word: Token) -> Truth:
        return Truth(word.lower() in _TRUE, mark=self._mark(word))

    def name(self, name: Token) -> Name:
        return Name(str(name), mark=self._mark(name))

    def use(self, name: Token, values: Iterable[Expression] = ()) -> Use:
        return Use(str(name).lower(), tuple(values), mark=self._mark(name))

    def joints(self, word: Token, *angles: tuple[str, Expression]) -> JointsOf:
        return JointsOf(angles, mark=self._mark(word))

    def joint(self, name: Token, angle: Expression) -> tuple[str, Expression]:
        return str(name).lower(), angle

    def field(self, value: Expression, name: Token) -> FieldOf:
        return FieldOf(value, str(name).lower(), mark=value.mark)

    def inner(self, value: Expression) -> Expression:
        return value

    def unary(self, sign: Token, value: Expression) -> Expression:
        mark = self._mark(sign)
        return negative(value, mark) if sign == "-" else Unary("not", value, mark=mark)

    def binary(self, left: Expression, sign: Token, right: Expression) -> Binary:
        spelling = " ".join(str(sign).lower().split())
        return Binary(left, SIGNS[spelling], right, mark=self._mark(sign))


# Putting lines together to blocks.

DEEPEST_BLOCK = 30
"""The most levels of blocks."""

MOST_LINES = 10_000
"""A longer text is not a program, and reading it could take minutes."""

_OPENING = re.compile(r"\s*(if|while|repeat|define)(?!\w)", re.IGNORECASE)


def parse(text: str, file: str = "") -> Tree:
    """Return the tree of a program. Raises `ProgramError` with every unreadable line."""
    tree, problems = read_tree(text, file)
    if problems:
        raise program_error(problems, text)
    return tree


def read_tree(text: str, file: str = "", first: int = 1) -> tuple[Tree, list[Problem]]:
    """Return the tree of the readable lines of a program, and the problems of the others.

    The first line has the number `first`.
    """
    blocks = _Blocks()
    lines = lines_of(text)
    if len(lines) > MOST_LINES:
        mark = SourceMark(MOST_LINES + 1, 1, file)
        return blocks.whole(), [Problem(mark, f"a program has at most {MOST_LINES} lines")]
    if lines[-1] == "":
        lines.pop()  # a line break at the end is not followed by a blank line
    for number, line in enumerate(lines, start=first):
        try:
            items = read_line(line, number, file)
        except LineMistake as error:
            blocks.problems.append(error.problem)
            unread = _OPENING.match(line) is not None
            items = [Unread(error.problem.mark)] if unread else []
        for item in items:
            blocks.take(item)
    return blocks.whole(), blocks.problems


@dataclass(slots=True)
class _Open:
    """A block whose end has not come yet; for an `if`, with the finished branches."""

    head: Block | Unread
    branch: IfBranch | None = None
    body: list[Statement] = field(default_factory=list)
    branches: list[IfBranch] = field(default_factory=list)

    def close_branch(self, following: IfBranch | None = None) -> None:
        """End the present branch, and begin the next."""
        if self.branch is not None:
            self.branches.append(replace(self.branch, body=tuple(self.body)))
        self.branch, self.body = following, []


class _Blocks:
    """Puts lines together to blocks."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self._top: list[Statement] = []
        self._open: list[_Open] = []

    def take(self, item: Item) -> None:
        """Take the next line."""
        match item:
            case End():
                self._end(item)
            case IfBranch():
                self._else(item)
            case Unread():
                self._begin(item)
            case If() | While() | Repeat() | Define() if opens(item):
                self._begin(item)
            case _:
                self._body().append(item)

    def whole(self) -> Tree:
        """Return the tree of all lines."""
        for block in self._open:
            if not isinstance(block.head, Unread):
                word = type(block.head).__name__.lower()
                self._wrong(block.head.mark, f"this `{word}` has no `end`")
        return Tree(tuple(self._top))

    def _body(self) -> list[Statement]:
        return self._open[-1].body if self._open else self._top

    def _begin(self, head: Block | Unread) -> None:
        if isinstance(head, Define) and self._open:
            self._wrong(head.mark, "a subprogram cannot be defined within a block")
        if len(self._open) == DEEPEST_BLOCK:
            self._wrong(head.mark, f"blocks are nested at most {DEEPEST_BLOCK} deep")
        self._open.append(_Open(head, head.branches[0] if isinstance(head, If) else None))

    def _else(self, item: IfBranch) -> None:
        block = self._open[-1] if self._open else None
        if block is not None and isinstance(block.head, Unread):
            return
        if block is None or block.branch is None:
            self._wrong(item.mark, "this `else` belongs to no `if`")
        elif block.branch.condition is None:
            self._wrong(item.mark, "nothing comes after `else` but `end`")
        else:
            block.close_branch(item)

    def _end(self, item: End) -> None:
        if not self._open:
            self._wrong(item.mark, "this `end` ends nothing")
            return
        block = self._open.pop()
        if isinstance(block.head, Unread) or len(self._open) > DEEPEST_BLOCK:
            return
        if isinstance(block.head, If):
            block.close_branch()
            self._body().append(replace(block.head, branches=tuple(block.branches)))
        else:
            self._body().append(replace(block.head, body=tuple(block.body)))

    def _wrong(self, mark: SourceMark, text: str) -> None:
        self.problems.append(Problem(mark, text))
