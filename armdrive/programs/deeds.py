"""What each word of a program does: the acts that it asks of the arm, and what it brings.

A deed is written as if its acts were answered at once. In truth an act that has no answer yet
breaks the deed off, and once it is answered the deed is done again from its beginning, with the
answers that are there: see `Doing.ask`. So all that has to be remembered of a line that was
interrupted in its middle are the answers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeVar

from armdrive.moves import (
    GraspMove,
    GripperMove,
    JointMove,
    LineMove,
    Motion,
    MoveSequence,
    ParkMove,
    PoseMove,
)
from armdrive.programs.acts import (
    Act,
    AwaitInputs,
    Delay,
    Go,
    Hold,
    Home,
    Look,
    Outputs,
    ReadInput,
    Remember,
    Say,
)
from armdrive.programs.language.compiling import (
    ASSIGN,
    CALL,
    JUMP,
    RETURN,
    ROUND,
    ROUNDS,
    STOP,
    UNLESS,
    Instruction,
)
from armdrive.programs.language.syntax import (
    Binary,
    Expression,
    FieldOf,
    JointsOf,
    Name,
    Number,
    TextValue,
    Truth,
    Unary,
    Use,
)
from armdrive.programs.language.values import (
    NUMERIC,
    OPERATORS,
    PLACING,
    ForwardKinematics,
    PlaceValue,
    Trouble,
    Value,
    backed,
    from_json,
    moved,
    number,
    out_of_bounds,
    part_of,
    place,
    pose_of,
    said,
    slot_of,
    to_json,
    truth,
)
from armdrive.programs.language.words import FUNCTIONS, HERE, TIME, WORDS
from armdrive.programs.language.writing import written
from armdrive.programs.problems import SourceMark
from armdrive.text.form import (
    NUMBER,
    TEXT,
    Form,
    Json,
    as_table,
    misfit,
    optional,
    record,
    several,
)
from kinematics.spaces import Joints, Pose

T = TypeVar("T")

# All that a program under way knows, and how it is written down as plain JSON data.

ALL_THE_WAY = "open"
"""The opening with the next move where none in mm was said."""

DEEPEST_CALL = 50
"""Subprograms may call one another, or themselves, so deep."""


@dataclass(slots=True)
class CallFrame:
    """A subprogram under way: where it goes back to, who called it, its parameters and loops."""

    back: int = 0
    mark: SourceMark | None = None
    own: dict[str, Value] = field(default_factory=dict)
    loops: dict[str, tuple[int | None, ...]] = field(default_factory=dict)
    """Of each loop the rounds that are begun and the rounds that there are, None for no end."""


@dataclass(slots=True)
class MachineState:
    """Where a program is, and what it has computed.

    `answers` are those to the acts of the line under way. `moved` tells that one of these acts has
    done with the fingers what `opening` says.
    """

    at: int = 0
    answers: tuple[Value, ...] = ()
    moved: bool = False
    frames: tuple[CallFrame, ...] = field(default_factory=lambda: (CallFrame(),))
    variables: dict[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None
    """What the fingers are to do with the next move: mm, `ALL_THE_WAY`, or nothing."""
    ended: bool = False

    def __post_init__(self) -> None:
        if not self.frames or self.at < 0:
            raise ValueError("a program under way stands at one of its lines, in a frame")


def _whole(data: Json, where: str) -> int:
    if type(data) is not int:
        raise misfit(where, "a whole number", data)
    return data


def _opening(data: Json, where: str) -> float | str | None:
    return data if data is None or data == ALL_THE_WAY else NUMBER.read(data, where)


def by_name(form: Form[T]) -> Form[dict[str, T]]:
    """Return the form of values by their names."""
    return Form(
        lambda values: {name: form.write(value) for name, value in values.items()},
        lambda data, where: {
            name: form.read(value, f"{where}.{name}")
            for name, value in as_table(data, where).items()
        },
        {},
    )


VALUE: Form[Value] = Form(to_json, lambda data, _: from_json(data), {})
_WHOLE: Form[int] = Form(int, _whole, {})
_TRUTH: Form[bool] = Form(bool, lambda data, _: bool(data), {})
_FRAME = record(
    CallFrame,
    back=_WHOLE,
    mark=optional(record(SourceMark, line=_WHOLE, column=_WHOLE, file=TEXT)),
    own=by_name(VALUE),
    loops=by_name(several(optional(_WHOLE))),
)
STATE = record(
    MachineState,
    at=_WHOLE,
    answers=several(VALUE),
    moved=_TRUTH,
    frames=several(_FRAME),
    variables=by_name(VALUE),
    speed=NUMBER,
    opening=Form(lambda opening: opening, _opening, {}),
    ended=_TRUTH,
)
"""How a state is written down; reading one of another form raises `BadArgument`."""


# One line under way.


class Asked(Exception):
    """The act that a line needs an answer to before it can go on, and where that act stands."""

    def __init__(self, act: Act, mark: SourceMark) -> None:
        super().__init__()
        self.act = act
        self.mark = mark


class Doing:
    """A line as its deed sees it. `mark` is what is computed now: what fails, fails there."""

    def __init__(
        self,
        state: MachineState,
        row: Instruction,
        points: Mapping[str, PlaceValue],
        fk: ForwardKinematics | None,
    ) -> None:
        self.state = state
        self.row = row
        self.fk = fk
        self.mark = row.mark
        self.following = state.at + 1
        self._points = points
        self._answered = 0

    def ask(self, act: Act, mark: SourceMark | None = None) -> Value:
        """Return the answer to an act. While there is none, the deed is broken off by `Asked`."""
        if self._answered == len(self.state.answers):
            raise Asked(act, mark or self.row.mark)
        self._answered += 1
        return self.state.answers[self._answered - 1]

    def named(self, name: str) -> Value:
        """Return the value of a name: a parameter, a variable, or a point of the arm's book."""
        low, frame = name.lower(), self.state.frames[-1]
        for values, key in ((frame.own, low), (self.state.variables, low), (self._points, name)):
            if key in values:
                return values[key]
        raise Trouble(f"{name!r} has no value yet")

    def taught(self, name: str) -> PlaceValue:
        """Return a point of the arm's own book."""
        return self._points[name]

    def store(self, value: Value) -> None:
        """Give the name that the line sets, if it sets any, a value."""
        own = self.state.frames[-1].own
        for name in self.row.into:
            (own if name in own else self.state.variables)[name] = value


# Values.


def value_of(found: Expression, doing: Doing) -> Value:
    """Return what a value comes to. Raises `Trouble` where it comes to nothing."""
    match found:
        case Number() | Truth() | TextValue():
            return found.value
        case Name(name=name):
            doing.mark = found.mark
            return doing.ask(Look(), found.mark) if name.lower() == HERE else doing.named(name)
        case Unary():
            value = value_of(found.value, doing)
            doing.mark = found.mark
            return -number(value) if found.sign == "-" else not truth(value)
        case Binary():
            return _binary(found, doing)
        case FieldOf():
            value = value_of(found.value, doing)
            doing.mark = found.mark
            return part_of(place(value), found.name, doing.fk)
        case JointsOf():
            angles = [(name, value_of(each, doing)) for name, each in found.angles]
            doing.mark = found.mark
            return PlaceValue(joints_deg={name: number(angle) for name, angle in angles})
        case Use():
            return _use(found, doing)


def _binary(found: Binary, doing: Doing) -> Value:
    left = value_of(found.left, doing)
    doing.mark = found.mark
    if found.sign in ("and", "or"):
        decided = truth(left) is (found.sign == "or")
        return left if decided else value_of(found.right, doing)
    right = value_of(found.right, doing)
    doing.mark = found.mark
    compute = OPERATORS[found.sign].compute
    if compute is None:
        return (left == right) is (found.sign == "==")
    result = compute(number(left), number(right))
    return result if isinstance(result, bool) else number(result)


def _use(found: Use, doing: Doing) -> Value:
    match found:
        case Use(name="taught", arguments=(TextValue(value=name), *_)):
            return doing.taught(name)
    values = [value_of(each, doing) for each in found.arguments]
    doing.mark = found.mark
    if found.name == "input":
        count = number(values[0])
        wrong = out_of_bounds(FUNCTIONS["input"].slots[0], count)
        if wrong is not None:
            raise Trouble(wrong)
        return doing.ask(ReadInput(int(count)), found.mark)
    if found.name in PLACING:
        return PLACING[found.name](values, doing.fk)
    return number(NUMERIC[found.name](*map(number, values)))


def told(values: Sequence[Value]) -> str:
    """Return values as one line for people."""
    return " ".join(said(value) for value in values)


def _values(doing: Doing) -> list[Value]:
    """Return the values of a line."""
    values = [value_of(each, doing) for each in doing.row.values]
    doing.mark = doing.row.mark
    return values


def _bounded(word: str, index: int, value: object) -> float:
    """Return a number that a word takes there. Raises `Trouble` where it is out of its bounds."""
    found = number(value)
    slot = slot_of(WORDS[word].slots, index)
    wrong = None if slot is None else out_of_bounds(slot, found)
    if wrong is not None:
        raise Trouble(wrong)
    return found


# Moving.


def _go(doing: Doing, goal: PlaceValue, *, opening_mm: float | None = None) -> None:
    """Go to a place, with the fingers as the line says, or as `open` and `close` said before it."""
    row = doing.row
    line = "_line" in row.word or row.word == "draw"
    move = _move_to(goal.goal, doing.state.speed, line=line)
    about = written(row.values[0]) if WORDS[row.word].slots[0].title == "place" else ""
    if doing.state.opening == ALL_THE_WAY:
        doing.ask(Go(GripperMove(None, doing.state.speed)))
    elif opening_mm is None and isinstance(doing.state.opening, float):
        opening_mm = doing.state.opening
    if opening_mm is None:
        doing.ask(Go(move, about))
    else:
        doing.ask(Go(MoveSequence((GripperMove(opening_mm, doing.state.speed), move)), about))


def _move_to(goal: Pose | Mapping[str, float], speed: float, *, line: bool) -> Motion:
    if isinstance(goal, Pose):
        return LineMove(goal, speed) if line else PoseMove(goal, speed)
    joints = Joints.of(*goal.values(), names=tuple(goal))
    return LineMove(joints, speed) if line else JointMove(joints, speed)


def _move(doing: Doing) -> None:
    goal, *width = _values(doing)
    opening_mm = _bounded(doing.row.word, 1, width[0]) if width else None
    _go(doing, place(goal), opening_mm=opening_mm)


def _approach(doing: Doing) -> None:
    goal, distance = _values(doing)
    _go(doing, PlaceValue(backed(pose_of(place(goal), doing.fk), number(distance))))


def _depart(doing: Doing) -> None:
    here = doing.ask(Look())
    (distance,) = _values(doing)
    _go(doing, PlaceValue(backed(pose_of(place(here), doing.fk), number(distance))))


def _draw(doing: Doing) -> None:
    here = doing.ask(Look())
    along = _values(doing)
    _go(doing, PlaceValue(moved(pose_of(place(here), doing.fk), *map(number, along))))


def _ready(doing: Doing) -> None:
    if doing.state.opening is not None:
        opening_mm = doing.state.opening if isinstance(doing.state.opening, float) else None
        doing.ask(Go(GripperMove(opening_mm, doing.state.speed)))
    doing.ask(Go(ParkMove(doing.state.speed)))


def _home(doing: Doing) -> None:
    doing.ask(Home())


def _speed(doing: Doing) -> None:
    (speed,) = _values(doing)
    doing.state.speed = _bounded("speed", 0, speed)


# Fingers and places.


def _open(doing: Doing) -> None:
    values = _values(doing)
    doing.state.opening = _bounded("open", 0, values[0]) if values else ALL_THE_WAY


def _close(doing: Doing) -> None:
    doing.state.opening = 0.0


def _open_now(doing: Doing) -> None:
    values = _values(doing)
    opening_mm = _bounded("open_now", 0, values[0]) if values else None
    doing.ask(Go(GripperMove(opening_mm, doing.state.speed)))


def _close_now(doing: Doing) -> None:
    doing.ask(Go(GripperMove(0.0, doing.state.speed)))


def _grasp(doing: Doing) -> None:
    doing.store(doing.ask(Go(GraspMove())))


def _here(doing: Doing) -> None:
    doing.store(doing.ask(Look()))


def _remember(doing: Doing) -> None:
    (value,) = _values(doing)
    found = place(value)
    name = written(doing.row.values[0])
    doing.ask(Remember(name, found.joints_deg or {}, found.opening_mm))


def _shift(doing: Doing) -> None:
    doing.store(PLACING["shifted"](_values(doing), doing.fk))


# Waiting, inputs and outputs.


def _delay(doing: Doing) -> None:
    (time_s,) = _values(doing)
    doing.ask(Delay(_bounded("delay", 0, time_s)))


def _parted(word: str, values: Sequence[Value]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the numbers that are on, and those with a minus, which are off."""
    counts = [int(_bounded(word, index, value)) for index, value in enumerate(values)]
    on = tuple(dict.fromkeys(count for count in counts if count > 0))
    off = tuple(dict.fromkeys(-count for count in counts if count < 0))
    both = set(on) & set(off)
    if both:
        raise Trouble(f"{min(both)} cannot be both on and off")
    return on, off


def _signal(doing: Doing) -> None:
    doing.ask(Outputs(*_parted("signal", _values(doing))))


def _wait_input(doing: Doing) -> None:
    row, values, limit_s = doing.row, _values(doing), None
    if row.limit is not None:
        limit_s = number(value_of(row.limit, doing))
        doing.mark = row.mark
        if (wrong := out_of_bounds(TIME, limit_s)) is not None:
            raise Trouble(wrong)
    came = doing.ask(AwaitInputs(*_parted("wait_input", values), limit_s))
    if row.into:
        doing.store(came)
    elif row.limit is not None and not came:
        wanted = ", ".join(written(value) for value in row.values)
        raise Trouble(f"the inputs were not {wanted} within {written(row.limit)} s")


def _hold(doing: Doing) -> None:
    doing.ask(Hold(told(_values(doing))))


def _type(doing: Doing) -> None:
    values = _values(doing)
    doing.ask(Say(told(values), tuple(values)))


# Going on.


def _expect(doing: Doing) -> None:
    condition, *rest = doing.row.values
    holds = value_of(condition, doing)
    doing.mark = doing.row.mark
    if truth(holds):
        return
    values = [value_of(each, doing) for each in rest]
    doing.mark = doing.row.mark
    raise Trouble(told(values) if rest else f"it was expected that {written(condition)}")


def _stop(doing: Doing) -> None:
    if doing.row.values:
        _type(doing)
    doing.state.ended = True


def _return(doing: Doing) -> None:
    *outer, frame = doing.state.frames
    if outer:
        doing.state.frames = tuple(outer)
        doing.following = frame.back
    else:
        doing.state.ended = True


def _assign(doing: Doing) -> None:
    (value,) = _values(doing)
    doing.store(value)


def _unless(doing: Doing) -> None:
    (condition,) = _values(doing)
    if not truth(condition):
        doing.following = doing.row.target


def _jump(doing: Doing) -> None:
    doing.following = doing.row.target


def _rounds(doing: Doing) -> None:
    values = _values(doing)
    count = number(values[0]) if values else None
    if count is not None and (count < 0.0 or count != int(count)):
        raise Trouble(f"a loop is repeated a whole number of times, not {count:g}")
    loop = str(doing.state.at + 1)  # known by the line that begins its rounds
    doing.state.frames[-1].loops[loop] = (0, None if count is None else int(count))


def _round(doing: Doing) -> None:
    loops, loop = doing.state.frames[-1].loops, str(doing.state.at)
    begun, most = loops[loop]
    if most is not None and (begun or 0) >= most:
        doing.following = doing.row.target
        return
    if most is None and not doing.row.into:
        return  # nothing counts these rounds, so the program is in the same state in each
    begun = (begun or 0) + 1
    loops[loop] = (begun, most)
    doing.store(float(begun))


def _call(doing: Doing) -> None:
    values, state = _values(doing), doing.state
    if len(state.frames) > DEEPEST_CALL:
        raise Trouble(f"subprograms call one another more than {DEEPEST_CALL} deep")
    own = dict(zip(doing.row.into, values, strict=True))
    state.frames += (CallFrame(state.at + 1, doing.row.mark, own),)
    doing.following = doing.row.target


DEEDS: Mapping[str, Callable[[Doing], None]] = MappingProxyType({
    "move": _move, "move_line": _move, "move_with": _move, "move_line_with": _move,
    "approach": _approach, "approach_line": _approach, "depart": _depart, "depart_line": _depart,
    "draw": _draw, "ready": _ready, "home": _home, "speed": _speed,
    "open": _open, "close": _close, "open_now": _open_now, "close_now": _close_now,
    "grasp": _grasp, "here": _here, "remember": _remember, "shift": _shift,
    "delay": _delay, "signal": _signal, "wait_input": _wait_input, "hold": _hold, "type": _type,
    "expect": _expect, STOP: _stop, RETURN: _return,
    ASSIGN: _assign, UNLESS: _unless, JUMP: _jump, ROUNDS: _rounds, ROUND: _round, CALL: _call,
})  # fmt: skip
"""What every instruction does."""
