"""The one-line commands that steer a simulated arm from its standard input: one table of them.

Each line gets one line in answer; `--json` anywhere in it makes that answer JSON.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.errors import ArmError, BadRequest
from armdrive.sim.blocks import Block
from armdrive.sim.device import GivesControl, HasPendant, HasSpeedError, SimDevice, lacks
from armdrive.sim.report import state_json, state_line
from armdrive.sim.saved import Json
from armdrive.transports.serve import Server

JSON_FLAG = "--json"
DROP_FROM_MM = 1000.0
"""A block comes down from above everything, onto what is there."""
_SWITCH = {"on": True, "off": False, "1": True, "0": False}


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command has to say: a sentence for people, or the same and more as data."""

    text: str
    data: Json = None


@dataclass(frozen=True, slots=True)
class ConsoleCommand:
    """One row of the table: how it is called, what follows, what it does."""

    name: str
    arguments: str
    summary: str
    run: Callable[[Console, list[str]], Answer]
    counts: tuple[int, int]
    """The least and the most words that may follow."""

    @property
    def usage(self) -> str:
        """How it is written."""
        return f"{self.name} {self.arguments}".strip()


class Console:
    """Steers one device, and the server that offers it. `ended` is true after `quit`."""

    def __init__(self, device: SimDevice, server: Server) -> None:
        self.device = device
        self.server = server
        self.ended = False

    def answer(self, line: str) -> str:
        """Do what a line says and return the line that answers it; nothing for an empty one."""
        words = line.split()
        as_json = JSON_FLAG in words
        words = [word for word in words if word != JSON_FLAG]
        if not words:
            return ""
        try:
            answer = self._run(words[0], words[1:])
        except ArmError as error:
            return json.dumps({"ok": False, "error": str(error)}) if as_json else str(error)
        if not as_json:
            return answer.text
        return json.dumps({"ok": True, "text": answer.text} if answer.data is None else answer.data)

    def _run(self, name: str, words: list[str]) -> Answer:
        command = COMMANDS.get(name.lower())
        if command is None:
            near = difflib.get_close_matches(name.lower(), COMMANDS, n=1, cutoff=0.4)
            hint = f"did you mean {near[0]!r}?" if near else "try 'help'."
            raise BadRequest(f"there is no command {name!r}; {hint}")
        least, most = command.counts
        if not least <= len(words) <= most:
            raise BadRequest(f"write it like this: {command.usage}")
        return command.run(self, words)


def _state(console: Console, _: list[str]) -> Answer:
    return Answer(state_line(console.device), state_json(console.device))


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
    numbers = [_number(word) for word in words[1:]]
    x, y, *sizes = numbers
    width = sizes[0] if sizes else 25.0
    height = sizes[1] if len(sizes) > 1 else width
    block = console.device.world.put(Block(words[0], x, y, DROP_FROM_MM, width, height))
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
    console.server.close()
    return Answer("unplugged")


def _replug(console: Console, _: list[str]) -> Answer:
    console.server.open()
    return Answer(f"plugged in at {console.server.address}")


def _input(console: Console, words: list[str]) -> Answer:
    bit, on = _whole(words[0]), _switch(words[1])
    console.device.set_input(bit, on)
    return Answer(f"input {bit} is {'on' if on else 'off'}")


def _push(console: Console, words: list[str]) -> Answer:
    motor, steps = _whole(words[0]), _whole(words[1])
    count = len(console.device.world.motors)
    if not 1 <= motor <= count:
        raise BadRequest(f"motors are numbered 1 to {count}, not {motor}")
    console.device.push([steps if index == motor else 0 for index in range(1, count + 1)])
    return Answer(f"pushed motor {motor} by {steps} half-steps, unknown to the registers")


def _speed_error(console: Console, words: list[str]) -> Answer:
    device = console.device
    if not isinstance(device, HasSpeedError):
        raise lacks(device, "speed error: it keeps its own time")
    device.set_speed_error(_number(words[0]))
    return Answer(f"motions last {1.0 + device.speed_error:.2f} times as long")


def _help(_: Console, __: list[str]) -> Answer:
    usages = [command.usage for command in COMMANDS.values()]
    helps: dict[str, Json] = {each.usage: each.summary for each in COMMANDS.values()}
    return Answer("; ".join(usages), helps)


def _quit(console: Console, _: list[str]) -> Answer:
    console.ended = True
    return Answer("ends")


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise BadRequest(f"{word!r} is no number") from None


def _whole(word: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise BadRequest(f"{word!r} is no whole number") from None


def _switch(word: str) -> bool:
    try:
        return _SWITCH[word.lower()]
    except KeyError:
        raise BadRequest(f"{word!r} is neither on nor off") from None


COMMANDS: dict[str, ConsoleCommand] = {
    command.name: command
    for command in (
        ConsoleCommand("state", "", "the arm as it stands, physically", _state, (0, 0)),
        ConsoleCommand("key", "NAME", "press a key of the pendant, STOP say", _key, (1, 1)),
        ConsoleCommand("return", "", "the pendant gives control back (@SET)", _return, (0, 0)),
        ConsoleCommand("guide", "", "bring the arm to its reference posture", _guide, (0, 0)),
        ConsoleCommand("put", "NAME X Y [WIDTH [HEIGHT]]", "set a block down, mm", _put, (3, 5)),
        ConsoleCommand("take", "NAME", "take a block away", _take, (1, 1)),
        ConsoleCommand("power", "on|off", "switch the controller; off lets it sag", _power, (1, 1)),
        ConsoleCommand("unplug", "", "pull the cable", _unplug, (0, 0)),
        ConsoleCommand("replug", "", "put the cable back", _replug, (0, 0)),
        ConsoleCommand("input", "BIT 0|1", "set an input bit", _input, (2, 2)),
        ConsoleCommand("push", "MOTOR STEPS", "turn a motor by force, uncounted", _push, (2, 2)),
        ConsoleCommand("speed-error", "FRACTION", "0.2 is a fifth slower", _speed_error, (1, 1)),
        ConsoleCommand("help", "", "these commands (with --json: what they do)", _help, (0, 0)),
        ConsoleCommand("quit", "", "end the simulation", _quit, (0, 0)),
    )
}
"""Every command by its name; parsing and help are made from it."""


def help_text() -> str:
    """Return the table for people, one command a line."""
    width = max(len(command.usage) for command in COMMANDS.values())
    return "\n".join(
        f"{command.usage:<{width}}  {command.summary}" for command in COMMANDS.values()
    )
