"""All that a program under way knows, and how it is written down as plain JSON data."""

from __future__ import annotations

from dataclasses import dataclass, field

from armdrive.programs.acts import Mark
from armdrive.programs.values import Value, from_json, to_json

ALL_THE_WAY = "open"
"""The opening with the next move where none in mm was said."""


@dataclass(slots=True)
class Frame:
    """A subprogram under way: its parameters and loops, where it goes back to, who called it."""

    back: int = 0
    mark: Mark | None = None
    own: dict[str, Value] = field(default_factory=dict)
    loops: dict[str, list[int | None]] = field(default_factory=dict)
    """Of each loop the rounds that are begun and the rounds that there are, None for no end."""


@dataclass(slots=True)
class State:
    """Where a program is, and what it has computed."""

    at: int = 0
    stack: list[Value] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=lambda: [Frame()])
    variables: dict[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None
    """What the fingers are to do with the next move: mm, `ALL_THE_WAY`, or nothing."""
    ended: bool = False


def state_to_json(state: State) -> dict[str, object]:
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


def state_from_json(data: dict[str, object]) -> State:
    """Return a state from plain JSON data; raises what Python raises for data of another form."""
    frames = [_frame_from_json(frame) for frame in _list(data["frames"])]
    if not frames:
        raise ValueError("a program under way has a frame")
    return State(
        _whole(data["at"]),
        [from_json(value) for value in _list(data["stack"])],
        frames,
        _values_from_json(data["variables"]),
        _number(data["speed"]),
        _opening(data["opening"]),
        bool(data["ended"]),
    )


def _opening(data: object) -> float | str | None:
    if data is None:
        return None
    return ALL_THE_WAY if data == ALL_THE_WAY else _number(data)


def _frame_to_json(frame: Frame) -> dict[str, object]:
    mark = frame.mark
    return {
        "back": frame.back,
        "mark": None if mark is None else [mark.line, mark.column, mark.file],
        "own": _values_to_json(frame.own),
        "loops": {name: list(rounds) for name, rounds in frame.loops.items()},
    }


def _frame_from_json(data: object) -> Frame:
    frame = table(data)
    mark = frame["mark"]
    loops = {
        name: [None if count is None else _whole(count) for count in _list(rounds)]
        for name, rounds in table(frame["loops"]).items()
    }
    return Frame(
        _whole(frame["back"]),
        None if mark is None else Mark(*_list(mark)),  # type: ignore[arg-type]
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
