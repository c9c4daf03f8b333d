"""What each instruction does to the state of a program; acts are asked for, not carried out."""

# ruff: noqa: ARG001 - one form for all functions of the table below

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.programs.acting import Setting, act_of, bounded, told
from armdrive.programs.acts import Act, Fingers, Look, ReadInput
from armdrive.programs.bounds import out_of_bounds
from armdrive.programs.functions import NUMERIC, PLACING, SUMS, part_of
from armdrive.programs.instructions import Instruction, Op
from armdrive.programs.state import ALL_THE_WAY, Frame, State
from armdrive.programs.values import ForwardKinematics, Place, Trouble, Value, number, place, truth
from armdrive.programs.vocabulary import FUNCTIONS

DEEPEST_CALL = 50
"""Subprograms may call one another, or themselves, so deep."""


@dataclass(frozen=True, slots=True)
class World:
    """What a program is told once: the arm's book of points, and the way from joints to a pose."""

    points: Mapping[str, Place]
    fk: ForwardKinematics | None


def step(state: State, row: Instruction, world: World) -> Act | None:
    """Carry an instruction out, or return the act that it asks for. Raises `Trouble`."""
    return _STEPS[row.op](state, row, world)


def _next(state: State, *pushed: Value) -> None:
    state.stack.extend(pushed)
    state.at += 1


def _taken(state: State, count: int) -> list[Value]:
    if not count:
        return []
    taken = state.stack[-count:]
    del state.stack[-count:]
    return taken


def _push(state: State, row: Instruction, world: World) -> None:
    _next(state, row.value if row.value is not None else 0.0)


def _load(state: State, row: Instruction, world: World) -> None:
    if row.name not in state.variables:
        raise Trouble(f"{row.name!r} has no value yet")
    _next(state, state.variables[row.name])


def _load_own(state: State, row: Instruction, world: World) -> None:
    _next(state, state.frames[-1].own[row.name])


def _load_point(state: State, row: Instruction, world: World) -> None:
    _next(state, world.points[row.name])


def _load_shifted(state: State, row: Instruction, world: World) -> None:
    shifted = state.variables.get(row.name.lower())
    _next(state, world.points[row.name] if shifted is None else shifted)


def _store(state: State, row: Instruction, world: World) -> None:
    state.variables[row.name] = state.stack.pop()
    _next(state)


def _store_own(state: State, row: Instruction, world: World) -> None:
    state.frames[-1].own[row.name] = state.stack.pop()
    _next(state)


def _drop(state: State, row: Instruction, world: World) -> None:
    state.stack.pop()
    _next(state)


def _negate(state: State, row: Instruction, world: World) -> None:
    _next(state, -number(state.stack.pop()))


def _not(state: State, row: Instruction, world: World) -> None:
    _next(state, not truth(state.stack.pop()))


def _binary(state: State, row: Instruction, world: World) -> None:
    left, right = _taken(state, 2)
    if row.name in ("==", "!="):
        _next(state, (left == right) == (row.name == "=="))
        return
    result = SUMS[row.name](number(left), number(right))
    _next(state, result if isinstance(result, bool) else number(result))


def _use(state: State, row: Instruction, world: World) -> None:
    values = _taken(state, row.count)
    if row.name in PLACING:
        _next(state, PLACING[row.name](values, world.fk))
    else:
        _next(state, number(NUMERIC[row.name](*(number(value) for value in values))))


def _part(state: State, row: Instruction, world: World) -> None:
    _next(state, part_of(place(state.stack.pop()), row.name, world.fk))


def _joints(state: State, row: Instruction, world: World) -> None:
    angles = [number(value) for value in _taken(state, row.count)]
    _next(state, Place(joints_deg=dict(zip(row.name.split(","), angles, strict=True))))


def _jump(state: State, row: Instruction, world: World) -> None:
    state.at = row.target


def _jump_unless(state: State, row: Instruction, world: World) -> None:
    state.at = state.at + 1 if truth(state.stack.pop()) else row.target


def _jump_if(state: State, row: Instruction, world: World) -> None:
    state.at = row.target if truth(state.stack.pop()) else state.at + 1


def _keep(state: State, row: Instruction, world: World) -> None:
    if truth(state.stack[-1]) == (row.op is Op.KEEP_ON):
        state.at = row.target
    else:
        _drop(state, row, world)


def _rounds(state: State, row: Instruction, world: World) -> None:
    count = number(state.stack.pop())
    if count < 0.0 or count != int(count):
        raise Trouble(f"a loop is repeated a whole number of times, not {count:g}")
    state.frames[-1].loops[row.name] = [0, int(count)]
    _next(state)


def _forever(state: State, row: Instruction, world: World) -> None:
    state.frames[-1].loops[row.name] = [0, None]
    _next(state)


def _round(state: State, row: Instruction, world: World) -> None:
    begun, most = state.frames[-1].loops[row.name]
    if most is not None and begun is not None and begun >= most:
        state.at = row.target
    else:
        _count(state, row, world)


def _count(state: State, row: Instruction, world: World) -> None:
    rounds = state.frames[-1].loops[row.name]
    rounds[0] = begun = (rounds[0] or 0) + 1
    _next(state, float(begun))


def _call(state: State, row: Instruction, world: World) -> None:
    if len(state.frames) > DEEPEST_CALL:
        raise Trouble(f"subprograms call one another more than {DEEPEST_CALL} deep")
    state.frames.append(Frame(state.at + 1, row.mark))
    state.at = row.target


def _return(state: State, row: Instruction, world: World) -> None:
    if len(state.frames) == 1:
        state.ended = True
    else:
        state.at = state.frames.pop().back


def _end(state: State, row: Instruction, world: World) -> None:
    state.ended = True


def _fail(state: State, row: Instruction, world: World) -> None:
    raise Trouble(str(row.value) if row.value else told(_taken(state, row.count)))


def _speed(state: State, row: Instruction, world: World) -> None:
    state.speed = bounded("speed", 0, state.stack[-1])
    _drop(state, row, world)


def _opening(state: State, row: Instruction, world: World) -> None:
    state.opening = bounded("open", 0, state.stack.pop()) if row.count else ALL_THE_WAY
    _next(state)


# -- acts: they leave the state as it is; it goes on when they are answered -------------------


def _fingers(state: State, row: Instruction, world: World) -> Act | None:
    if state.opening == ALL_THE_WAY:
        return Fingers(None, state.speed)
    if row.name == "ready" and isinstance(state.opening, float):
        return Fingers(state.opening, state.speed)
    _next(state)
    return None


def _look(state: State, row: Instruction, world: World) -> Act:
    return Look()


def _input(state: State, row: Instruction, world: World) -> Act:
    count = number(state.stack[-1])
    wrong = out_of_bounds(FUNCTIONS["input"].slots[0], count)
    if wrong is not None:
        raise Trouble(wrong)
    return ReadInput(int(count))


def _act(state: State, row: Instruction, world: World) -> Act:
    opening = state.opening if isinstance(state.opening, float) else None
    values = state.stack[len(state.stack) - row.count :]
    return act_of(row.name, values, Setting(state.speed, opening, row.about, world.fk))


_STEPS: Mapping[Op, Callable[[State, Instruction, World], Act | None]] = MappingProxyType({
    Op.PUSH: _push, Op.LOAD: _load, Op.LOAD_OWN: _load_own, Op.LOAD_POINT: _load_point,
    Op.LOAD_SHIFTED: _load_shifted, Op.STORE: _store, Op.STORE_OWN: _store_own, Op.DROP: _drop,
    Op.NEGATE: _negate, Op.NOT: _not, Op.BINARY: _binary, Op.USE: _use, Op.PART: _part,
    Op.JOINTS: _joints, Op.JUMP: _jump, Op.JUMP_UNLESS: _jump_unless, Op.JUMP_IF: _jump_if,
    Op.KEEP_OFF: _keep, Op.KEEP_ON: _keep, Op.ROUNDS: _rounds, Op.FOREVER: _forever,
    Op.ROUND: _round, Op.COUNT: _count, Op.CALL: _call, Op.RETURN: _return, Op.END: _end,
    Op.FAIL: _fail, Op.SPEED: _speed, Op.OPENING: _opening, Op.FINGERS: _fingers,
    Op.LOOK: _look, Op.INPUT: _input, Op.ACT: _act,
})  # fmt: skip
