"""What a dialect can do on a CAN bus without a connected arm: survey its drives and set them up.

A dialect fills in one `BusTools`, the registry's row carries it, and whoever surveys a bus or
commissions drives goes through these rows and names no dialect. What is done on the wire is a
script (`armdrive.dialects.exchange`), what a person is asked a talk (`armdrive.dialog`): nothing
here touches a wire or a clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias, TypeVar

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.dialects.exchange import Received, Script, ScriptIO, ScriptLoop
from armdrive.dialog.conversation import Finding, Talk, note, problem
from armdrive.transports.can_health import BusHealth, BusState
from firmware_protocol.frames import Frame, Unpacker

IDS = tuple(range(1, 17))
"""Asked where nobody says otherwise."""
LISTEN_S = 1.0
"""An arm that is driven is commanded far oftener than that."""

Heard: TypeAlias = Mapping[int, Any]
"""Who was heard while nothing was asked, and what state each said it is in."""


# What is done on the wire, as acts of a talk; and frames as they are, for scripts that read them.

T = TypeVar("T")
Executor: TypeAlias = Controller | ScriptLoop[Any]
"""What carries out one request at a time, without wire or clock."""


@dataclass(frozen=True, slots=True)
class CarryOut:
    """Have a request of a controller carried out, or a script; ends with its reply.

    With `silent_after_s` nothing is said or heard any more from then on for a while, as if this
    program had died. Then it is stopped.
    """

    executor: Executor
    request: Any
    silent_after_s: float = math.inf


@dataclass(frozen=True, slots=True)
class OnWire:
    """Carry out a script that speaks by the wire which it is handed; ends with what it returns."""

    script: Callable[[Any], Script[Any, Any]]


def on_wire(script: Callable[..., Script[Any, T]], *args: object) -> Talk[T]:
    """Carry out a script on the wire, with these arguments behind the wire; return its result."""
    result: T = yield OnWire(lambda wire: script(wire, *args))
    return result


FrameWire: TypeAlias = ScriptIO[Frame]


def frame_scripts() -> ScriptLoop[Frame]:
    """Make what carries out scripts that hear frames."""
    return ScriptLoop(Received(Unpacker().feed), ScriptIO(lambda _frame: None))


# A survey: what passes by itself, and who answers.


@dataclass(frozen=True, slots=True)
class Listened:
    """The frames that passed while nothing was sent, and those that another program put to drives.

    `commands` is empty where nobody else commands drives.
    """

    passing: tuple[Frame, ...] = ()
    commands: tuple[Frame, ...] = ()


def listen(
    wire: FrameWire, is_command: Callable[[Frame], bool], seconds: float = LISTEN_S
) -> Script[Frame, Listened]:
    """Hear what passes by itself, whatever is spoken."""
    frames = yield from wire.collect(seconds)
    return Listened(frames, tuple(filter(is_command, frames)))


@dataclass(frozen=True, slots=True)
class Answers:
    """What came of asking in one protocol: who is there, in words and as plain data.

    `drives` are those that an arm can have: without devices of another kind.
    """

    protocol: str
    asked: tuple[int, ...]
    there: tuple[int, ...] = ()
    drives: tuple[int, ...] = ()
    views: tuple[dict[str, object], ...] = ()
    findings: Callable[[BusHealth, str], list[Finding]] = lambda _health, _arm: []
    of_arm: Callable[[Sequence[int]], list[Finding]] = lambda _ids: []


# Commissioning: one new drive after the other gets its id and settings, and is turned a little.


@dataclass(frozen=True, slots=True)
class DrivePlace:
    """One motor of an arm, by its index and its name, and the id that its drive should have."""

    motor: int
    name: str
    node: int


class DriveAtHand(Protocol):
    """A drive that has come to the bus alone with its id. Whatever writes or turns asks first."""

    @property
    def firmware(self) -> str:
        """Its firmware in its own words; empty where it does not tell."""

    @property
    def keeps_settings(self) -> bool:
        """Whether a drive that was set up before still is, as far as it tells."""

    @property
    def watchdog_s(self) -> float:
        """When it stops by itself once the bus is silent; 0 where it never does."""

    @property
    def by_itself(self) -> ArmConfig:
        """An arm that is this drive alone, and turns its one motor slowly, one step a count."""

    def settle(self) -> Talk[int]:
        """Set it up; return its motor current in mA, 0 where it was left alone."""

    def calibrate(self) -> Talk[bool]:
        """Offer to calibrate its encoder; return whether that is calibrated now."""

    def offer_zero(self) -> Talk[None]:
        """Offer a new zero where it counts too far from its own."""

    def set_watchdog(self, seconds: float) -> Talk[bool]:
        """Have it stop by itself when the bus is silent for so long; return whether it will."""


@dataclass(frozen=True, slots=True)
class CommissioningTools:
    """How one dialect's drives are set up, one at a time.

    `new_id` is the id of every new drive. `arrive` brings a drive to its id: it takes the arm, the
    drive, and whether the arm has other drives, and returns None where the person leaves the drive
    out. `alone` finds out whether one drive, and no more, answers to an id: it takes the wire.
    `section` gives what the arm file says of drives with these ids, all of which have this current
    where it is not 0.
    """

    new_id: int
    counts_per_turn: int
    steps: tuple[str, ...]
    caution: str
    arrive: Callable[[ArmConfig, DrivePlace, bool], Talk[DriveAtHand | None]]
    alone: Callable[[Any, int], Script[Any, bool]]
    section: Callable[[Any, Sequence[int], int], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class BusTools:
    """One protocol of a CAN bus, as a survey goes through it. Asking only ever reads.

    `scripts` makes what carries scripts out over the wire to some ids; `ask` is one, and takes that
    wire. `most` is the highest id. `harmless` says that asking does nothing to drives of any other
    protocol, so that it is done first; `leaves_free` is the highest id that can be asked in another
    protocol where nodes of this one are, None where that may be any. `reads_answer` tells what
    cannot be another program's command, and `reads_command` what is one (the second value is the id
    of a master whose heartbeat would be one). `heard` gives who was heard in frames that passed,
    `bit_rates` the rates that such drives have. `connects` tells that connecting to such an arm
    sets nothing, so that its settings may be compared unasked; `next` is the command for drives
    that no arm file has, and `hint` what is said of it to who makes such a file otherwise.
    """

    name: str
    dialect: str
    most: int
    scripts: Callable[[Sequence[int]], ScriptLoop[Any]]
    ask: Callable[[Any, Sequence[int], Heard], Script[Any, Answers]]
    reads_command: Callable[[Frame, int | None], bool]
    reads_answer: Callable[[Frame], bool] = lambda _frame: False
    heard: Callable[[Iterable[Frame]], Heard] = field(default=lambda _frames: {})
    harmless: bool = False
    leaves_free: int | None = None
    bit_rates: tuple[int, ...] = ()
    connects: bool = False
    next: str = ""
    hint: str = ""
    commissioning: CommissioningTools | None = None


# What is said of a bus whatever its drives speak.
#
# A wrong bit rate, a bus without nodes and an open wire look alike from one end: then all of them
# are named, with what tells them apart.

RESISTORS = (
    "with the supply off measure between CAN H and L: 60 ohm are right, 120 mean that one of the "
    "two resistors at the ends is missing, open circuit that both are"
)
NOBODY = (
    "see that the drives have their motor supply, that H and L are not swapped, and the bit rate "
    "(CanRate in the menu of an MKS drive): `armdrive doctor --can --every-rate` tries all four"
)
SOME = 2
"""So many answers may be late on a computer that is busy."""


def of_lost(missed: int, garbled: int, health: BusHealth) -> list[Finding]:
    """Say what was lost or broken between questions and answers, and what does that."""
    what = (
        f"{missed} answers came only after a second question, {garbled} frames could not be "
        f"read, {health.error_frames} error frames were seen"
    )
    wiring = f"a resistor that is missing, a loose plug or a long stub do that: {RESISTORS}"
    if missed > SOME or garbled or health.error_frames:
        return [problem(what, wiring)]
    return [note(what, f"a busy computer does that too; if it stays, {wiring}")] if missed else []


def of_nobody(asked: Sequence[int], health: BusHealth) -> Finding:
    """Say why perhaps nobody answered."""
    what = f"nobody answers of the ids {numbers(asked)}"
    passive = health.state in (BusState.PASSIVE, BusState.OFF)
    if health.refused or passive:
        return problem(
            f"{what}, and nobody acknowledges what is sent: no node is there that hears this bit "
            "rate",
            NOBODY,
        )
    if health.error_frames:
        return problem(f"{what}, and the bus has errors: somebody has another bit rate", NOBODY)
    return problem(
        f"{what}, though the adapter took every frame: there is a node without these ids, or none "
        "at all (the first firmwares of the CANable do not tell)",
        f"ask more ids with --ids 1-127; {NOBODY}",
    )


def numbers(ids: Sequence[int]) -> str:
    """Write ids: a run of them as its ends."""
    numbers = sorted(ids)
    if len(numbers) > 2 and numbers == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers)) or "none"
