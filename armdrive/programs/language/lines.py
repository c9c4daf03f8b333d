"""The grammar of one line of a program, and the parser made from it.

A program is read line by line, so that one mistake hides no other, and so that a prompt can read
what is typed there by the same rules. Blocks are put together in reading.py.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType
from typing import Any, TypeAlias

from lark import Lark, Token, Tree, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from armdrive.programs.language.syntax import (
    Assign,
    Binary,
    Call,
    DefineHead,
    Do,
    Else,
    End,
    Expression,
    FieldOf,
    Goto,
    Head,
    If,
    IfBranch,
    IfHead,
    JointsOf,
    Label,
    Name,
    Number,
    Remark,
    RepeatHead,
    Statement,
    TextValue,
    Truth,
    Unary,
    Unread,
    Use,
    WhileHead,
    negative,
)
from armdrive.programs.language.words import LINKS, RESERVED, SHAPES, SPELLINGS
from armdrive.programs.problems import Problem, SourceMark
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
if_goto: "if"i expr "then"i "goto"i? target
define: "define"i NAME ("(" names? ")")?
names: NAME ("," NAME)*
if_: "if"i expr "then"i?
else_if: ("else"i "if"i | "elseif"i) expr "then"i?
else_: "else"i
while_: "while"i expr
repeat: "repeat"i expr? ("as"i NAME)?
end: "end"i

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


@cache
def line_parser() -> Lark:
    """Return the parser of one line. It costs some 20 ms, so that it is made when one is read."""
    longest_first = sorted(SPELLINGS, key=len, reverse=True)
    grammar = GRAMMAR.replace("@words@", "|".join(longest_first))
    grammar = grammar.replace("@links@", "|".join(LINKS))
    return Lark(
        grammar,
        parser="lalr",
        lexer="contextual",
        maybe_placeholders=False,
        propagate_positions=True,
    )


# Reading values: the parser's tree of what has a value becomes ours.

# ruff: noqa: ARG002, D102 - one form for all methods of the table below


SIGNS: Mapping[str, str] = MappingProxyType({
    "=": "==", "is": "==", "eq": "==", "is not": "!=", "<>": "!=", "ne": "!=",
    "lt": "<", "le": "<=", "gt": ">", "ge": ">=",
})  # fmt: skip
"""What the other spellings of a comparison mean."""

_TRUE = ("on", "true")


class Expressions:
    """Turns the values of one line into nodes that know where they stand."""

    def __init__(self, number: int, file: str) -> None:
        self._number = number
        self._file = file

    def mark(self, found: Tree[Token] | Token) -> SourceMark:
        """Return where something begins."""
        where = found if isinstance(found, Token) else found.meta
        return SourceMark(self._number, getattr(where, "column", None) or 1, self._file)

    def arguments(self, found: Tree[Token] | Token) -> tuple[Expression, ...]:
        """Return the values between commas."""
        assert isinstance(found, Tree)  # noqa: S101 - the grammar's own promise
        return tuple(self.value(each) for each in found.children)

    def value(self, found: Tree[Token] | Token) -> Expression:
        """Return one value."""
        assert isinstance(found, Tree)  # noqa: S101 - the grammar's own promise
        made: Expression = _VALUES[found.data](self, found.children, self.mark(found))
        return made

    def number_of(self, children: list[Any], mark: SourceMark) -> Expression:
        return Number(float(children[0]), mark=mark)

    def percent(self, children: list[Any], mark: SourceMark) -> Expression:
        return Number(float(children[0].rstrip("% \t")) / 100.0, percent=True, mark=mark)

    def text(self, children: list[Any], mark: SourceMark) -> Expression:
        return TextValue(children[0][1:-1].replace('""', '"'), mark=mark)

    def truth(self, children: list[Any], mark: SourceMark) -> Expression:
        return Truth(children[0].lower() in _TRUE, mark=mark)

    def name(self, children: list[Any], mark: SourceMark) -> Expression:
        return Name(str(children[0]), mark=mark)

    def use(self, children: list[Any], mark: SourceMark) -> Expression:
        arguments = self.arguments(children[1]) if len(children) > 1 else ()
        return Use(str(children[0]).lower(), arguments, mark=mark)

    def joints(self, children: list[Any], mark: SourceMark) -> Expression:
        angles = [each.children for each in children[1:]]
        named = tuple((str(name).lower(), self.value(angle)) for name, angle in angles)
        return JointsOf(named, mark=mark)

    def field(self, children: list[Any], mark: SourceMark) -> Expression:
        return FieldOf(self.value(children[0]), str(children[1]).lower(), mark=mark)

    def inner(self, children: list[Any], mark: SourceMark) -> Expression:
        return self.value(children[0])

    def unary(self, children: list[Any], mark: SourceMark) -> Expression:
        sign, value = str(children[0]).lower(), self.value(children[1])
        return negative(value, mark) if sign == "-" else Unary(sign, value, mark=mark)

    def binary(self, children: list[Any], mark: SourceMark) -> Expression:
        left, sign, right = children
        said = " ".join(str(sign).lower().split())
        at = self.mark(sign)
        return Binary(self.value(left), SIGNS.get(said, said), self.value(right), mark=at)


_Builder = Callable[[Expressions, list[Any], SourceMark], Expression]

_VALUES: Mapping[str, _Builder] = MappingProxyType({
    "number": Expressions.number_of,
    "percent": Expressions.percent,
    "text": Expressions.text,
    "truth": Expressions.truth,
    "name": Expressions.name,
    "use": Expressions.use,
    "joints": Expressions.joints,
    "field": Expressions.field,
    "inner": Expressions.inner,
    "unary": Expressions.unary,
    "binary": Expressions.binary,
})  # fmt: skip


# What a person is told of a line that cannot be read.

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
    "gosub": "the name of a subprogram, as `fetch(pick)`",
    "call": "the name of a subprogram, as `fetch(pick)`",
    "def": "`define`",
    "sub": "`define`",
    "let": "`x = 3`",
    "set": "`x = 3`",
})  # fmt: skip
"""What words of other languages are called here."""

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
"""What the parser's expectations are called; nothing where naming them would only be noise."""


def mistake(error: UnexpectedInput, line: str) -> tuple[int, str]:
    """Return the column at which a line cannot be read on, and why."""
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
        return f"{sign!r} is no letter of a name: those have a to z, digits and _"
    return f"{sign!r} is no sign of a program"


def _first_word(line: str, column: int) -> tuple[int, str] | None:
    """Return what is wrong where the word that the line begins with is the mistake."""
    match = _FIRST.match(line)
    if match is None:
        return None
    word, at = match[1], match.start(1) + 1
    rest = line[match.end(1) :].lstrip()
    low = word.lower()
    if low in RESERVED and rest.startswith("=") and not rest.startswith("=="):
        return at, f"`{low}` is a word of the language: give the value another name"
    if rest.startswith(_CHANGES):
        return at, f"a value is given a name so: `{word} = ...`"
    known = low in SPELLINGS or low in SHAPES or low in RESERVED
    if known or column <= at or rest.startswith(("=", ":", "(")):
        return None
    return at, unknown_word(word, (*SPELLINGS, *SHAPES)) or (
        f"there is no word {word!r}; a subprogram takes its values in brackets: `{word}(...)`"
    )


def unknown_word(word: str, known: Iterable[str]) -> str:
    """Return that there is no such word, and which was meant; nothing where nobody can tell."""
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


# Reading one line: the parser's tree becomes statements, and what it trips over a sentence.

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
        return [Remark(mark=SourceMark(number, 1, file))]
    if len(line) > LONGEST_LINE:
        mark = SourceMark(number, LONGEST_LINE + 1, file)
        raise LineMistake(Problem(mark, f"a line has at most {LONGEST_LINE} characters"))
    try:
        tree = line_parser().parse(line)
    except UnexpectedInput as error:
        column, text = mistake(error, line)
        raise LineMistake(Problem(SourceMark(number, column, file), text)) from None
    if _depth(tree) > DEEPEST_VALUE:
        raise LineMistake(
            Problem(SourceMark(number, 1, file), "this is nested too deeply: give its parts names")
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
        return If((IfBranch(condition, (self.goto(tree),), mark=mark),), mark=mark)

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
