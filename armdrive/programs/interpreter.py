"""What each word of a program does: one function per word, which asks the arm for acts.

A function is written as if its acts were answered at once. When it asks for an act that has no
answer yet, it is abandoned with `ActNeeded`. After the answer it runs again from its beginning and
finds the answers so far: see `LineContext.ask`. So the answers are all that has to be saved about a
line that was interrupted in its middle.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from types import MappingProxyType

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
from armdrive.programs.language.syntax import (
    Do,
    Expression,
    JointsOf,
    Literal,
    Name,
    Statement,
    Use,
    set_by,
)
from armdrive.programs.language.values import (
    PLACING,
    ForwardKinematics,
    LineFailure,
    PlaceValue,
    Value,
    backed,
    computed,
    moved,
    number,
    out_of_bounds,
    place,
    pose_of,
    slot_of,
    truth,
    value_text,
)
from armdrive.programs.language.words import CALLABLE, HERE, TIME, WORDS, Slot
from armdrive.programs.problems import SourceMark
from armdrive.text.json_forms import (
    NUMBER,
    WHOLE,
    Form,
    Json,
    by_name,
    optional,
    record,
    several,
)
from kinematics.spaces import Joints, Pose

# The state of a running program, and how it is written down as JSON data.

# The opening for the next move after `open` without a width.
ALL_THE_WAY = "open"


@dataclass(slots=True)
class Frame:
    """A block that is under way, by its number, and the line there.

    Of a `repeat`, `begun` counts the rounds, and `rounds` is how many there are, None without an
    end. `own` are the parameters of a call; None for a block within another one.
    """

    block: int = 0
    at: int = 0
    begun: int = 0
    rounds: int | None = None
    own: dict[str, Value] | None = None


@dataclass(slots=True)
class MachineState:
    """Where a program is, and what it has computed.

    `frames` are the blocks around the present line, from the program itself inwards. `answers` are
    those to the acts of this line. `moved` says that one of these acts has already brought the
    fingers to `opening`.
    """

    frames: tuple[Frame, ...] = field(default_factory=lambda: (Frame(own={}),))
    answers: tuple[Value, ...] = ()
    moved: bool = False
    variables: dict[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None
    """The opening that the fingers take with the next move: mm, `ALL_THE_WAY`, or None."""
    ended: bool = False


def _opening(data: Json, where: str) -> float | str | None:
    return data if data is None or data == ALL_THE_WAY else NUMBER.read(data, where)


_PLACE = record(
    PlaceValue,
    pose=optional(Form(astuple, lambda data, _: Pose(*data), {})),
    joints_deg=optional(by_name(NUMBER)),
    opening_mm=optional(NUMBER),
)


def _to_json(value: Value) -> Json:
    """Return a value as plain JSON data."""
    return _PLACE.write(value) if isinstance(value, PlaceValue) else value


def _from_json(data: Json, where: str) -> Value:
    if isinstance(data, bool | str):
        return data
    return _PLACE.read(data, where) if isinstance(data, dict) else NUMBER.read(data, where)


VALUE: Form[Value] = Form(_to_json, _from_json, {})
_TRUTH: Form[bool] = Form(bool, lambda data, _: bool(data), {})
_FRAME = record(
    Frame, block=WHOLE, at=WHOLE, begun=WHOLE, rounds=optional(WHOLE), own=optional(by_name(VALUE))
)
# How a state is written down; reading anything else raises `BadArgument`.
STATE = record(
    MachineState,
    frames=several(_FRAME),
    answers=several(VALUE),
    moved=_TRUTH,
    variables=by_name(VALUE),
    speed=NUMBER,
    opening=Form(lambda opening: opening, _opening, {}),
    ended=_TRUTH,
)


# One line while it runs.


class ActNeeded(Exception):
    """A line needs the answer to an act before it can go on; `mark` is where the act is."""

    def __init__(self, act: Act, mark: SourceMark) -> None:
        super().__init__()
        self.act = act
        self.mark = mark


class LineContext:
    """The line that runs now. `mark` is the value under evaluation, where an error is shown."""

    def __init__(
        self,
        state: MachineState,
        line: Statement,
        points: Mapping[str, PlaceValue],
        fk: ForwardKinematics | None,
    ) -> None:
        self.state = state
        self.line = line
        # the line as a word with its values, if it is one
        self.do = line if isinstance(line, Do) else Do("")
        self.fk = fk
        self.mark = line.mark
        self._points = points
        self._answered = 0

    def ask(self, act: Act, mark: SourceMark | None = None) -> Value:
        """Return the answer to an act. Raises `ActNeeded` while there is none."""
        # the line has run to here before, so the first acts it asks for have their answers already
        if self._answered == len(self.state.answers):
            raise ActNeeded(act, mark or self.line.mark)
        self._answered += 1
        return self.state.answers[self._answered - 1]

    @property
    def own(self) -> dict[str, Value]:
        """The parameters of the present call."""
        return next(frame.own for frame in reversed(self.state.frames) if frame.own is not None)

    def named(self, name: str) -> Value:
        """Return the value of a name: a parameter, a variable, or a point of the arm's book."""
        low = name.lower()
        # a parameter hides a variable, a variable hides a point; only points differ by capitals
        for values, key in ((self.own, low), (self.state.variables, low), (self._points, name)):
            if key in values:
                return values[key]
        raise LineFailure(f"{name!r} has no value yet")

    def taught(self, name: str) -> PlaceValue:
        """Return a point of the arm's own book."""
        return self._points[name]

    def store(self, value: Value) -> None:
        """Give the name that the line sets, if it sets any, a value."""
        for name in set_by(self.line):
            low = name.name.lower()
            (self.own if low in self.own else self.state.variables)[low] = value

    def values(self, found: Sequence[Expression], slots: Sequence[Slot] = ()) -> list[Value]:
        """Return the values of expressions, within the bounds of slots. Raises `LineFailure`."""
        values = [value_of(each, self) for each in found]
        self.mark = self.line.mark
        _require_bounds(slots, values)
        return values


# Values.


def value_of(found: Expression, context: LineContext) -> Value:
    """Evaluate an expression. Raises `LineFailure` if it has no value."""
    match found:
        case Literal():
            return found.value
        case Name(name=name):
            context.mark = found.mark
            return context.ask(Look(), found.mark) if name.lower() == HERE else context.named(name)
        case JointsOf():
            angles = [(name, value_of(each, context)) for name, each in found.angles]
            context.mark = found.mark
            return PlaceValue(joints_deg={name: number(angle) for name, angle in angles})
        case Use(name="taught", arguments=(Literal(value=str(name)), *_)):
            return context.taught(name)
        case Use(name="and" | "or" as sign, arguments=(left, right)):
            first = value_of(left, context)
            context.mark = found.mark
            decided = truth(first)
            # the right side is evaluated only if it decides: it may read an input of the arm
            return decided if decided is (sign == "or") else value_of(right, context)
        case Use(name=name, arguments=arguments):
            values = [value_of(each, context) for each in arguments]
            context.mark = found.mark
            _require_bounds(CALLABLE[name].slots, values)
            if name == "input":
                return context.ask(ReadInput(int(number(values[0]))), found.mark)
            return computed(name, values, context.fk)


def values_text(values: Sequence[Value]) -> str:
    """Return values as one line of text."""
    return " ".join(value_text(value) for value in values)


def _require_bounds(slots: Sequence[Slot], values: Sequence[Value]) -> None:
    """Raise `LineFailure` for a number that is out of bounds."""
    for index, value in enumerate(values):
        slot = slot_of(slots, index)
        if slot is not None and isinstance(value, float):
            wrong = out_of_bounds(slot, value)
            if wrong is not None:
                raise LineFailure(wrong)


def _values(context: LineContext) -> list[Value]:
    """Return the values of a word. Raises `LineFailure`."""
    return context.values(context.do.arguments, WORDS[context.do.word].slots)


def _numbers(context: LineContext) -> list[float]:
    return [number(value) for value in _values(context)]


def _links(context: LineContext) -> dict[str, tuple[Expression, ...]]:
    return dict(context.do.links)


# Moving.


def _go(context: LineContext, goal: PlaceValue, *, opening_mm: float | None = None) -> None:
    """Go to a place; the fingers take the line's opening, or that of an earlier `open`."""
    word, arguments = context.do.word, context.do.arguments
    move = _move_to(goal.goal, context.state.speed, line="_line" in word or word == "draw")
    about = next((each.name for each in arguments if isinstance(each, Name)), "")
    if context.state.opening == ALL_THE_WAY:
        context.ask(Go(GripperMove(None, context.state.speed)))
    elif opening_mm is None and isinstance(context.state.opening, float):
        opening_mm = context.state.opening
    if opening_mm is None:
        context.ask(Go(move, about))
    else:
        context.ask(Go(MoveSequence((GripperMove(opening_mm, context.state.speed), move)), about))


def _move_to(goal: Pose | Mapping[str, float], speed: float, *, line: bool) -> Motion:
    if isinstance(goal, Pose):
        return LineMove(goal, speed) if line else PoseMove(goal, speed)
    joints = Joints.of(*goal.values(), names=tuple(goal))
    return LineMove(joints, speed) if line else JointMove(joints, speed)


def _move(context: LineContext) -> None:
    goal, *width = _values(context)
    _go(context, place(goal), opening_mm=number(width[0]) if width else None)


def _approach(context: LineContext) -> None:
    goal, distance = _values(context)
    _go(context, PlaceValue(backed(pose_of(place(goal), context.fk), number(distance))))


def _depart(context: LineContext) -> None:
    here = context.ask(Look())
    (distance_mm,) = _numbers(context)
    _go(context, PlaceValue(backed(pose_of(place(here), context.fk), distance_mm)))


def _draw(context: LineContext) -> None:
    here = context.ask(Look())
    along_mm = _numbers(context)
    _go(context, PlaceValue(moved(pose_of(place(here), context.fk), *along_mm)))


def _ready(context: LineContext) -> None:
    if context.state.opening is not None:
        opening_mm = context.state.opening if isinstance(context.state.opening, float) else None
        context.ask(Go(GripperMove(opening_mm, context.state.speed)))
    context.ask(Go(ParkMove(context.state.speed)))


def _home(context: LineContext) -> None:
    context.ask(Home())


def _speed(context: LineContext) -> None:
    (context.state.speed,) = _numbers(context)


# Fingers and places.


def _open(context: LineContext) -> None:
    widths_mm = _numbers(context)
    context.state.opening = widths_mm[0] if widths_mm else ALL_THE_WAY


def _close(context: LineContext) -> None:
    context.state.opening = 0.0


def _open_now(context: LineContext) -> None:
    widths_mm = _numbers(context)
    opening_mm = widths_mm[0] if widths_mm else None
    context.ask(Go(GripperMove(opening_mm, context.state.speed)))


def _close_now(context: LineContext) -> None:
    context.ask(Go(GripperMove(0.0, context.state.speed)))


def _grasp(context: LineContext) -> None:
    context.store(context.ask(Go(GraspMove())))


def _here(context: LineContext) -> None:
    context.store(context.ask(Look()))


def _remember(context: LineContext) -> None:
    found = place(context.ask(Look()))
    context.store(found)
    name = next(set_by(context.line))
    context.ask(Remember(name.name, found.joints_deg or {}, found.opening_mm))


def _shift(context: LineContext) -> None:
    name = next(set_by(context.line))
    values = context.values((name, *_links(context)["by"]))
    context.store(PLACING["shifted"](values, context.fk))


# Waiting, inputs and outputs.


def _delay(context: LineContext) -> None:
    (time_s,) = _numbers(context)
    context.ask(Delay(time_s))


def _parted(numbers: Sequence[float]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the numbers without a minus, which mean on, and those with one, which mean off."""
    counts = [int(each) for each in numbers]
    on = tuple(dict.fromkeys(count for count in counts if count > 0))
    off = tuple(dict.fromkeys(-count for count in counts if count < 0))
    both = set(on) & set(off)
    if both:
        raise LineFailure(f"{min(both)} cannot be both on and off")
    return on, off


def _signal(context: LineContext) -> None:
    context.ask(Outputs(*_parted(_numbers(context))))


def _wait_input(context: LineContext) -> None:
    wanted, links, limit_s = _numbers(context), _links(context), None
    if "within" in links:
        limit_s = number(context.values(links["within"], (TIME,))[0])
    awaited = AwaitInputs(*_parted(wanted), limit_s)
    came = context.ask(awaited)
    if "into" in links:
        context.store(came)
    elif limit_s is not None and not came:
        raise LineFailure(f"within {limit_s:g} s it did not happen that {awaited}")


def _hold(context: LineContext) -> None:
    context.ask(Hold(values_text(_values(context))))


def _type(context: LineContext) -> None:
    values = _values(context)
    context.ask(Say(values_text(values)))


# Going on.


def _expect(context: LineContext) -> None:
    condition, *rest = context.do.arguments
    if truth(context.values((condition,))[0]):
        return
    text = values_text(context.values(rest))
    raise LineFailure(text if rest else "what is expected does not hold")


def _stop(context: LineContext) -> None:
    if context.do.arguments:
        _type(context)
    context.state.ended = True


# What each word does before the next line follows.
HANDLERS: Mapping[str, Callable[[LineContext], None]] = MappingProxyType({
    "move": _move, "move_line": _move, "move_with": _move, "move_line_with": _move,
    "approach": _approach, "approach_line": _approach, "depart": _depart, "depart_line": _depart,
    "draw": _draw, "ready": _ready, "home": _home, "speed": _speed,
    "open": _open, "close": _close, "open_now": _open_now, "close_now": _close_now,
    "grasp": _grasp, "here": _here, "remember": _remember, "shift": _shift,
    "delay": _delay, "signal": _signal, "wait_input": _wait_input, "hold": _hold, "type": _type,
    "expect": _expect, "stop": _stop,
})  # fmt: skip
