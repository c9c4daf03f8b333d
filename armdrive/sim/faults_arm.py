"""The faults of the controller and of the arm: power, resets, motors, limit switches."""

from __future__ import annotations

from armdrive.errors import BadRequest
from armdrive.sim.device import HasSwitches, Resettable, SwitchState, lacks
from armdrive.sim.fault_kind import Begin, Bench, Running
from armdrive.sim.fault_request import FaultRequest, whole

BROWN_OUT_S = 0.5


def brown_out(bench: Bench, _: FaultRequest) -> Begin:
    """Have the power fail, and come back."""

    def end() -> None:
        if not bench.device.powered:
            bench.device.power_on()

    def begin() -> Running:
        if bench.device.powered:
            bench.device.power_off()
        return Running(end)

    return begin


def reset(bench: Bench, _: FaultRequest) -> Begin:
    """Have the board reset, its power on."""
    device = bench.device
    if not isinstance(device, Resettable):
        raise lacks(device, "reset apart from its power")
    return device.reset


def lose_steps(bench: Bench, request: FaultRequest) -> Begin:
    """Have a motor lose steps."""
    motor, count = motor_of(bench, request.words[0]), whole(request.words[1])
    if count < 1:
        raise BadRequest(f"1 step or more can be lost, not {count}")
    return lambda: bench.device.world.lose(motor, count)


def stall(bench: Bench, request: FaultRequest) -> Begin:
    """Have a motor no longer follow."""
    motor, stalled = motor_of(bench, request.words[0]), bench.device.world.stalled

    def begin() -> Running:
        stalled.add(motor)
        return Running(lambda: stalled.discard(motor), lambda: motor in stalled)

    return begin


def switch(bench: Bench, request: FaultRequest) -> Begin:
    """Have a limit switch stick, or free it."""
    device = bench.device
    if not isinstance(device, HasSwitches):
        raise lacks(device, "limit switches")
    axis, state = motor_of(bench, request.words[0]), request.words[1].lower()
    states = {each.value: each for each in SwitchState}
    if state not in states:
        raise BadRequest(f"a switch is {', '.join(states)}, not {request.words[1]!r}")

    def begin() -> Running | None:
        device.set_switch(axis, states[state])
        if states[state] is SwitchState.FREE:
            return None
        return Running(lambda: device.set_switch(axis, SwitchState.FREE))

    return begin


def motor_of(bench: Bench, word: str) -> int:
    """Return a motor's index, given as its number from 1 or as its name."""
    names = [motor.name for motor in bench.device.world.body.transmission.motors]
    if word in names:
        return names.index(word)
    if word.isascii() and word.isdecimal() and 1 <= int(word) <= len(names):
        return int(word) - 1
    raise BadRequest(f"motors are 1 to {len(names)} or {', '.join(names)}, not {word!r}")
