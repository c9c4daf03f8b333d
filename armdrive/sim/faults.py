"""The faults of simulated arms: their requests, what each does, their table, and those at work.

A `FaultRequest` comes from the command line, from the console or from `Faults.add`. `Faults.ask`
finds its row in `FAULTS` and runs the row's generator (`Fault`) up to its first `yield`: so wrong
words are refused at once, also of a fault that begins later. The device's agenda resumes the
generator at its time, and once more to end the fault. Faults of the wire put rules into the
directions of the line (wire.py); the others change the board, the world or the cable.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
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
    Effect,
    MemoryLink,
    Next,
    Nth,
    Rule,
    Share,
    WireDirection,
    changed,
    late,
    lost,
    overtaken,
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
    text: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise BadRequest(f"bytes come from {', '.join(SIDES)}, not from {self.side!r}")
        for seconds in (self.after_s, self.for_s or 0.0):
            if not (math.isfinite(seconds) and seconds >= 0.0):
                raise BadRequest(f"a time must be 0 or more seconds, not {seconds}")
        if not self.text:
            object.__setattr__(self, "text", " ".join((self.name, *self.words)))


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
        name, equals, value = word.partition("=")
        if word.startswith("@"):
            after_s = number(word[1:])
        elif equals and name in _NAMED:
            named[name] = value
        elif word.startswith("--"):
            raise BadRequest(f"there is no {word}; write from=host, seed=3, for=2 or @5")
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
        text=" ".join(words),
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


@dataclass(frozen=True, slots=True)
class FaultBench:
    """Everything that a fault can affect."""

    device: SimDevice
    line: DeviceLine
    cable: Cable

    @property
    def board(self) -> Any:
        """The board; it has the ability that the fault's row of the table needs."""
        return self.device.board

    @property
    def bus(self) -> BusLine:
        """The line, if the board is a `DrivesBoard`."""
        return cast(BusLine, self.line)

    def motor(self, request: FaultRequest) -> int:
        """Return the index of the motor that the first word of a request names."""
        return motor_of(self.device.world, request.words[0])


# A fault: it checks its words and yields, begins when it is resumed, and yields again if it lasts.
#
# Resuming it once more ends it. The second yield may give a function that tells whether the fault
# still has an effect; None means until it is ended.
Fault: TypeAlias = Generator[Callable[[], bool] | None, None, None]


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One row; `needs` is the ability required of the board, `lasts_s` the usual duration."""

    name: str
    arguments: str
    summary: str
    run: Callable[[FaultBench, FaultRequest], Fault]
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


# --- The controller and the arm: power, resets, steps, switches ----------------------------------

BROWN_OUT_S = 0.5  # how long the power fails
RunFault: TypeAlias = Callable[[FaultBench, FaultRequest], Fault]


def brown_out(bench: FaultBench, _: FaultRequest) -> Fault:
    """Cut the power for a while; only the fault that has cut the power brings it back."""
    yield None
    was_on = bench.device.powered
    bench.device.set_power(False)
    yield None
    # a device that was off stays off; another brown-out may have switched it on in the meantime
    if was_on:
        bench.device.set_power(True)


def reset(bench: FaultBench, _: FaultRequest) -> Fault:
    """Reset the board with its power on."""
    board: Resettable = bench.board
    yield None
    board.reset()


def lose_steps(bench: FaultBench, request: FaultRequest) -> Fault:
    """Make a motor lose steps."""
    motor, count = bench.motor(request), whole(request.words[1])
    if count < 1:
        raise BadRequest(f"1 step or more can be lost, not {count}")
    yield None
    world = bench.device.world
    world.lose(motor, count)
    yield lambda: world.to_lose.get(motor, 0) > 0
    world.to_lose.pop(motor, None)


def stall(bench: FaultBench, request: FaultRequest) -> Fault:
    """Make a motor stop following."""
    motor, stalled = bench.motor(request), bench.device.world.stalled
    yield None
    stalled.add(motor)
    yield lambda: motor in stalled
    stalled.discard(motor)


def switch(bench: FaultBench, request: FaultRequest) -> Fault:
    """Make a limit switch stick, or free it."""
    board: HasSwitches = bench.board
    axis, state = bench.motor(request), request.words[1].lower()
    states = {each.value: each for each in SwitchState}
    if state not in states:
        raise BadRequest(f"a switch is {', '.join(states)}, not {request.words[1]!r}")

    yield None
    board.set_switch(axis, states[state])
    if states[state] is not SwitchState.FREE:
        yield None
        board.set_switch(axis, SwitchState.FREE)


def motor_of(world: World, word: str) -> int:
    """Return a motor's index, given its number from 1 or its name, `right_wrist` say."""
    names = [motor.name.replace(" ", "_") for motor in world.body.transmission.motors]
    if word in names:
        return names.index(word)
    if word.isascii() and word.isdecimal() and 1 <= int(word) <= len(names):
        return int(word) - 1
    raise BadRequest(f"motors are 1 to {len(names)} or {', '.join(names)}, not {word!r}")


# --- The wire: bytes lost, changed, repeated, late or made up; the cable pulled ------------------

NOISE_BYTES, NOISE_MOST = 8, 4096  # the usual and the greatest number of bytes


def on_wire(
    effect: Callable[[FaultRequest], Effect], first: int = 0, default: str = ""
) -> RunFault:
    """Return the fault that applies an effect to the directions concerned.

    The amount is the word after the `first` ones, or the default.
    """
    return ruling(lambda request, amount: Rule(effect(request), amount), first, default)


def ruling(
    make: Callable[[FaultRequest, Amount], Rule], first: int = 0, default: str = ""
) -> RunFault:
    """Return the fault that applies a rule to the directions concerned, until it is used up."""

    def run(bench: FaultBench, request: FaultRequest) -> Fault:
        words = request.words[first:] or ((default,) if default else ())
        yield from _in_force(
            [
                (lane, make(request, _amount(words[0] if words else "", request, lane_number)))
                for lane_number, lane in enumerate(_lanes(bench, request.side))
            ]
        )

    return run


def _in_force(rules: list[tuple[WireDirection, Rule]]) -> Fault:
    """Keep rules in force until they are used up, or the fault is ended."""
    yield None
    for lane, rule in rules:
        lane.rules.append(rule)
    yield lambda: any(rule in lane.rules for lane, rule in rules)
    for lane, rule in rules:
        lane.rules = [one for one in lane.rules if one is not rule]


def _lanes(bench: FaultBench, side: str) -> list[WireDirection]:
    lanes = {"host": bench.line.faults.host, "device": bench.line.faults.device}
    return [lane for name, lane in lanes.items() if side in (name, "both")]


def _amount(word: str, request: FaultRequest, salt: int) -> Amount:
    if word == "next":
        return Next()
    if word.startswith("#"):
        count = whole(word[1:])
        if count < 1:
            raise BadRequest("bytes are counted from #1")
        return Nth(count)
    share = number(word)
    if not 0.0 <= share <= 1.0:
        raise BadRequest(f"a probability is from 0 to 1, not {word}; the n-th byte is #n")
    return Share(share, draw(request, salt))


def draw(request: FaultRequest, salt: int = 0) -> random.Random:
    """Return the random generator of a fault, the same for the same seed."""
    return random.Random(f"{request.name} {request.seed} {salt}")  # noqa: S311 - to be repeatable


def delaying(request: FaultRequest) -> Effect:
    """Return the effect of a delay, given as the first word."""
    seconds = number(request.words[0])
    if not 0.0 < seconds < float("inf"):
        raise BadRequest(f"a delay must be above 0 seconds, not {request.words[0]}")
    return late(seconds)


def mute(bench: FaultBench, _: FaultRequest) -> Fault:
    """Make the device send nothing."""
    return _silence(bench, "device")


def _silence(bench: FaultBench, side: str) -> Fault:
    """Block everything sent by one side, or by both."""
    every = Share(1.1, random.Random(0))  # noqa: S311 - every byte, nothing is drawn
    return _in_force([(lane, Rule(lost, every)) for lane in _lanes(bench, side)])


def garbage(bench: FaultBench, request: FaultRequest) -> Fault:
    """Make noise come from the device's end of the wire."""
    count = whole(request.words[0]) if request.words else NOISE_BYTES
    if not 1 <= count <= NOISE_MOST:
        raise BadRequest(f"noise has 1 to {NOISE_MOST} bytes, not {count}")
    noise = draw(request).randbytes(count)
    yield None
    bench.line.say(noise, bench.device.now_s)


def unplug(bench: FaultBench, _: FaultRequest) -> Fault:
    """Pull the cable."""
    yield None
    bench.cable.unplug()
    yield lambda: not bench.cable.plugged
    bench.cable.replug()


def replug(bench: FaultBench, request: FaultRequest) -> Fault:
    """Plug the cable in again, possibly under another name."""
    words = [word for word in request.words if word != "as"]
    yield None
    bench.cable.replug(words[0] if words else None)


# --- A CAN bus and its drives: frames overtaken, drives mute or reset -----------------------------
# These faults need a board that is `DrivesBoard`, whose wire is a bus; some need one that
# `SaysEmergencies`.

_CODE = re.compile(r"[0-9A-Fa-f]{4}")
# The lowest error code of an EMCY message; lower codes mean that no error is left.
FIRST_ERROR = 0x100


def bus_off(bench: FaultBench, _: FaultRequest) -> Fault:
    """Make the host's adapter go bus-off."""
    line = bench.bus
    yield None
    line.leave_bus()
    yield lambda: line.adapter.bus_off
    line.leave_bus(off=False)


def alone(bench: FaultBench, _: FaultRequest) -> Fault:
    """Stop acknowledging the adapter's frames, as if it were alone on its bus."""
    adapter, silence = bench.bus.adapter, _silence(bench, "both")
    yield next(silence)
    adapter.alone = True
    next(silence)
    yield None
    adapter.alone = False
    next(silence, None)


def _on_drive(switch: Callable[[DrivesBoard[Any], int, bool], object]) -> RunFault:
    """Return the fault that affects a drive, and undoes the effect at the end."""

    def run(bench: FaultBench, request: FaultRequest) -> Fault:
        at = bench.motor(request)
        yield None
        switch(bench.board, at, True)
        yield None
        switch(bench.board, at, False)

    return run


def _mute_drive(board: DrivesBoard[Any], at: int, on: bool) -> None:
    board.node(at).port.mute = on


def _withhold_done(board: DrivesBoard[Any], at: int, on: bool) -> None:
    board.node(at).port.withheld = on


def _changing(change: Callable[[DrivesBoard[Any], int, int], int]) -> RunFault:
    """Return the fault that changes a number of a drive, and restores it at the end."""

    def run(bench: FaultBench, request: FaultRequest) -> Fault:
        at, value = bench.motor(request), whole(request.words[1])
        yield None
        before = change(bench.board, at, value)
        yield None
        change(bench.board, at, before)

    return run


def reset_drive(bench: FaultBench, request: FaultRequest) -> Fault:
    """Restart a drive's firmware."""
    board: DrivesBoard[Any] = bench.board
    at = bench.motor(request)
    yield None
    board.reset_drive(at)


def ailing_drive(bench: FaultBench, request: FaultRequest) -> Fault:
    """Give a drive a fault of its own for a while; afterwards it must be reset."""
    drives: SaysEmergencies = bench.board
    at, code = bench.motor(request), _code(request.words[1])
    yield None
    drives.put_in_fault(at, code)
    yield None
    drives.fix(at, code)


def warning_drive(bench: FaultBench, request: FaultRequest) -> Fault:
    """Make a drive send an EMCY message and carry on."""
    drives: SaysEmergencies = bench.board
    at, code = bench.motor(request), _code(request.words[1])
    yield None
    drives.warn(at, code)


def _code(word: str) -> int:
    if not _CODE.fullmatch(word) or int(word, 16) < FIRST_ERROR:
        raise BadRequest(f"an error code is four hex digits from 0100 on, 4310 say, not {word!r}")
    return int(word, 16)


# --- The table: name, arguments, what goes wrong -------------------------------------------------
# A muted drive still receives and obeys. A changed id or mode counts as set with the drive's own
# keys; the id may be that of another drive.

# How much: each byte with a probability, the n-th byte from now, or all of the next message.
#
# On a bus frames take the place of bytes.
AMOUNT = "P|#N|next"
# Faults that only drives on a CAN bus can have.
_ON_BUS = tuple(
    replace(kind, needs=DrivesBoard)
    for kind in (
        FaultKind(
            "overtake",
            AMOUNT,
            "frames arrive after the next one",
            ruling(lambda _, amount: overtaken(amount)),
        ),
        FaultKind("bus-off", "", "the host's adapter goes bus-off", bus_off),
        FaultKind("alone", "", "no node acknowledges the adapter's frames", alone),
        FaultKind(
            "drive-mute",
            "MOTOR",
            "a drive sends nothing but obeys",
            _on_drive(_mute_drive),
        ),
        FaultKind(
            "drive-dead",
            "MOTOR",
            "a drive has no supply",
            _on_drive(lambda board, at, on: board.switch_drive(at, not on)),
        ),
        FaultKind("drive-reset", "MOTOR", "a drive restarts", reset_drive),
        FaultKind(
            "drive-mode",
            "MOTOR MODE",
            "a drive is in another mode",
            _changing(lambda board, at, mode: board.node(at).set_mode(mode, board.now_s)),
        ),
        FaultKind(
            "drive-id",
            "MOTOR ID",
            "a drive has another id",
            _changing(lambda board, at, number: board.node(at).set_id(number, board.now_s)),
        ),
        FaultKind(
            "no-done",
            "MOTOR",
            "a drive does not report the end of a motion",
            _on_drive(_withhold_done),
        ),
    )
)
# Faults of drives that have error codes.
_OF_DRIVES = tuple(
    replace(kind, needs=SaysEmergencies)
    for kind in (
        FaultKind(
            "drive-fault",
            "MOTOR CODE",
            "a drive fails with an error code, such as 4310",
            ailing_drive,
        ),
        FaultKind(
            "drive-emcy", "MOTOR CODE", "a drive sends an EMCY and carries on", warning_drive
        ),
    )
)
_ON_ANY = (
    FaultKind("drop", AMOUNT, "bytes, or frames of a bus, are lost", on_wire(lambda _: lost)),
    FaultKind(
        "corrupt",
        AMOUNT,
        "bytes have a bit flipped; such a frame is lost",
        on_wire(lambda request: changed(draw(request, 2))),
    ),
    FaultKind(
        "duplicate", AMOUNT, "bytes, or frames of a bus, arrive twice", on_wire(lambda _: repeated)
    ),
    FaultKind("delay", f"SECONDS [{AMOUNT}]", "messages are late", on_wire(delaying, 1, "1")),
    FaultKind("mute", "", "the device sends nothing", mute),
    FaultKind("garbage", "[COUNT]", "the device sends noise (8 bytes, or COUNT)", garbage),
    FaultKind("unplug", "", "the cable is pulled", unplug),
    FaultKind("replug", "[as NAME]", "the cable is plugged in again", replug),
    FaultKind(
        "brown-out",
        "",
        "power fails for half a second: registers are lost, the arm sags",
        brown_out,
        lasts_s=BROWN_OUT_S,
    ),
    FaultKind("reset", "", "the board resets with its power on", reset, needs=Resettable),
    FaultKind("lose-steps", "MOTOR N", "the next N steps are lost", lose_steps),
    FaultKind("stall", "MOTOR", "a motor no longer follows", stall),
    FaultKind(
        "switch",
        "MOTOR open|closed|free",
        "a limit switch sticks",
        switch,
        needs=HasSwitches,
    ),
)
# Every fault by its name. Parsing, help and lists are made from this table.
FAULTS: Mapping[str, FaultKind] = MappingProxyType(
    {kind.name: kind for kind in (*_ON_ANY, *_ON_BUS, *_OF_DRIVES)}
)


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


# --- The faults that are under way on one simulated arm, begun and ended on its clock ------------
# The same on an in-process wire, a pseudo-terminal and a socket.


@dataclass(frozen=True, slots=True, eq=False)
class _Active:
    request: FaultRequest
    fault: Fault
    alive: Callable[[], bool]


def _always() -> bool:
    return True


def link_cable(link: MemoryLink) -> Cable:
    """Return the cable of an in-process wire."""
    return Cable(link.line, link.unplug, link.replug)


@known_attributes
@checked_calls({**BASIC, "FaultRequest": made_of(FaultRequest, "a fault that was asked for")})
class Faults:
    """The faults of one device. Call it from the thread that owns the device, or under its lock."""

    def __init__(self, device: SimDevice, line: DeviceLine, cable: Cable) -> None:
        self._bench = FaultBench(device, line, cable)
        self._active: list[_Active] = []
        self.troubles: list[str] = []
        """Why faults could not begin or end when their time came. A reader removes the reasons."""

    @property
    def active(self) -> tuple[str, ...]:
        """The faults in effect, as they were requested."""
        return tuple(each.request.text for each in self._active if each.alive())

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
        fault, kind = self.checked(request), FAULTS[request.name]
        lasts_s = kind.lasts_s if request.for_s is None else request.for_s

        def start() -> None:
            for each in [*self._active] if kind.of_motor else ():
                motor = self._bench.motor(request)
                if each.request.name == request.name and self._bench.motor(each.request) == motor:
                    self._end(each)
            try:
                alive = next(fault)
            except StopIteration:  # over at once
                return
            active = _Active(request, fault, alive or _always)
            self._active = [*(each for each in self._active if each.alive()), active]
            if lasts_s is not None:
                device = self._bench.device
                device.at(device.now_s + lasts_s, lambda: self._later(lambda: self._end(active)))

        if request.after_s:
            device = self._bench.device
            device.at(device.now_s + request.after_s, lambda: self._later(start))
        else:
            start()

    def checked(self, request: FaultRequest) -> Fault:
        """Return a fault that is ready to begin, or raise `BadRequest`. Nothing happens yet."""
        kind = FAULTS.get(request.name)
        if kind is None:
            names = [each.name for each in faults_of(type(self._bench.device.board))]
            hint = did_you_mean(request.name, names, f"there are {', '.join(names)}")
            raise BadRequest(f"there is no fault {request.name!r}; {hint}")
        require_ability(self._bench.device.board, kind.needs)
        check_count(kind.usage, request.words)
        fault = kind.run(self._bench, request)
        next(fault)
        return fault

    def end(self, name: str | None = None) -> tuple[str, ...]:
        """End all faults, or those of a name; return those that were in effect."""
        ended = [each for each in self._active if name in (None, each.request.name)]
        for each in ended:
            self._end(each)
        return tuple(each.request.text for each in ended)

    def _later(self, action: Callable[[], None]) -> None:
        """Do something at a time; if it fails then, keep the reason."""
        try:
            action()
        except ArmError as error:
            self.troubles.append(str(error))

    def _end(self, active: _Active) -> None:
        if active in self._active:
            self._active.remove(active)
            if active.alive():
                next(active.fault, None)


def check_faults(device: SimDevice, requests: Iterable[FaultRequest]) -> None:
    """Raise `BadRequest` for a fault that this device cannot have.

    Nothing happens to the device.
    """
    link = MemoryLink(device.line(), "simulated arm")
    try:
        faults = Faults(device, link.line, link_cable(link))
        for request in requests:
            faults.checked(request)
    finally:
        link.close()
