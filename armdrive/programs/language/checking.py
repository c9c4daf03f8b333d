"""Checks the values of a program's lines: how many, of which kind, and within which bounds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from types import MappingProxyType

from armdrive.programs.language.syntax import (
    Assign,
    Call,
    Define,
    Do,
    Expression,
    JointsOf,
    Literal,
    Name,
    ProgramNames,
    Statement,
    Use,
    own_names,
    set_by,
    slotted,
)
from armdrive.programs.language.values import fewest, kind_of, out_of_bounds, slot_of
from armdrive.programs.language.words import (
    CALLABLE,
    FUNCTIONS,
    HERE,
    OPERATORS,
    WORDS,
    Slot,
    ValueKind,
)
from armdrive.programs.problems import Problem, SourceMark
from kinematics.errors import suggestion
from kinematics.spaces import POSE_FIELDS
from kinematics.text import counted

# The kind of every name of a program, inferred from the lines that set it.


class Kinds:
    """The kinds of a program's names, as far as the text tells them.

    The first value of a name decides its kind. That of a parameter is known when it is called.
    """

    def __init__(
        self, names: ProgramNames, known: Mapping[str, ValueKind] = MappingProxyType({})
    ) -> None:
        self.variables = names.variables
        self.subprograms = names.subprograms
        self._kinds = dict(known)
        for define, line in names.lines:
            for name, kind in self.set_by(define, line):
                if kind is not None and name.name.lower() not in own_names(define):
                    self._kinds.setdefault(name.name.lower(), kind)

    def set_by(
        self, define: Define | None, line: Statement
    ) -> Iterator[tuple[Name, ValueKind | None]]:
        """Yield the names that a line itself sets, with their kinds."""
        for name, kind in set_by(line):
            if isinstance(line, Assign) and kind is ValueKind.ANY:
                yield name, self.of(line.value, define)
            else:
                yield name, kind

    def of_name(self, name: str, define: Define | None) -> ValueKind | None:
        """Return the kind of a name, or None if it is unknown."""
        low = name.lower()
        if self.nowhere(name, define) or low == HERE:
            return ValueKind.PLACE
        return None if low in own_names(define) else self._kinds.get(low)

    def nowhere(self, name: str, define: Define | None) -> bool:
        """Return whether the program never sets a name: then it is a point of the arm's book."""
        low = name.lower()
        return low != HERE and low not in own_names(define) and low not in self.variables

    def of(self, value: Expression, define: Define | None) -> ValueKind | None:
        """Return the kind of a value, or None if it is unknown."""
        match value:
            case Name():
                return self.of_name(value.name, define)
            case Literal():
                return kind_of(value.value)
            case JointsOf():
                return ValueKind.PLACE
            case Use():
                return CALLABLE[value.name].gives if value.name in CALLABLE else None


# Whether values fit: their number, kinds and bounds.


class Fitting:
    """Checks the lines of one subprogram, or of the program itself."""

    def __init__(self, kinds: Kinds, define: Define | None) -> None:
        self._kinds = kinds
        self._define = define

    def line(self, line: Statement) -> Iterator[Problem]:
        """Yield what is wrong in a line, without the lines within it."""
        match line:
            case Do():
                yield from self._do(line)
            case Assign():
                yield from self._assign(line)
            case Call():
                yield from self._call(line)
            case _:
                for value, slot in slotted(line):
                    if not slot.sets:
                        yield from self._value(value, slot)
        for name, kind in self._kinds.set_by(self._define, line):
            known = self._kinds.of_name(name.name, self._define)
            if kind is not None and known is not None and kind is not known:
                text = f"{name.name!r} is {known.value} elsewhere, and cannot become {kind.value}"
                yield Problem(name.mark, text)

    # -- lines -------------------------------------------------------------------------------

    def _do(self, line: Do) -> Iterator[Problem]:
        word = WORDS[line.word]
        example = f": `{word.example}`"
        yield from self._many(line.arguments, word.slots, line.word, line.mark, example)
        known = dict(word.links)
        links = [link for link, _ in line.links]
        for link, values in line.links:
            if link not in known or links.count(link) > 1:
                yield Problem(line.mark, f"`{link}` does not belong to `{line.word}` here{example}")
            else:
                yield from self._many(values, known[link], link, line.mark, example)
        for link in word.needs:
            if link not in links:
                yield Problem(line.mark, f"`{line.word}` needs `{link}`{example}")

    def _assign(self, line: Assign) -> Iterator[Problem]:
        (value, slot), *_ = slotted(line)
        kind = self._kinds.of(value, self._define)
        if line.point:
            yield from self._value(value, slot)
        elif isinstance(value, Name) and self._kinds.nowhere(value.name, self._define):
            yield self._nowhere(value)
        elif kind is ValueKind.TEXT:
            yield Problem(value.mark, "a text cannot have a name")
        else:
            if kind is ValueKind.PLACE:
                text = f"to name a place, write `point {line.name} = ...`"
                yield Problem(line.mark, text)
            yield from self._value(value, slot)

    def _call(self, line: Call) -> Iterator[Problem]:
        called = self._kinds.subprograms.get(line.name.lower())
        if called is None:
            return
        for name, value in zip(called.parameters, line.arguments, strict=False):
            kind = self._kinds.of_name(name, called)
            if isinstance(value, Literal) and isinstance(value.value, str):
                yield Problem(value.mark, "a subprogram takes no text")
            else:
                yield from self._value(value, Slot(name, kind or ValueKind.ANY))
        if len(called.parameters) != len(line.arguments):
            takes = ", ".join(called.parameters) or "nothing"
            values = counted(len(called.parameters), "value")
            text = f"`{called.name}` takes {takes}: {values}, not {len(line.arguments)}"
            yield Problem(line.mark, text)

    # -- values ------------------------------------------------------------------------------

    def _many(
        self,
        values: Sequence[Expression],
        slots: Sequence[Slot],
        what: str,
        mark: SourceMark,
        hint: str,
    ) -> Iterator[Problem]:
        if len(values) < fewest(slots):
            missing = slots[len(values)].title
            yield Problem(mark, f"`{what}` needs the {missing}{hint}")
        for index, value in enumerate(values):
            slot = slot_of(slots, index)
            if slot is None:
                count = counted(len(slots), "value") if slots else "nothing"
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
        computed = slot.kind in (ValueKind.NUMBER, ValueKind.TRUTH)
        if isinstance(value, Name) and computed and self._kinds.nowhere(value.name, self._define):
            yield self._nowhere(value)
        # a kind that is unknown here is judged when the line runs
        elif kind is not None and slot.kind not in (kind, ValueKind.ANY):
            yield Problem(value.mark, f"{slot.kind.value} is needed here, not {kind.value}")
        elif isinstance(value, Literal) and type(value.value) is float and isfinite(value.value):
            wrong = out_of_bounds(slot, value.value, percent=value.percent)
            if wrong is not None:
                yield Problem(value.mark, wrong)

    def _nowhere(self, value: Name) -> Problem:
        known = self._kinds.variables
        text = f"{value.name!r} is not defined{suggestion(value.name.lower(), known)}"
        return Problem(value.mark, text)

    def _inside(self, value: Expression) -> Iterator[Problem]:
        match value:
            case Literal(value=float(amount)) if not isfinite(amount):
                yield Problem(value.mark, "this number is too large")
            case JointsOf():
                names = [name for name, _ in value.angles]
                for name, angle in value.angles:
                    yield from self._value(angle, Slot(name))
                for name in sorted({name for name in names if names.count(name) > 1}):
                    yield Problem(value.mark, f"{name} has two angles")
            case Use():
                yield from self._use(value)

    def _use(self, value: Use) -> Iterator[Problem]:
        row = CALLABLE.get(value.name)
        if row is None:
            yield Problem(value.mark, _no_function(value.name))
            return
        slots = row.slots
        if value.name in OPERATORS and slots[0].kind is ValueKind.ANY:
            # both are of the kind that one of them shows
            kinds = [self._kinds.of(side, self._define) for side in value.arguments]
            if shown := [each for each in kinds if each in (ValueKind.NUMBER, ValueKind.TRUTH)]:
                slots = (Slot("value", shown[0]),) * 2
            elif ValueKind.PLACE in kinds:
                yield Problem(value.mark, "places cannot be compared: compare their x, y and z")
            elif ValueKind.TEXT in kinds:
                yield Problem(value.mark, "texts cannot be compared")
        hint = f": `{row.example}`"
        yield from self._many(value.arguments, slots, value.name, value.mark, hint)


def _no_function(name: str) -> str:
    if name.startswith("."):
        return f"a place has {', '.join(POSE_FIELDS)}, no {name[1:]}"
    return f"there is no function {name!r}{suggestion(name, FUNCTIONS)}"
