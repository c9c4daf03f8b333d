"""What a simulated MKS drive answers to reads, and says by itself where it was told to."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.sim.mks_node import Node
from firmware_protocol.mks import (
    ANGLE_ERROR_PER_TURN,
    COUNTS_PER_TURN,
    Ability,
    AngleErrorRead,
    Asked,
    Code,
    EnabledRead,
    EncoderRead,
    HomingRead,
    HomingState,
    InputsRead,
    MotorState,
    PulsesRead,
    RawEncoderRead,
    Reading,
    ReadSetting,
    SettingRead,
    SpeedRead,
    StallRead,
    StateRead,
    VersionRead,
)

BOARD = 2
"""A SERVO42D on CAN."""


def answer(node: Node, asked: Asked, now_s: float) -> None:
    """Answer a read."""
    request = asked.request
    if isinstance(request, ReadSetting):
        setting = node.flash.get(request.setting)
        value = None if setting is None else setting.payload
        node.say(node.device.answer(asked, SettingRead(request.setting, value)))
    else:
        node.say(node.device.answer(asked, reading(node, request.code, now_s)))


def report(node: Node, now_s: float) -> None:
    """Say by itself what is due."""
    for code, (period_s, due_s) in node.reports.items():
        if due_s <= now_s:
            node.reports[code] = (period_s, due_s + period_s)
            node.say(node.device.report(reading(node, code, now_s)))


def reading(node: Node, code: Code, now_s: float) -> Reading:
    """Return what a drive reads of itself."""
    return _READINGS[code](node, now_s)


def state(node: Node, now_s: float) -> MotorState:
    """Return what the drive says that its motor does."""
    if not node.searching:
        return node.point.state(now_s)
    calibrates = node.under_way is not None and node.under_way.request.code is Code.CALIBRATE
    return MotorState.CALIBRATING if calibrates else MotorState.HOMING


def _error(node: Node, now_s: float) -> int:
    return node.point.at(now_s) - node.shaft


def _speed(node: Node, now_s: float) -> SpeedRead:
    stands = abs(_error(node, now_s)) >= node.habits.stall_counts
    return SpeedRead(0 if stands else round(node.point.rpm(now_s)))


def _pulses(node: Node, now_s: float) -> PulsesRead:
    return PulsesRead(round((node.point.at(now_s) - node.zero) / node.counts_per_pulse))


def _angle_error(node: Node, now_s: float) -> AngleErrorRead:
    return AngleErrorRead(round(_error(node, now_s) * ANGLE_ERROR_PER_TURN / COUNTS_PER_TURN))


def _homing(node: Node, _: float) -> HomingRead:
    """Return how homing stands: one that has never been asked for has failed."""
    if Ability.HOMING_BY_COMMAND_READ not in node.device.abilities:
        return HomingRead(HomingState.FAILED)
    found = HomingState.FAILED if node.homing is None else node.homing
    return HomingRead(HomingState.FAILED, found)


def _version(node: Node, _: float) -> VersionRead:
    return VersionRead(node.calibrated, BOARD, bytes(node.firmware)[-node.habits.version_bytes :])


_READINGS: Mapping[Code, Callable[[Node, float], Reading]] = MappingProxyType(
    {
        Code.ENCODER: lambda node, _: EncoderRead(node.counts),
        Code.RAW_ENCODER: lambda node, _: RawEncoderRead(node.shaft - node.power_on_zero),
        Code.SPEED: _speed,
        Code.PULSES: _pulses,
        Code.ANGLE_ERROR: _angle_error,
        Code.INPUTS: lambda node, _: InputsRead(int(node.switch.pressed)),
        Code.ENABLED: lambda node, _: EnabledRead(node.enabled),
        Code.STALL: lambda node, _: StallRead(node.stalled),
        Code.STATE: lambda node, now_s: StateRead(state(node, now_s)),
        Code.HOMING_STATE: _homing,
        Code.VERSION: _version,
    }
)
