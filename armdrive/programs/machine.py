"""A program under way: it gives acts one at a time, takes their answers, and can be written down.

Pure: it knows no arm and no clock. See acts.Machine for what each call promises. A snapshot holds
the state before the act that is to be carried out now, so that a machine restored from it gives the
same act again, and the same rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

from armdrive.errors import ArmError
from armdrive.moves import GripperMove
from armdrive.programs.acts import (
    MOTIONS,
    Act,
    Answer,
    Go,
    Home,
    Look,
    ReadInput,
    RunSetting,
    RunStage,
    SeenInput,
    act_of,
    bounded,
    told,
)
from armdrive.programs.language.compiling import CompiledCode, Instruction, OpCode
from armdrive.programs.language.syntax import Define, Tree
from armdrive.programs.language.values import (
    NUMERIC,
    PLACING,
    SUMS,
    ForwardKinematics,
    PlaceValue,
    Trouble,
    Value,
    from_json,
    number,
    out_of_bounds,
    part_of,
    place,
    to_json,
    truth,
)
from armdrive.programs.language.words import FUNCTIONS, ValueKind
from armdrive.programs.problems import Problem, ProgramError, SourceMark, program_error
from kinematics.errors import KinematicsError

# All that a program under way knows, and how it is written down as plain JSON data.

ALL_THE_WAY = "open"
"""The opening with the next move where none in mm was said."""


@dataclass(slots=True)
class CallFrame:
    """A subprogram under way: its parameters and loops, where it goes back to, who called it."""

    back: int = 0
    mark: SourceMark | None = None
    own: dict[str, Value] = field(default_factory=dict)
    loops: dict[str, list[int | None]] = field(default_factory=dict)
    """Of each loop the rounds that are begun and the rounds that there are, None for no end."""


@dataclass(slots=True)
class MachineState:
    """Where a program is, and what it has computed."""

    at: int = 0
    stack: list[Value] = field(default_factory=list)
    frames: list[CallFrame] = field(default_factory=lambda: [CallFrame()])
    variables: dict[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None
    """What the fingers are to do with the next move: mm, `ALL_THE_WAY`, or nothing."""
    ended: bool = False


def state_to_json(state: MachineState) -> dict[str, object]:
    """Return a state as plain JSON data."""
    return {
        "at": state.at,
        "stack": [to_json(value) for value in state.stack],
        "frames": [_frame_to_json(frame) for frame in state.frames],
        "variables": _values_to_json(state.variables),
        "speed": state.speed,
        "opening": state.opening,
        "ended": state.ended,
    }


def state_from_json(data: dict[str, object]) -> MachineState:
    """Return a state from plain JSON data; raises what Python raises for data of another form."""
    frames = [_frame_from_json(frame) for frame in _list(data["frames"])]
    if not frames:
        raise ValueError("a program under way has a frame")
    return MachineState(
        _whole(data["at"]),
        [from_json(value) for value in _list(data["stack"])],
        frames,
        _values_from_json(data["variables"]),
        _number(data["speed"]),
        _opening_of(data["opening"]),
        bool(data["ended"]),
    )


def _opening_of(data: object) -> float | str | None:
    if data is None:
        return None
    return ALL_THE_WAY if data == ALL_THE_WAY else _number(data)


def _frame_to_json(frame: CallFrame) -> dict[str, object]:
    mark = frame.mark
    return {
        "back": frame.back,
        "mark": None if mark is None else [mark.line, mark.column, mark.file],
        "own": _values_to_json(frame.own),
        "loops": {name: list(rounds) for name, rounds in frame.loops.items()},
    }


def _frame_from_json(data: object) -> CallFrame:
    frame = table(data)
    mark = frame["mark"]
    loops = {
        name: [None if count is None else _whole(count) for count in _list(rounds)]
        for name, rounds in table(frame["loops"]).items()
    }
    return CallFrame(
        _whole(frame["back"]),
        None if mark is None else SourceMark(*_list(mark)),  # type: ignore[arg-type]
        _values_from_json(frame["own"]),
        loops,
    )


def _values_to_json(values: dict[str, Value]) -> dict[str, object]:
    return {name: to_json(value) for name, value in values.items()}


def _values_from_json(data: object) -> dict[str, Value]:
    return {name: from_json(value) for name, value in table(data).items()}


def table(data: object) -> dict[str, object]:
    """Return a table of JSON data; raises `TypeError` for anything else."""
    if not isinstance(data, dict):
        raise TypeError(f"{data!r} is no table")
    return data


def _list(data: object) -> list[object]:
    if not isinstance(data, list):
        raise TypeError(f"{data!r} is no list")
    return data


def _whole(data: object) -> int:
    if type(data) is not int:
        raise TypeError(f"{data!r} is no whole number")
    return data


def _number(data: object) -> float:
    if isinstance(data, bool) or not isinstance(data, int | float):
        raise TypeError(f"{data!r} is no number")
    return float(data)


# What each instruction does to the state of a program; acts are asked for, not carried out.

# ruff: noqa: ARG001 - one form for all functions of the table below


DEEPEST_CALL = 50
"""Subprograms may call one another, or themselves, so deep."""


@dataclass(frozen=True, slots=True)
class ProgramWorld:
    """What a program is told once: the arm's book of points, and the way from joints to a pose."""

    points: Mapping[str, PlaceValue]
    fk: ForwardKinematics | None


def step(state: MachineState, row: Instruction, world: ProgramWorld) -> Act | None:
    """Carry an instruction out, or return the act that it asks for. Raises `Trouble`."""
    return _STEPS[row.op](state, row, world)


def _next(state: MachineState, *pushed: Value) -> None:
    state.stack.extend(pushed)
    state.at += 1


def _taken(state: MachineState, count: int) -> list[Value]:
    if not count:
        return []
    taken = state.stack[-count:]
    del state.stack[-count:]
    return taken


def _push(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    _next(state, row.value if row.value is not None else 0.0)


def _load(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    if row.name not in state.variables:
        raise Trouble(f"{row.name!r} has no value yet")
    _next(state, state.variables[row.name])


def _load_own(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    _next(state, state.frames[-1].own[row.name])


def _load_point(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    _next(state, world.points[row.name])


def _load_shifted(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    shifted = state.variables.get(row.name.lower())
    _next(state, world.points[row.name] if shifted is None else shifted)


def _store(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.variables[row.name] = state.stack.pop()
    _next(state)


def _store_own(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.frames[-1].own[row.name] = state.stack.pop()
    _next(state)


def _drop(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.stack.pop()
    _next(state)


def _negate(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    _next(state, -number(state.stack.pop()))


def _not(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    _next(state, not truth(state.stack.pop()))


def _binary(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    left, right = _taken(state, 2)
    if row.name in ("==", "!="):
        _next(state, (left == right) == (row.name == "=="))
        return
    result = SUMS[row.name](number(left), number(right))
    _next(state, result if isinstance(result, bool) else number(result))


def _use(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    values = _taken(state, row.count)
    if row.name in PLACING:
        _next(state, PLACING[row.name](values, world.fk))
    else:
        _next(state, number(NUMERIC[row.name](*(number(value) for value in values))))


def _part(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    _next(state, part_of(place(state.stack.pop()), row.name, world.fk))


def _joints(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    angles = [number(value) for value in _taken(state, row.count)]
    _next(state, PlaceValue(joints_deg=dict(zip(row.name.split(","), angles, strict=True))))


def _jump(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.at = row.target


def _jump_unless(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.at = state.at + 1 if truth(state.stack.pop()) else row.target


def _jump_if(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.at = row.target if truth(state.stack.pop()) else state.at + 1


def _keep(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    if truth(state.stack[-1]) == (row.op is OpCode.KEEP_ON):
        state.at = row.target
    else:
        _drop(state, row, world)


def _rounds(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    count = number(state.stack.pop())
    if count < 0.0 or count != int(count):
        raise Trouble(f"a loop is repeated a whole number of times, not {count:g}")
    state.frames[-1].loops[row.name] = [0, int(count)]
    _next(state)


def _forever(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.frames[-1].loops[row.name] = [0, None]
    _next(state)


def _round(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    begun, most = state.frames[-1].loops[row.name]
    if most is not None and begun is not None and begun >= most:
        state.at = row.target
    else:
        _count(state, row, world)


def _count(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    rounds = state.frames[-1].loops[row.name]
    rounds[0] = begun = (rounds[0] or 0) + 1
    _next(state, float(begun))


def _call(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    if len(state.frames) > DEEPEST_CALL:
        raise Trouble(f"subprograms call one another more than {DEEPEST_CALL} deep")
    state.frames.append(CallFrame(state.at + 1, row.mark))
    state.at = row.target


def _return(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    if len(state.frames) == 1:
        state.ended = True
    else:
        state.at = state.frames.pop().back


def _end(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.ended = True


def _fail(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    raise Trouble(str(row.value) if row.value else told(_taken(state, row.count)))


def _speed(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.speed = bounded("speed", 0, state.stack[-1])
    _drop(state, row, world)


def _opening(state: MachineState, row: Instruction, world: ProgramWorld) -> None:
    state.opening = bounded("open", 0, state.stack.pop()) if row.count else ALL_THE_WAY
    _next(state)


# -- acts: they leave the state as it is; it goes on when they are answered -------------------


def _fingers(state: MachineState, row: Instruction, world: ProgramWorld) -> Act | None:
    if state.opening == ALL_THE_WAY:
        return Go(GripperMove(None, state.speed))
    if row.name == "ready" and isinstance(state.opening, float):
        return Go(GripperMove(state.opening, state.speed))
    _next(state)
    return None


def _look(state: MachineState, row: Instruction, world: ProgramWorld) -> Act:
    return Look()


def _input(state: MachineState, row: Instruction, world: ProgramWorld) -> Act:
    count = number(state.stack[-1])
    wrong = out_of_bounds(FUNCTIONS["input"].slots[0], count)
    if wrong is not None:
        raise Trouble(wrong)
    return ReadInput(int(count))


def _act(state: MachineState, row: Instruction, world: ProgramWorld) -> Act:
    opening = state.opening if isinstance(state.opening, float) else None
    values = state.stack[len(state.stack) - row.count :]
    return act_of(row.name, values, RunSetting(state.speed, opening, row.about, world.fk))


_Perform = Callable[[MachineState, Instruction, ProgramWorld], Act | None]

_STEPS: Mapping[OpCode, _Perform] = MappingProxyType(
    {
        OpCode.PUSH: _push,
        OpCode.LOAD: _load,
        OpCode.LOAD_OWN: _load_own,
        OpCode.LOAD_POINT: _load_point,
        OpCode.LOAD_SHIFTED: _load_shifted,
        OpCode.STORE: _store,
        OpCode.STORE_OWN: _store_own,
        OpCode.DROP: _drop,
        OpCode.NEGATE: _negate,
        OpCode.NOT: _not,
        OpCode.BINARY: _binary,
        OpCode.USE: _use,
        OpCode.PART: _part,
        OpCode.JOINTS: _joints,
        OpCode.JUMP: _jump,
        OpCode.JUMP_UNLESS: _jump_unless,
        OpCode.JUMP_IF: _jump_if,
        OpCode.KEEP_OFF: _keep,
        OpCode.KEEP_ON: _keep,
        OpCode.ROUNDS: _rounds,
        OpCode.FOREVER: _forever,
        OpCode.ROUND: _round,
        OpCode.COUNT: _count,
        OpCode.CALL: _call,
        OpCode.RETURN: _return,
        OpCode.END: _end,
        OpCode.FAIL: _fail,
        OpCode.SPEED: _speed,
        OpCode.OPENING: _opening,
        OpCode.FINGERS: _fingers,
        OpCode.LOOK: _look,
        OpCode.INPUT: _input,
        OpCode.ACT: _act,
    }
)


# What a program is read with when others have run before it, as the lines of a prompt do.


@dataclass(frozen=True, slots=True)
class Context:
    """The subprograms and values that are known already, by names in lower case.

    `opening` is what the fingers are to do with the next move, see state.State.
    """

    defines: tuple[Define, ...] = ()
    variables: Mapping[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None

    @property
    def kinds(self) -> dict[str, ValueKind]:
        """Of which kind each value is."""
        return {name: kind_of(value) for name, value in self.variables.items()}

    def but(self, defines: tuple[Define, ...]) -> tuple[Define, ...]:
        """Return the subprograms that these do not replace, and behind them these."""
        said = {define.name.lower() for define in defines}
        return (*(each for each in self.defines if each.name.lower() not in said), *defines)


def kind_of(value: Value) -> ValueKind:
    """Return of which kind a value is."""
    if isinstance(value, bool):
        return ValueKind.TRUTH
    if isinstance(value, PlaceValue):
        return ValueKind.PLACE
    return ValueKind.TEXT if isinstance(value, str) else ValueKind.NUMBER


MOST_STEPS = 200_000
"""So many instructions may be carried out between two acts: some tenths of a second."""

FORMAT = 1
"""The form of a snapshot."""


class CompiledProgram(Protocol):
    """What a machine needs to know of the program that it runs."""

    @property
    def text(self) -> str:
        """The text, which errors quote."""

    @property
    def file(self) -> str:
        """The file that the text was read from; may be empty."""

    @property
    def tree(self) -> Tree:
        """The lines as they were written."""

    @property
    def code(self) -> CompiledCode:
        """The instructions to carry out."""

    @property
    def context(self) -> Context:
        """The names that were known before the program."""

    @property
    def digest(self) -> str:
        """A hash of the text."""

    @property
    def code_digest(self) -> str:
        """A hash of the instructions."""


class Machine:
    """One run of a program; made by `Program.machine` and `Program.restored`."""

    def __init__(
        self, program: CompiledProgram, world: ProgramWorld, state: MachineState | None = None
    ) -> None:
        self.program = program
        self._world = world
        self._state = MachineState() if state is None else state
        self._stage: RunStage | None = None
        self._error: ProgramError | None = None

    @classmethod
    def restored(
        cls,
        program: CompiledProgram,
        snapshot: Mapping[str, object],
        *,
        fk: ForwardKinematics | None = None,
    ) -> Machine:
        """Take a run up again where its snapshot was made, with the points that it had then.

        Raises `ProgramError` for a snapshot of another program, or of another form.
        """
        if snapshot.get("format") != FORMAT:
            raise ProgramError("this state of a program was written by another version of armdrive")
        digests = (snapshot.get("program"), snapshot.get("code"))
        if digests != (program.digest, program.code_digest):
            raise ProgramError("the program has been changed since: begin it anew")
        try:
            places = {name: _place(data) for name, data in table(snapshot["points"]).items()}
            state = state_from_json(table(snapshot["state"]))
            machine = cls(program, ProgramWorld(places, fk), state)
            machine._row()  # a state that stands nowhere is none
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise ProgramError(f"this state of a program cannot be used: {error}") from None
        return machine

    @property
    def mark(self) -> SourceMark:
        """Where in the program it stands."""
        return self._row().mark

    @property
    def ended_by_stop(self) -> bool:
        """Whether it ended at a `stop`, and not behind its last line."""
        return self._state.ended and self._row().op is OpCode.END

    @property
    def context(self) -> Context:
        """What it has brought so far, for a program that is read with it: see `read_program`."""
        known, state = self.program.context, self._state
        own = tuple(line for line in self.program.tree.body if isinstance(line, Define))
        return Context(known.but(own), dict(state.variables), state.speed, state.opening)

    def next(self) -> RunStage | None:
        """Return the act to be carried out now, the same until it is answered; None at the end.

        Raises `ProgramError` where a line cannot be carried out; asked again, it raises again.
        """
        if self._error is not None:
            raise self._error
        if self._stage is None and not self._state.ended:
            act = self._run_on()
            if act is not None:
                calls = tuple(frame.mark for frame in self._state.frames if frame.mark is not None)
                self._stage = RunStage(act, self._row().mark, calls)
        return self._stage

    def answer(self, answer: Answer) -> None:
        """Say what the act brought, and go on behind it. Raises `ProgramError` for a wrong kind."""
        stage = self.next()
        if stage is None:
            raise ProgramError("the program has ended: nothing is to be answered")
        row, state = self._row(), self._state
        try:
            pushed = _pushed(row, answer)
        except Trouble as error:
            raise self._failure(f"the answer does not fit: {error}") from None
        if row.op in (OpCode.ACT, OpCode.INPUT):
            del state.stack[len(state.stack) - row.count :]
        if isinstance(stage.act, MOTIONS) and not isinstance(stage.act, Home):
            state.opening = None  # it went along, or something else was done with the fingers
        state.stack.extend(pushed)
        state.at += 1
        self._stage = None

    def snapshot(self) -> dict[str, object]:
        """Return all that the program knows at this point, as plain JSON data."""
        return {
            "format": FORMAT,
            "program": self.program.digest,
            "code": self.program.code_digest,
            "points": {name: to_json(place) for name, place in self._world.points.items()},
            "state": state_to_json(self._state),
        }

    def _row(self) -> Instruction:
        if self._state.at < 0:
            raise IndexError("before the program")
        return self.program.code.instructions[self._state.at]

    def _run_on(self) -> Act | None:
        """Go on to the next act. Where that fails, the state stays what it was after the last."""
        before = state_to_json(self._state)
        try:
            return self._run()
        except (Trouble, ArmError, KinematicsError) as error:
            self._error = self._failure(str(error))
        self._state = state_from_json(before)
        raise self._error

    def _run(self) -> Act | None:
        for _ in range(MOST_STEPS):
            act = step(self._state, self._row(), self._world)
            if act is not None or self._state.ended:
                return act
        raise Trouble("the program goes round here without ever asking anything of the arm")

    def _failure(self, text: str) -> ProgramError:
        calls = [frame.mark for frame in self._state.frames if frame.mark is not None]
        led = "".join(f", called in line {mark.line}" for mark in reversed(calls[-3:]))
        return program_error(
            [Problem(self._row().mark, text + led)], self.program.text, self.program.file
        )


def _place(data: object) -> PlaceValue:
    found = from_json(data)
    if not isinstance(found, PlaceValue):
        raise TypeError(f"{data!r} is no place")
    return found


def _pushed(row: Instruction, answer: Answer) -> tuple[Value, ...]:
    """Return what an answer leaves for the lines after it."""
    if row.op is OpCode.LOOK:
        if not isinstance(answer, SeenInput):
            raise Trouble("where the arm stands is needed")
        return (PlaceValue(answer.pose, dict(answer.joints_deg), answer.opening_mm),)
    if row.op is OpCode.INPUT:
        return (truth(answer),)
    if not row.value:
        return ()
    if row.name == "grasp":
        return (number(answer),)
    return (True,) if row.name == "wait" else (truth(answer),)
