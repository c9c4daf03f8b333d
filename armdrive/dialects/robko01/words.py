"""What a Robko 01 and its host say, in sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.dialects.words import moved, plain, standing
from firmware_protocol.robko01.answers import Acknowledged, Busy, Positions
from firmware_protocol.robko01.requests import (
    Disable,
    Enable,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Position,
)
from firmware_protocol.robko01.values import AXIS_NAMES, Axes


def _fastest(axes: Axes) -> int:
    return max((abs(each) for each in axes.speeds_steps_s), default=0)


def _positions(message: Positions) -> str:
    axes = message.axes
    turning = moved(AXIS_NAMES, axes.speeds_steps_s)
    still = not any(axes.speeds_steps_s)
    told = "all stand" if still else f"turning (steps/s): {turning}"
    return f"at {standing(AXIS_NAMES, axes.positions_steps)}; {told}"


def _relative(message: MoveRelative) -> str:
    axes = message.axes
    return f"move, up to {_fastest(axes)} steps/s: {moved(AXIS_NAMES, axes.positions_steps)}"


def _absolute(message: MoveAbsolute) -> str:
    axes = message.axes
    return f"move, up to {_fastest(axes)} steps/s, to {standing(AXIS_NAMES, axes.positions_steps)}"


SENTENCES: Mapping[type, Callable[[Any], str]] = MappingProxyType(
    {
        Positions: _positions,
        MoveRelative: _relative,
        MoveAbsolute: _absolute,
        MoveSpeed: lambda message: (
            f"turn without end (steps/s): {moved(AXIS_NAMES, message.axes.speeds_steps_s)}"
        ),
        Position: lambda _: "read the positions",
        Enable: lambda _: "switch the motors on",
        Disable: lambda _: "switch the motors off",
        Acknowledged: lambda message: f"{plain(message.op)}: {plain(message.status)}",
        Busy: lambda message: f"{plain(message.op)}: busy, motors {message.moving:06b} turn",
    }
)
