"""What MKS drives on a CAN bus and their host say, in sentences; whose they are is said before."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.dialects.words import plain
from firmware_protocol.mks.actions import ArmSynchronous, Enable, GoSynchronous, SetZero
from firmware_protocol.mks.moves import (
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativeAxis,
    MoveRelativePulses,
    RunAtSpeed,
    RunFor,
)
from firmware_protocol.mks.outcomes import Status
from firmware_protocol.mks.readings import EnabledRead, EncoderRead, RawEncoderRead, StateRead


def _pace(message: Any) -> str:
    return f"at {message.speed_rpm} rpm, acc {message.acc}"


def _status(message: Status) -> str:
    about = "" if message.reading is None else f" of {plain(message.reading)}"
    return f"{plain(message.code)}{about}: {plain(message.outcome)}"


SENTENCES: Mapping[type, Callable[[Any], str]] = MappingProxyType(
    {
        Status: _status,
        EncoderRead: lambda message: f"the encoder is at {message.counts}",
        RawEncoderRead: lambda message: f"the encoder's raw count is {message.counts}",
        StateRead: lambda message: f"the motor is: {plain(message.state)}",
        EnabledRead: lambda message: f"the motor is {'on' if message.on else 'off'}",
        Enable: lambda message: f"switch the motor {'on' if message.on else 'off'}",
        ArmSynchronous: lambda message: (
            "keep moves for a common start" if message.on else "start moves at once"
        ),
        GoSynchronous: lambda _: "start the moves that were kept",
        SetZero: lambda _: "count from here",
        MoveAbsoluteAxis: lambda message: f"go to {message.counts} {_pace(message)}",
        MoveRelativeAxis: lambda message: f"go by {message.counts:+d} {_pace(message)}",
        MoveAbsolutePulses: lambda message: f"go to pulse {message.pulses} {_pace(message)}",
        MoveRelativePulses: lambda message: f"go by {message.pulses:+d} pulses {_pace(message)}",
        RunAtSpeed: lambda message: f"turn without end {_pace(message)}",
        RunFor: lambda message: f"turn for {message.duration_ms} ms {_pace(message)}",
    }
)
