"""The table of the console's commands: how each is written, and what it does."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.sim.console_command import Answer, ConsoleCommand
from armdrive.sim.device import GivesControl, HasPendant, HasSpeedError, lacks
from armdrive.sim.drives import DrivesOnBus
from armdrive.sim.dropping import PARTS, block_of
from armdrive.sim.fault_request import number, parse_words, whole
from armdrive.sim.faults_table import fault_kind, faults_of
from armdrive.sim.report import state_json, state_line
from armdrive.sim.saved import Json

if TYPE_CHECKING:
    from armdrive.sim.console import Console

_S_DIGITS = 6
_SWITCH = {"on": True, "off": False, "1": True, "0": False}


def _state(console: Console, _: list[str]) -> Answer:
    # the device's own clock: whoever looks on late still learns when what is seen was so
    time_s = round(console.device.now_s, _S_DIGITS)
    return Answer(state_line(console.device), {"time_s": time_s, **state_json(console.device)})


def _key(console: Console, words: list[str]) -> Answer:
    device = console.device
    if not isinstance(device, HasPendant):
        raise lacks(device, "pendant")
    device.press_named(words[0])
    return Answer(f"pressed {words[0].upper()}")


def _return(console: Console, _: list[str]) -> Answer:
    device = console.device
    if not isinstance(device, GivesControl):
        raise lacks(device, "pendant that takes control")
    if device.pendant_returns():
        return Answer("the host has control again")
    raise BadRequest("the pendant has no control to give back: the host has not sent @SET")


def _guide(console: Console, _: list[str]) -> Answer:
    reference = console.device.world.body.reference
    if reference is None:
        raise BadRequest("no reference posture is known of this arm")
    joints = console.device.world.body.arm.ik(reference.pose)
    console.device.bring_to(joints, reference.opening_mm)
    return Answer("somebody brought the arm to its reference posture by hand")


def _put(console: Console, words: list[str]) -> Answer:
    block = console.device.world.put(block_of(words))
    place = f"x {block.x_mm:.1f}, y {block.y_mm:.1f}, z {block.z_mm:.1f} mm"
    return Answer(f"block {block.name} stands at {place}")


def _take(console: Console, words: list[str]) -> Answer:
    if console.device.world.take(words[0]) is None:
        there = ", ".join(console.device.world.scene.blocks) or "none"
        raise BadRequest(f"there is no block {words[0]!r}; there are: {there}")
    return Answer(f"took block {words[0]} away")


def _power(console: Console, words: list[str]) -> Answer:
    on = _switch(words[0])
    if on != console.device.powered:
        (console.device.power_on if on else console.device.power_off)()
    return Answer(f"power is {'on' if on else 'off'}")


def _unplug(console: Console, _: list[str]) -> Answer:
    console.cable.unplug()
    return Answer("unplugged")


def _replug(console: Console, words: list[str]) -> Answer:
    names = [word for word in words if word != "as"]
    console.cable.replug(*names[:1])
    return Answer(f"plugged in at {console.server.address}")


def _fault(console: Console, words: list[str]) -> Answer:
    if not words:
        active = console.faults.active
        return Answer("; ".join(active) or "nothing is wrong", {"faults": list(active)})
    if words[0].lower() == "off":
        ended = console.faults.end(*words[1:2])
        return Answer(f"ended: {'; '.join(ended) or 'nothing'}", {"ended": list(ended)})
    request = parse_words(words)
    console.faults.ask(request)
    due = f" in {request.after_s:g} s" if request.after_s else ""
    return Answer(f"fault{due}: {fault_kind(request.name).summary}")


def _faults(console: Console, _: list[str]) -> Answer:
    kinds = faults_of(type(console.device))
    table: dict[str, Json] = {kind.usage: kind.summary for kind in kinds}
    return Answer("; ".join(table), table)


def _plug(console: Console, words: list[str]) -> Answer:
    """Have some drives alone be on the bus: commissioning meets one at a time."""
    device = console.device
    if not isinstance(device, DrivesOnBus):
        raise lacks(device, "drives on a bus")
    names = [motor.name for motor in device.world.body.transmission.motors]
    numbers = {"all": [*range(1, len(names) + 1)], "none": []}.get(words[0].lower())
    if numbers is None:
        numbers = [whole(word) for word in words]
    if any(not 1 <= each <= len(names) for each in numbers):
        raise BadRequest(f"drives are numbered 1 to {len(names)}, not {' '.join(words)}")
    for number_of, _ in enumerate(names, 1):
        device.plug_drive(number_of - 1, number_of in numbers)
    there = ", ".join(names[each - 1] for each in sorted({*numbers})) or "none"
    return Answer(f"on the bus: {there}")


def _input(console: Console, words: list[str]) -> Answer:
    bit, on = whole(words[0]), _switch(words[1])
    console.device.set_input(bit, on)
    return Answer(f"input {bit} is {'on' if on else 'off'}")


def _push(console: Console, words: list[str]) -> Answer:
    motor, steps = whole(words[0]), whole(words[1])
    count = len(console.device.world.motors)
    if not 1 <= motor <= count:
        raise BadRequest(f"motors are numbered 1 to {count}, not {motor}")
    console.device.push([steps if index == motor else 0 for index in range(1, count + 1)])
    return Answer(f"pushed motor {motor} by {steps} half-steps, unknown to the registers")


def _speed_error(console: Console, words: list[str]) -> Answer:
    device = console.device
    if not isinstance(device, HasSpeedError):
        raise lacks(device, "speed error: it keeps its own time")
    device.set_speed_error(number(words[0]))
    return Answer(f"motions last {1.0 + device.speed_error:.2f} times as long")


def _help(_: Console, __: list[str]) -> Answer:
    usages = [command.usage for command in COMMANDS.values()]
    helps: dict[str, Json] = {each.usage: each.summary for each in COMMANDS.values()}
    return Answer("; ".join(usages), helps)


def _quit(console: Console, _: list[str]) -> Answer:
    console.ended = True
    return Answer("ends")


def _switch(word: str) -> bool:
    try:
        return _SWITCH[word.lower()]
    except KeyError:
        raise BadRequest(f"{word!r} is neither on nor off") from None


COMMANDS: Mapping[str, ConsoleCommand] = MappingProxyType(
    {
        command.name: command
        for command in (
            ConsoleCommand("state", "", "the arm as it stands, physically", _state, (0, 0)),
            ConsoleCommand("key", "NAME", "press a key of the pendant, STOP say", _key, (1, 1)),
            ConsoleCommand("return", "", "the pendant gives control back (@SET)", _return, (0, 0)),
            ConsoleCommand("guide", "", "bring the arm to its reference posture", _guide, (0, 0)),
            ConsoleCommand("put", PARTS, "set a block down, mm", _put, (3, 5)),
            ConsoleCommand("take", "NAME", "take a block away", _take, (1, 1)),
            ConsoleCommand(
                "power", "on|off", "switch the controller; off lets it sag", _power, (1, 1)
            ),
            ConsoleCommand("unplug", "", "pull the cable", _unplug, (0, 0)),
            ConsoleCommand("replug", "[as NAME]", "put the cable back", _replug, (0, 2)),
            ConsoleCommand(
                "fault",
                "[off [NAME] | NAME ARGUMENTS [--from host|device] [--seed N] [--for S] [@S]]",
                "have something go wrong, or end it; alone: what is wrong",
                _fault,
                (0, 12),
            ),
            ConsoleCommand("faults", "", "what can go wrong with this device", _faults, (0, 0)),
            ConsoleCommand(
                "plug",
                "all | none | NUMBER ...",
                "have these drives on the bus",
                _plug,
                (1, 6),
            ),
            ConsoleCommand("input", "BIT 0|1", "set an input bit", _input, (2, 2)),
            ConsoleCommand(
                "push", "MOTOR STEPS", "turn a motor by force, uncounted", _push, (2, 2)
            ),
            ConsoleCommand(
                "speed-error", "FRACTION", "0.2 is a fifth slower", _speed_error, (1, 1)
            ),
            ConsoleCommand("help", "", "these commands (with --json: what they do)", _help, (0, 0)),
            ConsoleCommand("quit", "", "end the simulation", _quit, (0, 0)),
        )
    }
)
"""Every command by its name; parsing and help are made from it."""
