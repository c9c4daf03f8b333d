"""Programs that coordinate nothing: each drive of a bus is sent to its target at one speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from can_strategies import Strategy
from feel_benches import DenseMemoryBench

from firmware_protocol.canopen import (
    PROFILE_ACCELERATION,
    PROFILE_DECELERATION,
    PROFILE_SPEED,
    Command,
    ControlBit,
    Controlword,
    DataType,
    OperationMode,
)
from firmware_protocol.canopen import Host as CanopenHost
from firmware_protocol.mks import COUNTS_S_PER_RPM, Host, MoveAbsoluteAxis
from kinematics import Motors

ACC = 252
RAMP_S = 0.15
"""From rest to full speed."""
MODE = OperationMode.PROFILE_POSITION
BETWEEN_S = 0.02
"""Between two things that are said to a CiA 402 drive, each of which it has to have taken."""

Send = Callable[[DenseMemoryBench, Motors, float], None]
"""Turns motors by counts at a share of full speed."""


@dataclass(frozen=True, slots=True)
class Plain(Strategy):
    """A program of one dialect."""

    send: Send = lambda *_: None


def send_mks(bench: DenseMemoryBench, ways: Motors, speed: float) -> None:
    """Send MKS drives, one after the other (`F5`)."""
    arm, device = bench.arm, bench.stage.twin.device
    assert arm is not None
    host = Host(range(1, 7))
    rpm = max(int(arm.parts.speeds.motor_hz / COUNTS_S_PER_RPM * speed), 1)
    for node, (way, counted) in enumerate(zip(ways, device.registers, strict=True), 1):
        order = MoveAbsoluteAxis(counted + way, rpm, ACC)
        bench.stage.twin.link.write(host.send(node, order), arm.parts.pace.now_s())


def send_cia402(bench: DenseMemoryBench, ways: Motors, speed: float) -> None:
    """Send CiA 402 drives by profile position, all with the same speed and ramp."""
    arm, device = bench.arm, bench.stage.twin.device
    assert arm is not None
    bus = CanopenHost(range(1, 7))
    hz = arm.parts.speeds.motor_hz
    profile = {
        PROFILE_SPEED: max(round(hz * speed), 1),
        PROFILE_ACCELERATION: round(hz / RAMP_S),
        PROFILE_DECELERATION: round(hz / RAMP_S),
    }
    for place, value in profile.items():
        data = DataType.U32.pack(value)
        _say(bench, b"".join(bus.download(node, place, data) for node in range(1, 7)))
        for node in range(1, 7):
            bus.abandon(node)
    targets = [counted + way for way, counted in zip(ways, device.registers, strict=True)]
    enable = Controlword.of(Command.ENABLE_OPERATION)
    at_once = ControlBit.NEW_SET_POINT | ControlBit.AT_ONCE
    for bits in (0, at_once):
        word = Controlword(enable.value | bits)
        orders = (bus.command(n, word, MODE, at) for n, at in enumerate(targets, 1))
        _say(bench, b"".join(orders) + bus.sync())


def _say(bench: DenseMemoryBench, data: bytes) -> None:
    assert bench.arm is not None
    bench.stage.twin.link.write(data, bench.arm.parts.pace.now_s())
    bench.sleep(BETWEEN_S)


PLAIN: Mapping[str, Plain] = MappingProxyType(
    {
        "plain": Plain("mks", send=send_mks),
        "plain CiA": Plain("cia402", send=send_cia402),
    }
)
