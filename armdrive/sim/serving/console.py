"""The console of a simulated arm: one-line commands on standard input, and their table.

Each line gets a one-line reply; with `--json` anywhere in the line the reply is JSON.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from armdrive.errors import ArmError, BadRequest
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import (
    HasPendant,
    SimDevice,
    able,
    state_json,
    state_line,
)
from armdrive.sim.faults import Cable, Faults, check_count, fault_kind, faults_of, parse_words
from armdrive.sim.serving.servers import Server
from armdrive.sim.wire import DeviceLine
from armdrive.sim.world.saved import Json
from armdrive.sim.world.table import PARTS, block_of
from armdrive.text.numbers import whole
from kinematics.errors import did_you_mean
from kinematics.text import counted

# --- A command and its answer --------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ConsoleAnswer:
    """The reply to a command: a sentence for people, and data with at least the same content."""

    text: str
    data: Json = None


@dataclass(frozen=True, slots=True)
class ConsoleCommand:
    """One row of the table: name, arguments and action of a command."""

    name: str
    arguments: str
    summary: str
    run: Callable[[Console, list[str]], ConsoleAnswer]

    @property
    def usage(self) -> str:
        """How the command is written."""
        return f"{self.name} {self.arguments}".strip()


# --- The table: how each command is written, and what it does ------------------------------------

_S_DIGITS = 6
_SWITCH = {"on": True, "off": False, "1": True, "0": False}


def _state(console: Console, _: list[str]) -> ConsoleAnswer:
    # the device's own clock: a late reader still learns when this state was true
    time_s = round(console.device.now_s, _S_DIGITS)
    return ConsoleAnswer(
        state_line(console.device), {"time_s": time_s, **state_json(console.device)}
    )


def _key(console: Console, words: list[str]) -> ConsoleAnswer:
    board: HasPendant = able(console.device.board, HasPendant, "pendant")
    board.press_named(words[0])
    return ConsoleAnswer(f"pressed {words[0].upper()}")


def _return(console: Console, _: list[str]) -> ConsoleAnswer:
    board: HasPendant = able(console.device.board, HasPendant, "pendant that takes control")
    if board.return_control():
        return ConsoleAnswer("the host has control again")
    raise BadRequest("the pendant has no control to give back: the host has not sent @SET")


def _guide(console: Console, _: list[str]) -> ConsoleAnswer:
    reference = console.device.world.body.reference
    if reference is None:
        raise BadRequest("no reference posture is known of this arm")
    joints = console.device.world.body.arm.ik(reference.pose)
    console.device.bring_to(joints, reference.opening_mm)
    return ConsoleAnswer("a person brought the arm to its reference posture by hand")


def _put(console: Console, words: list[str]) -> ConsoleAnswer:
    block = console.device.world.put(block_of(words))
    return ConsoleAnswer(f"block {block.name} stands at {block.place_words}")


def _take(console: Console, words: list[str]) -> ConsoleAnswer:
    if console.device.world.take(words[0]) is None:
        there = ", ".join(console.device.world.scene.blocks) or "none"
        raise BadRequest(f"there is no block {words[0]!r}; there are: {there}")
    return ConsoleAnswer(f"removed block {words[0]}")


def _power(console: Console, words: list[str]) -> ConsoleAnswer:
    on = _switch(words[0])
    console.device.set_power(on)
    return ConsoleAnswer(f"power is {'on' if on else 'off'}")


def _unplug(console: Console, _: list[str]) -> ConsoleAnswer:
    console.cable.unplug()
    return ConsoleAnswer("unplugged")


def _replug(console: Console, words: list[str]) -> ConsoleAnswer:
    names = [word for word in words if word != "as"]
    console.cable.replug(*names[:1])
    return ConsoleAnswer(f"plugged in at {console.server.address}")


def _fault(console: Console, words: list[str]) -> ConsoleAnswer:
    if not words:
        active = console.faults.active
        return ConsoleAnswer("; ".join(active) or "no faults", {"faults": list(active)})
    if words[0].lower() == "off":
        ended = console.faults.end(*words[1:2])
        return ConsoleAnswer(f"ended: {'; '.join(ended) or 'nothing'}", {"ended": list(ended)})
    request = parse_words(words)
    console.faults.ask(request)
    due = f" in {request.after_s:g} s" if request.after_s else ""
    return ConsoleAnswer(f"fault{due}: {fault_kind(request.name).summary}")


def _faults(console: Console, _: list[str]) -> ConsoleAnswer:
    kinds = faults_of(type(console.device.board))
    table: dict[str, Json] = {kind.usage: kind.summary for kind in kinds}
    return ConsoleAnswer("; ".join(table), table)


def _plug(console: Console, words: list[str]) -> ConsoleAnswer:
    """Connect only some drives to the bus, because commissioning handles one at a time."""
    board: DrivesBoard[Any] = able(console.device.board, DrivesBoard, "drives on a bus")
    names = [motor.name for motor in board.world.body.transmission.motors]
    numbers = {"all": [*range(1, len(names) + 1)], "none": []}.get(words[0].lower())
    if numbers is None:
        numbers = [whole(word) for word in words]
    if any(not 1 <= each <= len(names) for each in numbers):
        raise BadRequest(f"drives are numbered 1 to {len(names)}, not {' '.join(words)}")
    for number_of, _ in enumerate(names, 1):
        board.node(number_of - 1).port.plugged = number_of in numbers
    there = ", ".join(names[each - 1] for each in sorted({*numbers})) or "none"
    return ConsoleAnswer(f"on the bus: {there}")


def _input(console: Console, words: list[str]) -> ConsoleAnswer:
    number, on = whole(words[0]), _switch(words[1])
    console.device.set_input(number - 1, on)
    return ConsoleAnswer(f"input {number} is {'on' if on else 'off'}")


def _push(console: Console, words: list[str]) -> ConsoleAnswer:
    motor, steps = whole(words[0]), whole(words[1])
    count = len(console.device.world.motors)
    if not 1 <= motor <= count:
        raise BadRequest(f"motors are numbered 1 to {count}, not {motor}")
    console.device.push([steps if index == motor else 0 for index in range(1, count + 1)])
    return ConsoleAnswer(
        f"pushed motor {motor} by {counted(steps, 'half-step')}, unknown to the registers"
    )


def _help(_: Console, __: list[str]) -> ConsoleAnswer:
    usages = [command.usage for command in COMMANDS.values()]
    helps: dict[str, Json] = {each.usage: each.summary for each in COMMANDS.values()}
    return ConsoleAnswer("; ".join(usages), helps)


def _quit(console: Console, _: list[str]) -> ConsoleAnswer:
    console.ended = True
    return ConsoleAnswer("ending")


def _switch(word: str) -> bool:
    try:
        return _SWITCH[word.lower()]
    except KeyError:
        raise BadRequest(f"{word!r} is neither on nor off") from None


COMMANDS: Mapping[str, ConsoleCommand] = MappingProxyType(
    {
        command.name: command
        for command in (
            ConsoleCommand("state", "", "the physical state of the arm", _state),
            ConsoleCommand("key", "NAME", "press a key of the pendant, such as STOP", _key),
            ConsoleCommand("return", "", "give control back to the host (ends @SET)", _return),
            ConsoleCommand("guide", "", "bring the arm to its reference posture", _guide),
            ConsoleCommand("put", PARTS, "put a block down (mm)", _put),
            ConsoleCommand("take", "NAME", "remove a block", _take),
            ConsoleCommand(
                "power", "on|off", "switch the controller; off lets the arm sag", _power
            ),
            ConsoleCommand("unplug", "", "pull the cable", _unplug),
            ConsoleCommand(
                "replug", "[as NAME]", "plug the cable in again, perhaps as another port", _replug
            ),
            ConsoleCommand(
                "fault",
                "[off [NAME] | NAME ARGUMENTS [--from host|device] [--seed N] [--for S] [@S]]",
                "inject a fault, or end it; alone: list active faults",
                _fault,
            ),
            ConsoleCommand("faults", "", "list the faults that this device can have", _faults),
            ConsoleCommand(
                "plug", "all | none | NUMBER ...", "connect only these drives to the bus", _plug
            ),
            ConsoleCommand("input", "NUMBER on|off", "set an input, counted from 1", _input),
            ConsoleCommand(
                "push", "MOTOR STEPS", "turn a motor by force; no register counts it", _push
            ),
            ConsoleCommand("help", "", "list the commands (with --json: what they do)", _help),
            ConsoleCommand("quit", "", "end the simulation", _quit),
        )
    }
)
"""Every command by its name. Parsing and help are made from this table."""

JSON_FLAG = "--json"


class Console:
    """Controls a device, its line, and the server that offers it. `ended` is true after `quit`."""

    def __init__(self, device: SimDevice, server: Server, line: DeviceLine) -> None:
        self.device = device
        self.server = server
        self.cable = Cable(line, server.close, server.open)
        self.faults = Faults(device, line, self.cable)
        self.ended = False

    def answer(self, line: str) -> str:
        """Execute a line and return the reply; an empty line has no reply."""
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

    def _run(self, name: str, words: list[str]) -> ConsoleAnswer:
        command = COMMANDS.get(name.lower())
        if command is None:
            hint = did_you_mean(name.lower(), COMMANDS, "try 'help'.", likeness=0.4)
            raise BadRequest(f"there is no command {name!r}; {hint}")
        check_count(command.usage, words)
        return command.run(self, words)
