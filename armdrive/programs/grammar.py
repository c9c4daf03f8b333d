"""The grammar of one line of a program, and the parser made from it.

A program is read line by line, so that one mistake hides no other, and so that a prompt can read
what is typed there by the same rules. Blocks are put together in reading.py.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from armdrive.programs.vocabulary import LINKS, SPELLINGS

if TYPE_CHECKING:
    from lark import Lark

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
    from lark import Lark

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
