"""The faults of simulated arms: their requests, what each does, their table, and those at work.

A `FaultRequest` comes from the command line, from the console or from `Faults.add`. `Faults.ask`
finds its row in `FAULTS` and reads its words as the row says: so wrong words are refused at once,
also of a fault that begins later. At its time the row's function makes the fault happen; one that
lasts is a generator, which also ends it. Faults of the wire put rules into the directions of the
line (wire.py); the others change the board, the world or the cable.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Any, TypeAlias, cast

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.arguments import BASIC, checked_calls, known_attributes, made_of
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.bus.line import BusLine
from armdrive.sim.device import (
    Board,
    HasPendant,
    HasSwitches,
    Resettable,
    SaysEmergencies,
    SimDevice,
)
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.sim.wire import (
    Amount,
    DeviceLine,
    MemoryLink,
    Rule,
    WireDirection,
    changed,
    lost,
    repeated,
)
from armdrive.sim.world import World
from armdrive.text.numbers import number, whole
from kinematics.errors import did_you_mean

# --- A requested fault, from a command line, the console or a program ----------------------------
# On a command line: `NAME[:ARGUMENT,..][@SECONDS]`; at the console, the same words with spaces.
# Named arguments are written `from=host` in both.

SIDES = ("host", "device", "both")
_NAMED = ("from", "seed", "for")


@dataclass(frozen=True, slots=True)
class FaultRequest:
    """A requested fault: `side` is the sender affected; times are in seconds from now.

    `for_s` is its duration, None for until it is ended. Raises `BadRequest`.
    """

    name: str
    words: tuple[str, ...] = ()
    side: str = "both"
    seed: int = 0
    after_s: float = 0.0
    for_s: float | None = None

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise BadRequest(f"bytes come from {', '.join(SIDES)}, not from {self.side!r}")
        for seconds in (self.after_s, self.for_s or 0.0):
            if not 0.0 <= seconds < math.inf:
                raise BadRequest(f"a time must be 0 or more seconds, not {seconds}")

    @property
    def text(self) -> str:
        """The fault and its arguments, as they are written at the console."""
        return " ".join((self.name, *self.words))


def parse_option(text: str) -> FaultRequest:
    """Parse the value of `--fault`."""
    head, at, seconds = text.rpartition("@")
    if not at:
        head = text
    name, _, arguments = head.partition(":")
    words = [word for word in arguments.split(",") if word]
    return parse_words([name, *words, *([f"@{seconds}"] if at else [])])


def parse_words(words: Sequence[str]) -> FaultRequest:
    """Parse the words of a console command."""
    after_s, named, plain = 0.0, {}, []
    for word in words:
        name, _, value = word.partition("=")
        if word.startswith("@"):
            after_s = number(word[1:])
        elif name in _NAMED:
            named[name] = value
        else:
            plain.append(word)
    if not plain:
        raise BadRequest("name a fault")
    return FaultRequest(
        plain[0].lower(),
        tuple(plain[1:]),
        side=named.get("from", "both"),
        seed=whole(named.get("seed", "0")),
        after_s=after_s,
        for_s=number(named["for"]) if "for" in named else None,
    )


class Cable:
    """The cable between a device and the program that opens its wire; it can be pulled at any time.

    `withdraw` disconnects the program that has opened the wire. `offer` reconnects it, possibly
    under another name, and may raise `PortUnavailable`.
    """

    def __init__(
        self,
        line: DeviceLine,
        withdraw: Callable[[], None],
        offer: Callable[[str | None], None],
    ) -> None:
        self._line = line
        self._withdraw = withdraw
        self._offer = offer
        self.plugged = True

    def unplug(self) -> None:
        """Pull the cable; bytes under way are lost."""
        self.plugged = False
        self._withdraw()
        self._line.unplug()

    def replug(self, name: str | None = None) -> None:
        """Plug the cable in again, possibly under another name."""
        self._offer(name)
        self._line.plug()
        self.plugged = True


# A fault that lasts is a generator: it begins, yields a function that says whether it still has an
# effect, and ends what it began when it is resumed.
Lasting: TypeAlias = Iterator[Callable[[], bool]]
# Makes a fault happen, by the `Faults` of a device, the request and its arguments; returns None if
# it is over at once.
BeginFault: TypeAlias = Callable[..., Lasting | None]


def until_ended() -> bool:
    """Say that a fault has an effect until it is ended."""
    return True


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One row; `needs` is the ability required of the board, `lasts_s` the usual duration.

    The words of `arguments` are keys of `ARGUMENTS`; those in brackets may be missing.
    """

    name: str
    arguments: str
    summary: str
    begin: BeginFault
    needs: type = object
    lasts_s: float | None = None

    @property
    def usage(self) -> str:
        """How the fault is written."""
        return f"{self.name} {self.arguments}".strip()

    @property
    def of_motor(self) -> bool:
        """Whether the fault is of one motor.

        It ends an earlier one of its kind on that motor, so that its own end restores the state
        before both.
        """
        return self.arguments.startswith("MOTOR")

    def befalls(self, board: type[Board]) -> bool:
        """Return whether a device with this kind of board can have the fault."""
        return issubclass(board, self.needs)


def check_count(usage: str, words: Sequence[str]) -> None:
    """Raise `BadRequest` if a command or fault has too many or too few words.

    The usage text decides: words in brackets are optional, and "..." stands for any number.
    """
    arguments = usage.split()[1:]
    optional = [at for at, word in enumerate(arguments) if word.startswith("[")]
    least, most = min([*optional, len(arguments)]), float(len(arguments))
    if "..." in usage:
        least, most = min(least, 1), math.inf
    if not least <= len(words) <= most:
        raise BadRequest(f"write it like this: {usage}")


_ABILITIES: Mapping[type, str] = MappingProxyType(
    {
        HasPendant: "pendant",
        Resettable: "reset apart from its power",
        HasSwitches: "limit switches",
        DrivesBoard: "drives on a bus",
        SaysEmergencies: "error codes of its own",
    }
)


def require_ability(board: Board, ability: type) -> None:
    """Raise `BadRequest` if a board lacks what a fault or a console command needs."""
    if not isinstance(board, ability):
        raise BadRequest(f"the simulated {board.title} has no {_ABILITIES[ability]}")


# --- The arguments of faults ---------------------------------------------------------------------

NOISE_BYTES, NOISE_MOST = 8, 4096  # the usual and the greatest number of bytes
# The lowest error code of an EMCY message; lower codes mean that no error is left.
FIRST_ERROR = 0x100
_CODE = re.compile(r"[0-9A-Fa-f]{4}")
# How much: each byte with a probability, the n-th byte from now, or all of the next message.
#
# On a bus frames take the place of bytes.
AMOUNT = "P|#N|next"


def motor_of(world: World, word: str) -> int:
    """Return a motor's index, given its number from 1 or its name, `right_wrist` say."""
    names = [motor.name.replace(" ", "_") for motor in world.body.transmission.motors]
    if word in names:
        return names.index(word)
    if word.isascii() and word.isdecimal() and 1 <= int(word) <= len(names):
        return int(word) - 1
    raise BadRequest(f"motors are 1 to {len(names)} or {', '.join(names)}, not {word!r}")


def _count(word: str) -> int:
    count = whole(word)
    if not 1 <= count <= NOISE_MOST:
        raise BadRequest(f"a count is from 1 to {NOISE_MOST}, not {count}")
    return count


def _seconds(word: str) -> float:
    seconds = number(word)
    if seconds <= 0.0:
        raise BadRequest(f"a delay must be above 0 seconds, not {word}")
    return seconds


def _switch_state(word: str) -> SwitchState:
    states = {each.value: each for each in SwitchState}
    if word.lower() not in states:
        raise BadRequest(f"a switch is {', '.join(states)}, not {word!r}")
    return states[word.lower()]


def _code(word: str) -> int:
    if not _CODE.fullmatch(word) or int(word, 16) < FIRST_ERROR:
        raise BadRequest(f"an error code is four hex digits from 0100 on, 4310 say, not {word!r}")
    return int(word, 16)


# Makes the amount of a fault for one direction of the wire.
MakeAmount: TypeAlias = Callable[[random.Random], Amount]


def _amount(word: str) -> MakeAmount:
    if word == "next":
        return Amount
    if word.startswith("#"):
        count = whole(word[1:])
        if count < 1:
            raise BadRequest("bytes are counted from #1")
        return partial(Amount, nth=count)
    share = number(word)
    if not 0.0 <= share <= 1.0:
        raise BadRequest(f"a probability is from 0 to 1, not {word}; the n-th byte is #n")
    return partial(Amount, share=share)


ARGUMENTS: Mapping[str, Callable[[World, str], Any]] = MappingProxyType(
    {
        "MOTOR": motor_of,
        "N": lambda _, word: _count(word),
        "COUNT": lambda _, word: _count(word),
        "MODE": lambda _, word: whole(word),
        "ID": lambda _, word: whole(word),
        "CODE": lambda _, word: _code(word),
        "SECONDS": lambda _, word: _seconds(word),
        AMOUNT: lambda _, word: _amount(word),
        "open|closed|free": lambda _, word: _switch_state(word),
        "as": lambda _, word: word,
        "NAME": lambda _, word: word,
    }
)


# --- The controller and the arm: power, resets, steps, switches ----------------------------------

BROWN_OUT_S = 0.5  # how long the power fails


def brown_out(on: Faults, _: FaultRequest) -> Lasting:
    """Cut the power for a while; only the fault that has cut the power brings it back."""
    was_on = on.device.powered
    on.device.set_power(False)
    yield until_ended
    if was_on:
        on.device.set_power(True)


def reset(on: Faults, _: FaultRequest) -> None:
    """Reset the board with its power on."""
    on.board.reset()


def lose_steps(on: Faults, _: FaultRequest, motor: int, count: int) -> Lasting:
    """Make a motor lose steps."""
    world = on.device.world
    world.lose(motor, count)
    yield lambda: world.to_lose.get(motor, 0) > 0
    world.to_lose.pop(motor, None)


def stall(on: Faults, _: FaultRequest, motor: int) -> Lasting:
    """Make a motor stop following."""
    stalled = on.device.world.stalled
    stalled.add(motor)
    yield lambda: motor in stalled
    stalled.discard(motor)


def switch(on: Faults, _: FaultRequest, axis: int, state: SwitchState) -> Lasting:
    """Make a limit switch stick, or free it."""
    on.board.set_switch(axis, state)
    if state is not SwitchState.FREE:
        yield until_ended
        on.board.set_switch(axis, SwitchState.FREE)


# --- The wire: bytes lost, changed, repeated, late or made up; the cable pulled ------------------

MakeRule: TypeAlias = Callable[[FaultRequest, Amount], Rule]
# How late a frame is that others overtake: longer than a burst of frames lasts on a bus.
OVERTAKEN_S = 0.005
_ALL = partial(Amount, share=1.0)


def draw(request: FaultRequest, salt: int = 0) -> random.Random:
    """Return the random generator of a fault, the same for the same seed."""
    return random.Random(f"{request.name} {request.seed} {salt}")  # noqa: S311 - to be repeatable


def ruling(make: MakeRule, on: Faults, request: FaultRequest, amount: MakeAmount) -> Lasting:
    """Apply a rule to the directions concerned, until it is used up or the fault is ended."""
    lanes = {"host": on.line.faults.host, "device": on.line.faults.device}
    rules: list[tuple[WireDirection, Rule]] = []
    for salt, (name, lane) in enumerate(lanes.items()):
        if request.side in (name, "both"):
            rules.append((lane, make(request, amount(draw(request, salt)))))
            lane.rules.append(rules[-1][1])
    yield lambda: any(rule in lane.rules for lane, rule in rules)
    for lane, rule in rules:
        lane.rules = [one for one in lane.rules if one is not rule]


def delay(on: Faults, request: FaultRequest, seconds: float, amount: Any = _ALL) -> Lasting:
    """Delay messages: all of them, unless an amount is given."""
    return ruling(lambda _, amount: Rule(amount, late_s=seconds), on, request, amount)


def mute(on: Faults, request: FaultRequest, side: str = "device") -> Lasting:
    """Block everything sent by one side, or by both."""
    return ruling(lambda _, amount: Rule(amount, lost), on, replace(request, side=side), _ALL)


def garbage(on: Faults, request: FaultRequest, count: int = NOISE_BYTES) -> None:
    """Make noise come from the device's end of the wire."""
    on.line.say(draw(request).randbytes(count), on.device.now_s)


def unplug(on: Faults, _: FaultRequest) -> Lasting:
    """Pull the cable."""
    on.cable.unplug()
    yield lambda: not on.cable.plugged
    on.cable.replug()


def replug(on: Faults, _: FaultRequest, *words: str) -> None:
    """Plug the cable in again, possibly under another name."""
    on.cable.replug(next((word for word in words if word != "as"), None))


# --- A CAN bus and its drives: frames overtaken, drives mute or reset -----------------------------


def bus_off(on: Faults, _: FaultRequest) -> Lasting:
    """Make the host's adapter go bus-off."""
    on.bus.leave_bus()
    yield lambda: on.bus.adapter.bus_off
    on.bus.leave_bus(off=False)


def alone(on: Faults, request: FaultRequest) -> Lasting:
    """Stop acknowledging the adapter's frames, as if it were alone on its bus."""
    on.bus.adapter.alone = True
    yield from mute(on, request, "both")
    on.bus.adapter.alone = False


def drive_flag(name: str, on: Faults, _: FaultRequest, at: int) -> Lasting:
    """Set a flag in the port of a drive."""
    setattr(on.board.node(at).port, name, True)
    yield until_ended
    setattr(on.board.node(at).port, name, False)


def dead_drive(on: Faults, _: FaultRequest, at: int) -> Lasting:
    """Cut a drive's supply."""
    on.board.switch_drive(at, False)
    yield until_ended
    on.board.switch_drive(at, True)


def set_drive(key: str, on: Faults, _: FaultRequest, at: int, value: int) -> Lasting:
    """Change the id or the mode of a drive, as its own keys do."""
    before = getattr(on.board.node(at), f"set_{key}")(value, on.device.now_s)
    yield until_ended
    getattr(on.board.node(at), f"set_{key}")(before, on.device.now_s)


def reset_drive(on: Faults, _: FaultRequest, at: int) -> None:
    """Restart a drive's firmware."""
    on.board.reset_drive(at)


def ailing_drive(on: Faults, _: FaultRequest, at: int, code: int) -> Lasting:
    """Give a drive a fault of its own for a while; afterwards it must be reset."""
    on.board.put_in_fault(at, code)
    yield until_ended
    on.board.fix(at, code)


def warning_drive(on: Faults, _: FaultRequest, at: int, code: int) -> None:
    """Make a drive send an EMCY message and carry on."""
    on.board.warn(at, code)


# --- The table: name, arguments, what goes wrong -------------------------------------------------
# A muted drive still receives and obeys. A changed id or mode counts as set with the drive's own
# keys; the id may be that of another drive.


def _wire(name: str, summary: str, make: MakeRule, needs: type = object) -> FaultKind:
    return FaultKind(name, AMOUNT, summary, partial(ruling, make), needs)


_KINDS = (
    _wire("drop", "bytes, or frames of a bus, are lost", lambda _, amount: Rule(amount, lost)),
    _wire("corrupt", "bytes have a bit flipped; such a frame is lost",
          lambda request, amount: Rule(amount, changed(draw(request, 2)))),
    _wire("duplicate", "bytes, or frames of a bus, arrive twice",
          lambda _, amount: Rule(amount, repeated)),
    FaultKind("delay", f"SECONDS [{AMOUNT}]", "messages are late", delay),
    FaultKind("mute", "", "the device sends nothing", mute),
    FaultKind("garbage", "[COUNT]", "the device sends noise (8 bytes, or COUNT)", garbage),
    FaultKind("unplug", "", "the cable is pulled", unplug),
    FaultKind("replug", "[as NAME]", "the cable is plugged in again", replug),
    FaultKind("brown-out", "", "power fails for half a second: registers are lost, the arm sags",
              brown_out, lasts_s=BROWN_OUT_S),
    FaultKind("reset", "", "the board resets with its power on", reset, Resettable),
    FaultKind("lose-steps", "MOTOR N", "the next N steps are lost", lose_steps),
    FaultKind("stall", "MOTOR", "a motor no longer follows", stall),
    FaultKind("switch", "MOTOR open|closed|free", "a limit switch sticks", switch, HasSwitches),
    _wire("overtake", "frames are overtaken by later ones",
          lambda _, amount: Rule(amount, late_s=OVERTAKEN_S, overtaken=True), DrivesBoard),
    FaultKind("bus-off", "", "the host's adapter goes bus-off", bus_off, DrivesBoard),
    FaultKind("alone", "", "no node acknowledges the adapter's frames", alone, DrivesBoard),
    FaultKind("drive-mute", "MOTOR", "a drive sends nothing but obeys",
              partial(drive_flag, "mute"), DrivesBoard),
    FaultKind("drive-dead", "MOTOR", "a drive has no supply", dead_drive, DrivesBoard),
    FaultKind("drive-reset", "MOTOR", "a drive restarts", reset_drive, DrivesBoard),
    FaultKind("drive-mode", "MOTOR MODE", "a drive is in another mode",
              partial(set_drive, "mode"), DrivesBoard),
    FaultKind("drive-id", "MOTOR ID", "a drive has another id",
              partial(set_drive, "id"), DrivesBoard),
    FaultKind("no-done", "MOTOR", "a drive does not report the end of a motion",
              partial(drive_flag, "withheld"), DrivesBoard),
    FaultKind("drive-fault", "MOTOR CODE", "a drive fails with an error code, such as 4310",
              ailing_drive, SaysEmergencies),
    FaultKind("drive-emcy", "MOTOR CODE", "a drive sends an EMCY and carries on", warning_drive,
              SaysEmergencies),
)  # fmt: skip
# Every fault by its name. Parsing, help and lists are made from this table.
FAULTS: Mapping[str, FaultKind] = MappingProxyType({kind.name: kind for kind in _KINDS})


# How faults are written, below their table.
FAULT_NOTE = (
    "P is a probability for each byte (of a bus: frame), #N the N-th from now, next the whole\n"
    "next message; wire faults take from=host or from=device, and seed=N;\n"
    "for=SECONDS limits the duration, @SECONDS begins later: `drop 0.01 from=host for=2 @5` at\n"
    "the console, --fault drop:0.01,from=host,for=2@5 on the command line."
)


def faults_of(board: type[Board]) -> tuple[FaultKind, ...]:
    """Return the faults that a device with this kind of board can have."""
    return tuple(kind for kind in FAULTS.values() if kind.befalls(board))


def arguments_of(request: FaultRequest, device: SimDevice) -> tuple[Any, ...]:
    """Return the arguments of a fault. Raises `BadRequest` if the device cannot have it."""
    kind = FAULTS.get(request.name)
    if kind is None:
        names = [each.name for each in faults_of(type(device.board))]
        hint = did_you_mean(request.name, names, f"there are {', '.join(names)}")
        raise BadRequest(f"there is no fault {request.name!r}; {hint}")
    require_ability(device.board, kind.needs)
    check_count(kind.usage, request.words)
    names = [name.strip("[]") for name in kind.arguments.split()]
    pairs = zip(names, request.words, strict=False)
    return tuple(ARGUMENTS[name](device.world, word) for name, word in pairs)


# --- The faults that are under way on one simulated arm, begun and ended on its clock ------------
# The same on an in-process wire, a pseudo-terminal and a socket.


@dataclass(frozen=True, slots=True, eq=False)
class _Active:
    request: FaultRequest
    arguments: tuple[Any, ...]
    lasting: Lasting
    alive: Callable[[], bool]


def link_cable(link: MemoryLink) -> Cable:
    """Return the cable of an in-process wire."""
    return Cable(link.line, link.unplug, link.replug)


@known_attributes
@checked_calls({**BASIC, "FaultRequest": made_of(FaultRequest, "a fault that was asked for")})
class Faults:
    """The faults of one device. Call it from the thread that owns the device, or under its lock."""

    def __init__(self, device: SimDevice, line: DeviceLine, cable: Cable) -> None:
        self.device, self.line, self.cable = device, line, cable
        self._active: list[_Active] = []
        self.troubles: list[str] = []
        """Why faults could not begin or end when their time came. A reader removes the reasons."""

    @property
    def board(self) -> Any:
        """The board; it has the ability that the fault's row of the table needs."""
        return self.device.board

    @property
    def bus(self) -> BusLine:
        """The line, if the board is a `DrivesBoard`."""
        return cast(BusLine, self.line)

    @property
    def active(self) -> tuple[str, ...]:
        """The faults in effect."""
        return tuple(each.request.text for each in self._effective())

    def add(
        self,
        name: str,
        *arguments: object,
        side: str = "both",
        seed: int = 0,
        after_s: float = 0.0,
        for_s: float | None = None,
    ) -> None:
        """Add a fault, as in `add("drop", 0.01, side="host")`; see `FAULTS`.

        `after_s` counts from the device's current time. Raises `BadRequest`.
        """
        words = tuple(str(each) for each in arguments)
        self.ask(FaultRequest(name, words, side, seed, after_s, for_s))

    def ask(self, request: FaultRequest) -> None:
        """Add a fault parsed from words. Raises `BadRequest` at once if it is invalid."""
        arguments = arguments_of(request, self.device)
        if request.after_s:
            self._later(request.after_s, lambda: self._begin(request, arguments))
        else:
            self._begin(request, arguments)

    def end(self, name: str | None = None) -> tuple[str, ...]:
        """End all faults, or those of a name; return those that were in effect."""
        ended = [each for each in self._effective() if name in (None, each.request.name)]
        for each in ended:
            self._end(each)
        return tuple(each.request.text for each in ended)

    def _begin(self, request: FaultRequest, arguments: tuple[Any, ...]) -> None:
        kind = FAULTS[request.name]
        self._active = self._effective()
        for each in [*self._active] if kind.of_motor else ():
            if each.request.name == request.name and each.arguments[0] == arguments[0]:
                self._end(each)
        lasting = kind.begin(self, request, *arguments)
        alive = None if lasting is None else next(lasting, None)
        if lasting is None or alive is None:
            return
        active = _Active(request, arguments, lasting, alive)
        self._active.append(active)
        lasts_s = kind.lasts_s if request.for_s is None else request.for_s
        if lasts_s is not None:
            self._later(lasts_s, lambda: self._end(active))

    def _effective(self) -> list[_Active]:
        return [each for each in self._active if each.alive()]

    def _later(self, in_s: float, action: Callable[[], None]) -> None:
        """Do something in a while; if it fails then, keep the reason."""

        def act() -> None:
            try:
                action()
            except ArmError as error:
                self.troubles.append(str(error))

        self.device.at(self.device.now_s + in_s, act)

    def _end(self, active: _Active) -> None:
        if active in self._active:
            self._active.remove(active)
            if active.alive():
                next(active.lasting, None)
