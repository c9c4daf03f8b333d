"""The words of programs: reading, checks, help and docs use them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.errors.arguments import LONGEST_TIME_S
from kinematics.spaces import POSE_FIELDS


class ValueKind(Enum):
    """What a value is."""

    NUMBER = "a number"
    TRUTH = "on or off"
    PLACE = "a place"
    TEXT = "a text"
    COMPARABLE = "a number, or on or off"
    ANY = "a value"


# The kinds of values that can be compared.
COMPARABLE = (ValueKind.NUMBER, ValueKind.TRUTH)


@dataclass(frozen=True, slots=True)
class Slot:
    """One value of a word or a function, and its bounds; with `sets` a name that the word sets."""

    title: str
    kind: ValueKind = ValueKind.NUMBER
    sets: bool = False
    optional: bool = False
    many: bool = False
    least: float | None = None
    most: float | None = None
    whole: bool = False
    not_zero: bool = False


@dataclass(frozen=True, slots=True)
class Word:
    """A word that does something: how it is written, and what it means."""

    name: str
    slots: tuple[Slot, ...]
    says: str
    example: str
    old: tuple[str, ...] = ()
    links: tuple[tuple[str, tuple[Slot, ...]], ...] = ()
    needs: tuple[str, ...] = ()
    """The links that must be there."""


PLACE = Slot("place", ValueKind.PLACE)
DISTANCE = Slot("distance in mm")
WIDTH = Slot("opening in mm", least=0.0)
MAYBE_WIDTH = Slot("opening in mm", least=0.0, optional=True)
ALONG = (Slot("x in mm"), Slot("y in mm"), Slot("z in mm"))
ANYTHING = Slot("text or value", ValueKind.ANY, many=True, optional=True)
ANY_VALUE = Slot("value", ValueKind.ANY)
NEW_NAME = Slot("name", ValueKind.ANY, sets=True)
LINES = Slot("number", many=True, whole=True, not_zero=True)
CONDITION = Slot("condition", ValueKind.TRUTH)
SPEED = Slot("fraction of the limits")  # its bounds are those of every speed, see `out_of_bounds`
COUNT = Slot("number of rounds", least=0.0, whole=True)


_INTO = ("into", (NEW_NAME,))


MOVING = (
    Word("move", (PLACE,), "Go to a place, a point or `at(...)`, by a joint motion.", "move pick"),
    Word("move_line", (PLACE,), "Go to a place along a straight line.", "move_line pick",
         ("moves",)),
    Word("move_with", (PLACE, WIDTH), "Bring the fingers to an opening, then go to a place.",
         "move_with pick, 40", ("movet",)),
    Word("move_line_with", (PLACE, WIDTH),
         "Bring the fingers to an opening, then go along a straight line.",
         "move_line_with pick, 40", ("movest",)),
    Word("approach", (PLACE, DISTANCE),
         "Go to a distance before a place, measured along the direction of the hand.",
         "approach pick, 60", ("appro",)),
    Word("approach_line", (PLACE, DISTANCE), "The same along a straight line.",
         "approach_line pick, 60", ("appros",)),
    Word("depart", (DISTANCE,), "Go back along the direction of the hand.", "depart 60"),
    Word("depart_line", (DISTANCE,), "The same along a straight line.", "depart_line 60",
         ("departs",)),
    Word("draw", ALONG, "Go along x, y and z of the base, on a straight line.",
         "draw 10, 0, -5"),
    Word("ready", (), "Go to the park posture of the arm file.", "ready"),
    Word("home", (), "Reference the arm, where its position is not yet trusted.", "home"),
    Word("speed", (SPEED,), "The speed of everything that follows.", "speed 50%"),
)  # fmt: skip

FINGERS = (
    Word("open", (MAYBE_WIDTH,), "Open the fingers, all the way or to a width, with the next move.",
         "open"),
    Word("close", (), "Close the fingers with the next move.", "close"),
    Word("open_now", (MAYBE_WIDTH,), "Open the fingers at once.", "open_now 40", ("openi",)),
    Word("close_now", (), "Close the fingers at once.", "close_now", ("closei",)),
    Word("grasp", (), "Close the fingers on an object; its width in mm is 0 if there is none.",
         "grasp into width", links=(_INTO,)),
)  # fmt: skip

PLACES = (
    Word("here", (NEW_NAME,), "Name the place where the arm stands.", "here corner"),
    Word("shift", (NEW_NAME,), "Move a point of the program along x, y and z of the base.",
         "shift corner by 10, 0, 0", links=(("by", ALONG),), needs=("by",)),
    Word("remember", (NEW_NAME,),
         "Like `here`, and save the point, replacing a saved one of that name.",
         "remember corner"),
)  # fmt: skip

TIME = Slot("time in s", least=0.0, most=LONGEST_TIME_S)

WAITING = (
    Word("delay", (TIME,), "Let time pass.", "delay 1.5"),
    Word("signal", (LINES,), "Switch outputs on, and those with a minus off.", "signal 3, -4"),
    Word("wait_input", (LINES,),
         "Wait until inputs are on, and those with a minus off. After the time given by `within`, "
         "in s, the program ends with an error. With `into NAME` it goes on, and NAME says whether "
         "the inputs came.",
         "wait_input 1, -2 within 5",
         links=(("within", (TIME,)), _INTO)),
    Word("hold", (ANYTHING,), "Wait until a person continues the program.",
         'hold "turn the part"', ("pause",)),
    Word("type", (ANYTHING,), "Show something to the person.", 'type "width", width'),
)  # fmt: skip

GOING_ON = (
    Word("expect", (CONDITION, ANYTHING),
         "End the program with an error unless the condition holds.",
         'expect width > 20, "no block"'),
    Word("stop", (ANYTHING,), "End the program here, and say why.", 'stop "that was all"'),
    Word("return", (), "Leave the subprogram.", "return"),
    Word("break", (), "Leave the innermost loop.", "break"),
    Word("continue", (), "Begin the next round of the innermost loop.", "continue"),
)  # fmt: skip

# The words by subject.
GROUPS: Mapping[str, tuple[Word, ...]] = MappingProxyType({
    "Moving": MOVING,
    "Fingers": FINGERS,
    "Places": PLACES,
    "Waiting, inputs and outputs": WAITING,
    "Going on": GOING_ON,
})  # fmt: skip

# Every word, in its present spelling.
WORDS: Mapping[str, Word] = MappingProxyType(
    {word.name: word for words in GROUPS.values() for word in words}
)

# The present spelling of every spelling.
SPELLINGS: Mapping[str, str] = MappingProxyType(
    {spelt: word.name for word in WORDS.values() for spelt in (word.name, *word.old)}
)

# The words between the values of a word.
LINKS = ("into", "by", "within")


@dataclass(frozen=True, slots=True)
class WordForm:
    """The form of a line, and its meaning."""

    name: str
    pattern: str
    says: str


# The lines that shape a program.
FORMS = (
    WordForm("point", "point NAME = PLACE", "Give a place a name."),
    WordForm("=", "NAME = VALUE", "Give a value a name."),
    WordForm("if", "if CONDITION",
             "Do the lines up to `end` if the condition holds; `else if "
             "CONDITION` and `else` may come between. `IF X > 3 THEN GOTO 10` is the old form."),
    WordForm("while", "while CONDITION",
             "Do the lines up to `end` as long as the condition holds."),
    WordForm("repeat", "repeat COUNT as NAME",
             "Do the lines up to `end` COUNT times, or endlessly without a count. The name counts "
             "1, 2, 3 and may be left out."),
    WordForm("define", "define NAME(PARAMETER, ...)",
             "A subprogram of the lines up to `end`; it is called by its name."),
    WordForm("end", "end", "The end of an `if`, `while`, `repeat` or `define`."),
    WordForm("goto", "goto NAME",
             "Go on at the label `NAME:` (or a number) of the same block, or of one "
             "around it. Loops read better."),
    WordForm("#", "# anything", "A comment, up to the end of the line."),
)  # fmt: skip

# The first words of the lines that shape a program.
SHAPES = (*(form.name for form in FORMS if form.name.isalpha()), "else")


@dataclass(frozen=True, slots=True)
class Function:
    """A function or an operator: the values it takes and the kind it returns.

    An operator may have other spellings. How operators bind is in program.lark.
    """

    name: str
    slots: tuple[Slot, ...]
    gives: ValueKind
    says: str = ""
    example: str = ""
    also: tuple[str, ...] = ()


_ONE = (Slot("number"),)
_TWO = (Slot("number"), Slot("number"))
_SOME = (Slot("number", many=True),)

# Every function except `joints(base 0, ...)`, which has a form of its own.
FUNCTIONS: Mapping[str, Function] = MappingProxyType({row.name: row for row in (
    Function("at", (*ALONG, Slot("pitch in deg"), Slot("roll in deg", optional=True),
                    Slot("yaw in deg, for arms of six joints", optional=True)),
             ValueKind.PLACE, "The place with these coordinates; -90 of pitch points at the table.",
             "at(250, 0, 60, -90)"),
    Function("taught", (Slot("name", ValueKind.TEXT),), ValueKind.PLACE,
             "A saved point whose name a program cannot have.",
             'taught("pick-2")'),
    Function("shifted", (PLACE, *ALONG), ValueKind.PLACE,
             "A place moved along x, y and z.", "shifted(pick, 0, 40, 0)"),
    Function("above", (PLACE, DISTANCE), ValueKind.PLACE, "A place moved up.",
             "above(pick, 30)"),
    Function("input", (Slot("number", least=1.0, whole=True),), ValueKind.TRUTH,
             "Whether an input is on; inputs count from 1.", "input(3)"),
    Function("abs", _ONE, ValueKind.NUMBER, "The number without its sign.", "abs(-3)"),
    Function("min", _SOME, ValueKind.NUMBER, "The smallest number.", "min(2, 3)"),
    Function("max", _SOME, ValueKind.NUMBER, "The largest number.", "max(2, 3)"),
    Function("mod", _TWO, ValueKind.NUMBER, "The remainder of a division.",
             "mod(7, 3)"),
    Function("sqrt", _ONE, ValueKind.NUMBER, "The square root.", "sqrt(2)"),
    Function("sin", _ONE, ValueKind.NUMBER, "The sine of an angle in deg.", "sin(30)"),
    Function("cos", _ONE, ValueKind.NUMBER, "The cosine of an angle in deg.", "cos(60)"),
    Function("tan", _ONE, ValueKind.NUMBER, "The tangent of an angle in deg.", "tan(45)"),
    Function("atan2", _TWO, ValueKind.NUMBER, "The angle, in deg, of a direction by its y and x.",
             "atan2(1, 1)"),
    Function("floor", _ONE, ValueKind.NUMBER, "The next whole number below.", "floor(2.7)"),
    Function("round", _ONE, ValueKind.NUMBER, "The nearest whole number; halves go up.",
             "round(2.5)"),
)})  # fmt: skip


def _operator(
    sign: str, takes: ValueKind, gives: ValueKind, *also: str, values: int = 2
) -> Function:
    return Function(sign, (Slot("value", takes),) * values, gives, also=also)


_NUMBER, _TRUTH = ValueKind.NUMBER, ValueKind.TRUTH
# The name of the operator `-` before a value.
NEGATIVE = "-x"

# Every operator, the weakest first.
OPERATORS: Mapping[str, Function] = MappingProxyType({row.name: row for row in (
    _operator("or", _TRUTH, _TRUTH),
    _operator("and", _TRUTH, _TRUTH),
    _operator("not", _TRUTH, _TRUTH, values=1),
    _operator("==", ValueKind.COMPARABLE, _TRUTH, "=", "is", "eq"),
    _operator("!=", ValueKind.COMPARABLE, _TRUTH, "is not", "<>", "ne"),
    _operator("<", _NUMBER, _TRUTH, "lt"),
    _operator("<=", _NUMBER, _TRUTH, "le"),
    _operator(">", _NUMBER, _TRUTH, "gt"),
    _operator(">=", _NUMBER, _TRUTH, "ge"),
    _operator("+", _NUMBER, _NUMBER),
    _operator("-", _NUMBER, _NUMBER),
    _operator("*", _NUMBER, _NUMBER),
    _operator("/", _NUMBER, _NUMBER),
    _operator(NEGATIVE, _NUMBER, _NUMBER, values=1),
)})  # fmt: skip


# The parts of a place, such as `pick.x`.
PARTS: Mapping[str, Function] = MappingProxyType(
    {f".{name}": Function(f".{name}", (PLACE,), _NUMBER) for name in POSE_FIELDS}
)

# Everything that makes a value of values, under the name that `Use` has for it.
CALLABLE: Mapping[str, Function] = MappingProxyType({**FUNCTIONS, **OPERATORS, **PARTS})

# The name of the place where the arm stands.
HERE = "here"

# Names that a program cannot use for its own values, labels and subprograms.
RESERVED = frozenset({
    "and", "or", "not", "is", "true", "false", "on", "off", HERE, "joints", "then", "as", "elseif",
    "eq", "ne", "lt", "le", "gt", "ge", *SHAPES, *LINKS, *SPELLINGS, *FUNCTIONS,
})  # fmt: skip


# Texts made from the vocabulary: the help of the shell; docs/generated.py makes tables of it.


def overview() -> list[str]:
    """Return all words of programs, a line for each group, as the shell shows them."""
    found = ["words of a program: `help WORD` explains one, docs/reference/programs.md all of them"]
    for title, words in GROUPS.items():
        found.append(f"  {title}: {', '.join(word.name for word in words)}")
    found.append(f"  Shape: {', '.join(row.name for row in FORMS)}")
    found.append(f"  Values: {', '.join((*FUNCTIONS, 'joints', HERE))}")
    return found


def meanings(name: str) -> list[str]:
    """Return the meanings of a word in lower case."""
    found = []
    if name in SPELLINGS:
        word = WORDS[SPELLINGS[name]]
        spelt = ", ".join(each.upper() for each in word.old)
        old = f"\n  old spelling: {spelt}" if spelt else ""
        found.append(f"{usage(word)}\n  {word.says}\n  {word.example}{old}")
    if name in FUNCTIONS:
        row = FUNCTIONS[name]
        found.append(f"{row.name}(...)\n  {row.says}\n  {row.example}")
    forms = [form for form in FORMS if form.name == name]
    return found + [f"{form.pattern}\n  {form.says}" for form in forms]


def usage(word: Word) -> str:
    """Return how a word is written: `wait_input NUMBER, ... [within TIME] [into NAME]`."""
    links = "".join(
        f" {link} {values_form(slots)}" if link in word.needs else f" [{link} {values_form(slots)}]"
        for link, slots in word.links
    )
    return f"{word.name} {values_form(word.slots)}".rstrip() + links


def values_form(slots: Sequence[Slot]) -> str:
    """Return how the values of a word or a function are written: `PLACE, OPENING`."""
    shown = []
    for slot in slots:
        name = slot.title.split(",")[0].split(" in ")[0].upper()
        text = f"{name}, ..." if slot.many else name
        shown.append(f"[{text}]" if slot.optional else text)
    return ", ".join(shown)
