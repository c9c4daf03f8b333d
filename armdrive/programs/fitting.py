"""Whether values fit what takes them: how many there are, of which kind, in which bounds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite

from armdrive.programs.acts import Mark
from armdrive.programs.bounds import fewest, out_of_bounds, slot_of
from armdrive.programs.kinds import ARITHMETIC, Kinds
from armdrive.programs.naming import set_by
from armdrive.programs.problems import Problem
from armdrive.programs.syntax import Assign, Call, Define, Do, If, Repeat, Statement, While
from armdrive.programs.terms import (
    Binary,
    Expression,
    FieldOf,
    JointsOf,
    Name,
    Number,
    Text,
    Unary,
    Use,
)
from armdrive.programs.vocabulary import FIELDS, FUNCTIONS, WORDS, Kind, Slot
from kinematics.errors import suggestion

_COUNT = Slot("how often", least=0.0, whole=True)
_CONDITION = Slot("condition", Kind.TRUTH)


class Fitting:
    """Looks at the lines of one subprogram, or of the program itself."""

    def __init__(self, kinds: Kinds, define: Define | None) -> None:
        self._kinds = kinds
        self._define = define

    def line(self, line: Statement) -> Iterator[Problem]:
        """Yield what does not fit in a line, without the lines within it."""
        match line:
            case Do():
                yield from self._do(line)
            case Assign():
                yield from self._assign(line)
            case Call():
                yield from self._call(line)
            case While():
                yield from self._value(line.condition, _CONDITION)
            case Repeat() if line.count is not None:
                yield from self._value(line.count, _COUNT)
            case If():
                for branch in line.branches:
                    if branch.condition is not None:
                        yield from self._value(branch.condition, _CONDITION)
        yield from self._set(line)

    def _set(self, line: Statement) -> Iterator[Problem]:
        for name, mark, kind in set_by(line):
            if isinstance(line, Assign):
                kind = Kind.PLACE if line.point else self._kinds.of(line.value, self._define)
            known = self._kinds.of_name(name, self._define)
            if kind is not None and known is not None and kind is not known:
                text = f"{name!r} is {known.value} elsewhere, and cannot become {kind.value}"
                yield Problem(mark, text)

    # -- lines -------------------------------------------------------------------------------

    def _do(self, line: Do) -> Iterator[Problem]:
        word = WORDS[line.word]
        example = f": `{word.example}`"
        yield from self._many(line.arguments, word.slots, line.word, line.mark, example)
        known = dict(word.links)
        said = [link for link, _ in line.links]
        for link, values in line.links:
            if link not in known or said.count(link) > 1:
                yield Problem(line.mark, f"`{link}` does not belong to `{line.word}` so{example}")
            else:
                yield from self._many(values, known[link], link, line.mark, example)
        for link in word.needs:
            if link not in said:
                yield Problem(line.mark, f"`{line.word}` needs `{link}`{example}")

    def _assign(self, line: Assign) -> Iterator[Problem]:
        wanted = Kind.PLACE if line.point else Kind.ANY
        kind = self._kinds.of(line.value, self._define)
        if line.point:
            yield from self._value(line.value, Slot("place", wanted))
        elif isinstance(line.value, Name) and self._kinds.nowhere(line.value.name, self._define):
            yield self._nowhere(line.value)
        elif kind is Kind.PLACE:
            text = f"a place is given a name so: `point {line.name} = ...`"
            yield Problem(line.mark, text)
            yield from self._value(line.value, Slot("value", Kind.ANY))
        elif kind is Kind.TEXT:
            yield Problem(line.value.mark, "a text cannot be given a name")
        else:
            yield from self._value(line.value, Slot("value", Kind.ANY))

    def _call(self, line: Call) -> Iterator[Problem]:
        called = self._kinds.subprograms.get(line.name.lower())
        if called is None:
            return
        for name, value in zip(called.parameters, line.arguments, strict=False):
            kind = self._kinds.of_name(name, called)
            if isinstance(value, Text):
                yield Problem(value.mark, "a subprogram takes no text")
            else:
                yield from self._value(value, Slot(name, kind or Kind.ANY))
        if len(called.parameters) != len(line.arguments):
            takes = ", ".join(called.parameters) or "nothing"
            text = f"`{called.name}` takes {takes}: {len(called.parameters)} values, "
            yield Problem(line.mark, f"{text}not {len(line.arguments)}")

    # -- values ------------------------------------------------------------------------------

    def _many(
        self, values: Sequence[Expression], slots: Sequence[Slot], what: str, mark: Mark, hint: str
    ) -> Iterator[Problem]:
        if len(values) < fewest(slots):
            missing = slots[len(values)].title
            yield Problem(mark, f"`{what}` needs the {missing}{hint}")
        for index, value in enumerate(values):
            slot = slot_of(slots, index)
            if slot is None:
                count = f"{len(slots)} value{'s' * (len(slots) != 1)}" if slots else "nothing"
                yield Problem(value.mark, f"`{what}` takes {count}, this is too many{hint}")
                return
            if not slot.sets:
                yield from self._value(value, slot)
            elif not isinstance(value, Name):
                yield Problem(value.mark, f"`{what}` needs a name here{hint}")

    def _value(self, value: Expression, slot: Slot) -> Iterator[Problem]:
        found = list(self._inside(value))
        yield from found
        kind = self._kinds.of(value, self._define)
        computed = slot.kind in (Kind.NUMBER, Kind.TRUTH)
        if isinstance(value, Name) and computed and self._kinds.nowhere(value.name, self._define):
            yield self._nowhere(value)
        elif kind is not None and slot.kind not in (kind, Kind.ANY):
            yield Problem(value.mark, f"{slot.kind.value} is needed here, not {kind.value}")
        elif isinstance(value, Number) and isfinite(value.value):
            wrong = out_of_bounds(slot, value.value)
            if wrong is not None:
                yield Problem(value.mark, wrong)

    def _nowhere(self, value: Name) -> Problem:
        known = self._kinds.variables
        text = f"{value.name!r} is set nowhere{suggestion(value.name.lower(), known)}"
        return Problem(value.mark, text)

    def _inside(self, value: Expression) -> Iterator[Problem]:
        match value:
            case Number() if not isfinite(value.value):
                yield Problem(value.mark, "this number is too large")
            case Unary():
                wanted = Kind.NUMBER if value.sign == "-" else Kind.TRUTH
                yield from self._value(value.value, Slot("value", wanted))
            case Binary():
                yield from self._binary(value)
            case FieldOf():
                yield from self._value(value.value, Slot("place", Kind.PLACE))
                if value.name not in FIELDS:
                    text = f"a place has {', '.join(FIELDS)}, no {value.name}"
                    yield Problem(value.mark, text)
            case JointsOf():
                yield from self._joints(value)
            case Use():
                yield from self._use(value)

    def _binary(self, value: Binary) -> Iterator[Problem]:
        if value.sign not in ("==", "!="):
            number = value.sign in ARITHMETIC or value.sign in ("<", "<=", ">", ">=")
            slot = Slot("value", Kind.NUMBER if number else Kind.TRUTH)
            yield from self._value(value.left, slot)
            yield from self._value(value.right, slot)
            return
        sides = [self._kinds.of(side, self._define) for side in (value.left, value.right)]
        kind = next((each for each in sides if each in (Kind.NUMBER, Kind.TRUTH)), None)
        if kind is None and Kind.PLACE in sides:
            yield Problem(value.mark, "places are not compared: compare their x, y and z")
        for side in (value.left, value.right):
            yield from self._value(side, Slot("value", kind or Kind.ANY))
        if kind is None and Kind.TEXT in sides:
            yield Problem(value.mark, "texts are not compared")

    def _joints(self, value: JointsOf) -> Iterator[Problem]:
        names = [name for name, _ in value.angles]
        for name, angle in value.angles:
            yield from self._value(angle, Slot(name))
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield Problem(value.mark, f"{name} has two angles")

    def _use(self, value: Use) -> Iterator[Problem]:
        row = FUNCTIONS.get(value.name)
        if row is None:
            near = suggestion(value.name, FUNCTIONS)
            yield Problem(value.mark, f"there is no function {value.name!r}{near}")
            return
        hint = f": `{row.example}`"
        yield from self._many(value.arguments, row.slots, value.name, value.mark, hint)
