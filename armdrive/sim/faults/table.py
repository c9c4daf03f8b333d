"""The faults of simulated arms: what each does, their table, and those in progress.

First come the faults of the controller and the arm: power, resets, motors, limit switches.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.arguments import BASIC, checked_calls, made_of
from armdrive.sim.device import (
    Board,
    DriveControls,
    DriveErrors,
    DrivesOnBus,
    HasSwitches,
    Resettable,
    SaysEmergencies,
    SimDevice,
    SwitchState,
    lacks,
)
from armdrive.sim.faults.request import (
    Begin,
    Cable,
    FaultBench,
    FaultKind,
    FaultRequest,
    Prepare,
    Running,
    check_count,
    lasting,
)
from armdrive.sim.wire import (
    Amount,
    Effect,
    Next,
    Nth,
    PacedDevice,
    Rule,
    Share,
    WireDirection,
    changed,
    frame_lost,
    late,
    lost,
    overtaken,
    repeated,
)
from armdrive.text.numbers import number, whole
from armdrive.transports.in_process import MemoryLink
from kinematics.errors import did_you_mean

BROWN_OUT_S = 0.5


def brown_out(bench: FaultBench, _: FaultRequest) -> Begin:
    """Cut the power for a while."""
    return lasting(lambda: bench.device.set_power(False), lambda: bench.device.set_power(True))


def reset(bench: FaultBench, _: FaultRequest) -> Begin:
    """Reset the board with its power on."""
    board = bench.device.board
    if not isinstance(board, Resettable):
        raise lacks(board, "reset apart from its power")
    return board.reset


def lose_steps(bench: FaultBench, request: FaultRequest) -> Begin:
    """Make a motor lose steps."""
    motor, count = motor_of(bench, request.words[0]), whole(request.words[1])
    if count < 1:
        raise BadRequest(f"1 step or more can be lost, not {count}")
    return lambda: bench.device.world.lose(motor, count)


def stall(bench: FaultBench, request: FaultRequest) -> Begin:
    """Make a motor stop following."""
    motor, stalled = motor_of(bench, request.words[0]), bench.device.world.stalled
    return lasting(
        lambda: stalled.add(motor), lambda: stalled.discard(motor), lambda: motor in stalled
    )


def switch(bench: FaultBench, request: FaultRequest) -> Begin:
    """Make a limit switch stick, or free it."""
    board = bench.device.board
    if not isinstance(board, HasSwitches):
        raise lacks(board, "limit switches")
    axis, state = motor_of(bench, request.words[0]), request.words[1].lower()
    states = {each.value: each for each in SwitchState}
    if state not in states:
        raise BadRequest(f"a switch is {', '.join(states)}, not {request.words[1]!r}")

    if states[state] is SwitchState.FREE:
        return lambda: board.set_switch(axis, SwitchState.FREE)
    return lasting(
        lambda: board.set_switch(axis, states[state]),
        lambda: board.set_switch(axis, SwitchState.FREE),
    )


def motor_of(bench: FaultBench, word: str) -> int:
    """Return a motor's index, given its number from 1 or its name."""
    names = [motor.name for motor in bench.device.world.body.transmission.motors]
    if word in names:
        return names.index(word)
    if word.isascii() and word.isdecimal() and 1 <= int(word) <= len(names):
        return int(word) - 1
    raise BadRequest(f"motors are 1 to {len(names)} or {', '.join(names)}, not {word!r}")


# --- The wire: bytes lost, changed, repeated, late or made up; the cable pulled ------------------

NOISE_BYTES = 8
NOISE_MOST = 4096


def on_wire(effect: Callable[[FaultRequest], Effect], first: int = 0, default: str = "") -> Prepare:
    """Return a row's `prepare` that applies an effect to the directions concerned."""
    return ruling(lambda request, amount: Rule(effect(request), amount), first, default)


def ruling(
    make: Callable[[FaultRequest, Amount], Rule], first: int = 0, default: str = ""
) -> Prepare:
    """Return a row's `prepare` that applies a rule to the directions concerned."""

    def prepare(bench: FaultBench, request: FaultRequest) -> Begin:
        words = request.words[first:] or ((default,) if default else ())
        rules = [
            (lane, make(request, _amount(words[0] if words else "", request, lane_number)))
            for lane_number, lane in enumerate(_lanes(bench, request.side))
        ]

        return _in_force(rules)

    return prepare


def _in_force(rules: list[tuple[WireDirection, Rule]]) -> Begin:
    """Return a function that adds rules to their directions until they are used up or removed."""

    def put() -> None:
        for lane, rule in rules:
            lane.rules.append(rule)

    def withdraw() -> None:
        for lane, rule in rules:
            lane.rules = [one for one in lane.rules if one is not rule]

    return lasting(put, withdraw, lambda: any(rule in lane.rules for lane, rule in rules))


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


def mute(bench: FaultBench, _: FaultRequest) -> Begin:
    """Make the device send nothing."""
    return _silencing(bench, "device")


def _silencing(bench: FaultBench, side: str) -> Begin:
    """Return a function that blocks everything sent by one side, or by both."""
    every = Share(1.1, random.Random(0))  # noqa: S311 - every byte, nothing is drawn
    return _in_force([(lane, Rule(lost, every)) for lane in _lanes(bench, side)])


def garbage(bench: FaultBench, request: FaultRequest) -> Begin:
    """Make noise come from the device's end of the wire."""
    count = whole(request.words[0]) if request.words else NOISE_BYTES
    if not 1 <= count <= NOISE_MOST:
        raise BadRequest(f"noise has 1 to {NOISE_MOST} bytes, not {count}")
    noise = draw(request).randbytes(count)
    return lambda: bench.line.say(noise, bench.device.now_s)


def unplug(bench: FaultBench, _: FaultRequest) -> Begin:
    """Pull the cable."""
    return lasting(bench.cable.unplug, bench.cable.replug)


def replug(bench: FaultBench, request: FaultRequest) -> Begin:
    """Plug the cable in again, possibly under another name."""
    words = [word for word in request.words if word != "as"]
    return lambda: bench.cable.replug(words[0] if words else None)


# --- A CAN bus and its drives: frames lost or overtaken, drives mute or reset --------------------
# These faults need a board that is `DrivesOnBus`; some need one that `SaysEmergencies`.

_CODE = re.compile(r"[0-9A-Fa-f]{4}")
FIRST_ERROR = 0x100
"""The lowest error code of an EMCY message; lower codes mean that no error is left."""


def frame_doubled(frame: bytes, amount: Amount) -> tuple[bytes, float]:
    """Send a frame twice."""
    return frame * (2 if amount.strikes(len(frame)) else 1), 0.0


def bus_off(bench: FaultBench, _: FaultRequest) -> Begin:
    """Make the host's adapter go bus-off."""
    _drives(bench)
    line: Any = bench.line

    def leave() -> None:
        if not hasattr(line, "leave_bus"):
            raise BadRequest("this wire is no CAN bus, so no adapter can leave it")
        line.leave_bus()

    return lasting(leave, lambda: line.leave_bus(off=False), lambda: line.controller.bus_off)


def alone(bench: FaultBench, _: FaultRequest) -> Begin:
    """Stop acknowledging the adapter's frames, as if it were alone on its bus."""
    _drives(bench)
    adapter = getattr(bench.line, "adapter", None)
    silence = _silencing(bench, "both")

    def set_alone(on: bool) -> None:
        if adapter is not None:
            adapter.faults.alone = on

    def begin() -> Running | None:
        set_alone(True)
        silent = silence()

        def end() -> None:
            set_alone(False)
            if silent is not None:
                silent.end()

        return Running(end)

    return begin


def _on_drive(switch: Callable[[DriveControls, int, bool], object]) -> Prepare:
    """Return a row's `prepare` that affects a drive, and undoes the effect at the end."""

    def prepare(bench: FaultBench, request: FaultRequest) -> Begin:
        drives, at = _drives(bench), motor_of(bench, request.words[0])
        return lasting(lambda: switch(drives, at, True), lambda: switch(drives, at, False))

    return prepare


def _changing(change: Callable[[DriveControls, int, int], int]) -> Prepare:
    """Return a row's `prepare` that changes a number of a drive, and restores it at the end."""

    def prepare(bench: FaultBench, request: FaultRequest) -> Begin:
        drives, at = _drives(bench), motor_of(bench, request.words[0])
        value = whole(request.words[1])

        def begin() -> Running:
            before = change(drives, at, value)
            return Running(lambda: change(drives, at, before))

        return begin

    return prepare


def reset_drive(bench: FaultBench, request: FaultRequest) -> Begin:
    """Restart a drive's firmware."""
    drives, at = _drives(bench), motor_of(bench, request.words[0])
    return lambda: drives.reset(at)


def ailing_drive(bench: FaultBench, request: FaultRequest) -> Begin:
    """Give a drive a fault of its own for a while; afterwards it must be reset."""
    drives, at = _emergencies(bench), motor_of(bench, request.words[0])
    code = _code(request.words[1])
    return lasting(lambda: drives.ail(at, code), lambda: drives.mend(at, code))


def warning_drive(bench: FaultBench, request: FaultRequest) -> Begin:
    """Make a drive send an EMCY message and carry on."""
    drives, at = _emergencies(bench), motor_of(bench, request.words[0])
    code = _code(request.words[1])
    return lambda: drives.warn(at, code)


def _emergencies(bench: FaultBench) -> DriveErrors:
    board = bench.device.board
    if not isinstance(board, SaysEmergencies):
        raise lacks(board, "error codes of its own")
    return board.errors()


def _code(word: str) -> int:
    if not _CODE.fullmatch(word) or int(word, 16) < FIRST_ERROR:
        raise BadRequest(f"an error code is four hex digits from 0100 on, 4310 say, not {word!r}")
    return int(word, 16)


def _drives(bench: FaultBench) -> DriveControls:
    board = bench.device.board
    if not isinstance(board, DrivesOnBus):
        raise lacks(board, "drives on a bus")
    return board.drives


# --- The table: name, arguments, what goes wrong -------------------------------------------------
# Each row checks its arguments when the fault is requested, and returns the function that begins
# it. A muted drive still receives and obeys. A changed id or mode counts as set with the drive's
# own keys; the id may be that of another drive.

AMOUNT = "P|#N|next"
"""How much: each byte with a probability, the n-th byte from now, or all of the next message.

For frames: each with a probability, the one with the n-th byte from now, or the next.
"""
_ON_BUS = tuple(
    replace(kind, needs=DrivesOnBus)
    for kind in (
        FaultKind("lose-frame", AMOUNT, "frames are lost", on_wire(lambda _: frame_lost)),
        FaultKind("double-frame", AMOUNT, "frames arrive twice", on_wire(lambda _: frame_doubled)),
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
            _on_drive(lambda drives, at, on: drives.mute(at, on)),
        ),
        FaultKind(
            "drive-dead",
            "MOTOR",
            "a drive has no supply",
            _on_drive(lambda drives, at, on: drives.power(at, not on)),
        ),
        FaultKind("drive-reset", "MOTOR", "a drive restarts", reset_drive),
        FaultKind(
            "drive-mode",
            "MOTOR MODE",
            "a drive is in another mode",
            _changing(lambda drives, at, mode: drives.set_mode(at, mode)),
            replaces=True,
        ),
        FaultKind(
            "drive-id",
            "MOTOR ID",
            "a drive has another id",
            _changing(lambda drives, at, node: drives.set_id(at, node)),
            replaces=True,
        ),
        FaultKind(
            "no-done",
            "MOTOR",
            "a drive does not report the end of a motion",
            _on_drive(lambda drives, at, on: drives.withhold_done(at, on)),
        ),
    )
)
"""Faults that only drives on a CAN bus can have."""
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
"""Faults of drives that have error codes."""
_ON_ANY = (
    FaultKind("drop", AMOUNT, "bytes are lost", on_wire(lambda _: lost)),
    FaultKind(
        "corrupt",
        AMOUNT,
        "bytes have a bit flipped",
        on_wire(lambda request: changed(draw(request, 2))),
    ),
    FaultKind("duplicate", AMOUNT, "bytes arrive twice", on_wire(lambda _: repeated)),
    FaultKind("delay", f"SECONDS [{AMOUNT}]", "messages are late", on_wire(delaying, 1, "1")),
    FaultKind("mute", "", "the device sends nothing", mute),
    FaultKind("garbage", "[COUNT]", "the device sends noise (8 bytes)", garbage),
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
        "switch", "MOTOR open|closed|free", "a limit switch sticks", switch, needs=HasSwitches
    ),
)
FAULTS: Mapping[str, FaultKind] = MappingProxyType(
    {kind.name: kind for kind in (*_ON_ANY, *_ON_BUS, *_OF_DRIVES)}
)
"""Every fault by its name. Parsing, help and lists are made from this table."""


def faults_of(board: type[Board]) -> tuple[FaultKind, ...]:
    """Return the faults that a device with this kind of board can have."""
    return tuple(kind for kind in FAULTS.values() if kind.befalls(board))


def fault_kind(name: str) -> FaultKind:
    """Return a row of the table. Raises `BadRequest` with the nearest name."""
    if name in FAULTS:
        return FAULTS[name]
    hint = did_you_mean(name, FAULTS, f"there are {', '.join(FAULTS)}", likeness=0.4)
    raise BadRequest(f"there is no fault {name!r}; {hint}")


# --- The faults that are under way on one simulated arm, begun and ended on its clock ------------
# The same on an in-process wire, a pseudo-terminal and a socket.


@dataclass(frozen=True, slots=True, eq=False)
class _Active:
    request: FaultRequest
    running: Running


def link_cable(link: MemoryLink[PacedDevice]) -> Cable:
    """Return the cable of an in-process wire."""
    return Cable(link.line, link.unplug, link.replug)


@checked_calls({**BASIC, "FaultRequest": made_of(FaultRequest, "a fault that was asked for")})
class Faults:
    """The faults of one device. Call it from the thread that owns the device, or under its lock."""

    def __init__(self, device: SimDevice, line: PacedDevice, cable: Cable) -> None:
        self._bench = FaultBench(device, line, cable)
        self._active: list[_Active] = []
        self.troubles: list[str] = []
        """Faults that could not begin when their time came; reading the list clears it."""

    @property
    def active(self) -> tuple[str, ...]:
        """The faults in effect, as they were requested."""
        return tuple(each.request.text for each in self._active if each.running.alive())

    def add(
        self,
        name: str,
        *arguments: object,
        side: str = "both",
        seed: int = 0,
        after_s: float = 0.0,
        for_s: float | None = None,
    ) -> None:
        """Add a fault, as in `add("drop", 0.01, side="host")`; see `table.FAULTS`.

        `after_s` counts from the device's current time. Raises `BadRequest`.
        """
        words = tuple(str(each) for each in arguments)
        self.ask(FaultRequest(name, words, side, seed, after_s, for_s))

    def ask(self, request: FaultRequest) -> None:
        """Add a fault parsed from words. Raises `BadRequest` at once if it is invalid."""
        begin, kind = self.checked(request), fault_kind(request.name)
        lasts_s = kind.lasts_s if request.for_s is None else request.for_s

        def start() -> None:
            what = (request.name, request.words[:1])
            for each in [*self._active] if kind.replaces else ():
                if (each.request.name, each.request.words[:1]) == what:
                    self._end(each)
            running = begin()
            if running is None:
                return
            active = _Active(request, running)
            self._active = [*(each for each in self._active if each.running.alive()), active]
            if lasts_s is not None:
                device = self._bench.device
                device.at(device.now_s + lasts_s, lambda: self._later(lambda: self._end(active)))

        if request.after_s:
            device = self._bench.device
            device.at(device.now_s + request.after_s, lambda: self._later(start))
        else:
            start()

    def checked(self, request: FaultRequest) -> Begin:
        """Return the function that would begin a fault, or raise `BadRequest`.

        Nothing happens yet.
        """
        kind = fault_kind(request.name)
        check_count(kind.usage, request.words)
        return kind.prepare(self._bench, request)

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
            if active.running.alive():
                active.running.end()


def check_faults(device: SimDevice, requests: Iterable[FaultRequest]) -> None:
    """Raise `BadRequest` for a fault that this device cannot have.

    Nothing happens to the device.
    """
    link = MemoryLink(PacedDevice(device, None), "simulated arm")
    try:
        faults = Faults(device, link.line, link_cable(link))
        for request in requests:
            faults.checked(request)
    finally:
        link.close()
