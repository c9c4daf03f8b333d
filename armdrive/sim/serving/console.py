"""The console of a simulated arm: one-line commands on standard input, and their table.

A fault's name is a command too. Each line gets a reply, of one line but for the tables of `help`
and `faults`; with `--json` anywhere in the line the reply is JSON, on one line.
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
    state_json,
    state_line,
)
from armdrive.sim.faults import (
    FAULT_NOTE,
    FAULTS,
    Cable,
    Faults,
    check_count,
    faults_of,
    motor_of,
    parse_words,
    require_ability,
)
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
    """One row of the table: name, arguments and action; `needs` is an ability of the board."""

    name: str
    arguments: str
    summary: str
    run: Callable[[Console, list[str]], ConsoleAnswer]
    needs: type = object

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
    board: HasPendant = console.board
    board.press_named(words[0])
    return ConsoleAnswer(f"pressed {words[0].upper()}")


def _return(console: Console, _: list[str]) -> ConsoleAnswer:
    board: HasPendant = console.board
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
    console.device.world.take(words[0])
    return ConsoleAnswer(f"removed block {words[0]}")


def _power(console: Console, words: list[str]) -> ConsoleAnswer:
    on = _switch(words[0])
    console.device.set_power(on)
    return ConsoleAnswer(f"power is {'on' if on else 'off'}")


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
    return ConsoleAnswer(f"{request.text}{due}: {FAULTS[request.name].summary}")


def _faults(console: Console, _: list[str]) -> ConsoleAnswer:
    kinds = faults_of(type(console.device.board))
    return _table({kind.usage: kind.summary for kind in kinds}, FAULT_NOTE)


def _table(rows: dict[str, Json], *further: str) -> ConsoleAnswer:
    """Return what can be written and what that does, in columns and as data."""
    width = max(map(len, rows))
    lines = [f"{usage:<{width}}  {summary}" for usage, summary in rows.items()]
    return ConsoleAnswer("\n".join([*lines, *further]), rows)


def _plug(console: Console, words: list[str]) -> ConsoleAnswer:
    """Connect only some drives to the bus, because commissioning handles one at a time."""
    board: DrivesBoard[Any] = console.board
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
    world = console.device.world
    motor, steps = motor_of(world, words[0]), whole(words[1])
    console.device.push([steps if at == motor else 0 for at in range(len(world.motors))])
    return ConsoleAnswer(
        f"pushed motor {motor + 1} by {counted(steps, 'half-step')}, unknown to the registers"
    )


def _help(console: Console, _: list[str]) -> ConsoleAnswer:
    board = console.device.board
    there = [each for each in COMMANDS.values() if isinstance(board, each.needs)]
    return _table({each.usage: each.summary for each in there})


def _quit(console: Console, _: list[str]) -> ConsoleAnswer:
    console.ended = True
    return ConsoleAnswer("ending")


def _switch(word: str) -> bool:
    try:
        return _SWITCH[word.lower()]
    except KeyError:
        raise BadRequest(f"{word!r} is neither on nor off") from None


# Every command by its name. Parsing and help are made from this table.
COMMANDS: Mapping[str, ConsoleCommand] = MappingProxyType(
    {
        command.name: command
        for command in (
            ConsoleCommand("state", "", "the physical state of the arm", _state),
            ConsoleCommand(
                "key", "NAME", "press a key of the pendant, such as STOP", _key, HasPendant
            ),
            ConsoleCommand(
                "return", "", "give control back to the host (ends @SET)", _return, HasPendant
            ),
            ConsoleCommand("guide", "", "bring the arm to its reference posture", _guide),
            ConsoleCommand("put", PARTS, "put a block down (mm)", _put),
            ConsoleCommand("take", "NAME", "remove a block", _take),
            ConsoleCommand(
                "power", "on|off", "switch the controller; off lets the arm sag", _power
            ),
            ConsoleCommand("faults", "", "list the faults that this device can have", _faults),
            ConsoleCommand(
                "fault",
                "[off [NAME] | NAME ...]",
                "end faults, or inject one, as its name alone does; alone: list active faults",
                _fault,
            ),
            ConsoleCommand(
                "plug",
                "all | none | NUMBER ...",
                "connect only these drives to the bus",
                _plug,
                DrivesBoard,
            ),
            ConsoleCommand("input", "NUMBER on|off", "set an input, counted from 1", _input),
            ConsoleCommand(
                "push", "MOTOR STEPS", "turn a motor by force; no register counts it", _push
            ),
            ConsoleCommand("help", "", "list the commands; any line takes --json", _help),
            ConsoleCommand("quit", "", "end the simulation", _quit),
        )
    }
)

JSON_FLAG = "--json"


class Console:
    """Controls a device, its line, and the server that offers it. `ended` is true after `quit`."""

    def __init__(self, device: SimDevice, server: Server, line: DeviceLine) -> None:
        self.device = device
        self.server = server
        self.cable = Cable(line, server.close, server.open)
        self.faults = Faults(device, line, self.cable)
        self.ended = False

    @property
    def board(self) -> Any:
        """The board; it has the ability that the command's row of the table needs."""
        return self.device.board

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
        if name.lower() in FAULTS:
            name, words = "fault", [name, *words]
        command = COMMANDS.get(name.lower())
        if command is None:
            hint = did_you_mean(name, [*COMMANDS, *FAULTS], "try 'help'.")
            raise BadRequest(f"there is no command {name!r}; {hint}")
        require_ability(self.device.board, command.needs)
        check_count(command.usage, words)
        return command.run(self, words)
