"""What a dialect can do on a CAN bus without a connected arm: survey its drives and set them up.

A dialect fills in one `BusTools`, the registry's row carries it, and whoever surveys a bus or
commissions drives goes through these rows and names no dialect. Everything here is a talk
(`armdrive.dialog.conversation`): it touches neither wire nor clock.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeAlias

from armdrive.dialog.conversation import Finding, Hear, Talk, note, problem
from armdrive.transports.can_health import BusHealth, BusState
from firmware_protocol.frames import Frame, Unpacker, pack

IDS = tuple(range(1, 17))
"""Asked where nobody says otherwise."""
LISTEN_S = 1.0
"""An arm that is driven is commanded far oftener than that."""

Heard: TypeAlias = Mapping[int, Any]
"""Who was heard while nothing was asked, and what state each said it is in."""


# How requests of a talk become bytes, and bytes become what was heard.


class BusHost(Protocol):
    """The host's end of one protocol, for whoever carries out a talk."""

    def send(self, node: int, request: Any) -> bytes:
        """Return the bytes that put a request to a drive."""

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus."""

    def next_event(self) -> Any | None:
        """Return what was heard, one at a time, then None. A frame of nobody's is a `Frame`."""

    def answers(self, event: Any, request: Any) -> bool:
        """Tell whether an event answers a request."""

    def moves(self, request: Any) -> bool:
        """Tell whether a request sets a motor in motion."""

    def stop(self, node: int, request: Any) -> Iterable[bytes]:
        """Return everything that ends a motion that a request began."""

    def settle(self, node: int) -> None:
        """Take note that a drive is known to stand."""


@dataclass(frozen=True, slots=True)
class BusQuestion:
    """A frame as a request, and what is enough of an answer to it."""

    frame: Frame
    enough: Callable[[Frame], bool]


class FrameHost:
    """Questions out, frames in: for a protocol whose talks read the frames themselves."""

    def __init__(self) -> None:
        self._unpacker = Unpacker()
        self._frames: deque[Frame] = deque()

    def send(self, _node: int, request: BusQuestion) -> bytes:
        """Return the frame of a question as bytes."""
        return pack(request.frame)

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus."""
        self._frames.extend(self._unpacker.feed(data))

    def next_event(self) -> Frame | None:
        """Return the next frame, None where no more has come."""
        return self._frames.popleft() if self._frames else None

    def answers(self, event: Frame, request: BusQuestion) -> bool:
        """Tell whether a frame is enough of an answer."""
        return request.enough(event)

    def moves(self, _request: BusQuestion) -> bool:
        """Questions move nothing."""
        return False

    def stop(self, _node: int, _request: BusQuestion) -> Iterable[bytes]:
        """Nothing was set in motion."""
        return ()

    def settle(self, node: int) -> None:
        """Nothing was in motion."""


# A survey: what passes by itself, and who answers.


@dataclass(frozen=True, slots=True)
class Listened:
    """The frames that passed while nothing was sent, and those that another program put to drives.

    `commands` is empty where nobody else commands drives.
    """

    passing: tuple[Frame, ...] = ()
    commands: tuple[Frame, ...] = ()


def listen(is_command: Callable[[Frame], bool], seconds: float = LISTEN_S) -> Talk[Listened]:
    """Hear what passes by itself, whatever is spoken."""
    heard: tuple[object, ...] = yield Hear(seconds)
    frames = tuple(each for each in heard if isinstance(each, Frame))
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


class DrivePlace(Protocol):
    """One motor of an arm, and the id that its drive should have."""

    @property
    def motor(self) -> int:
        """The motor's index."""

    @property
    def name(self) -> str:
        """What the motor is called."""

    @property
    def node(self) -> int:
        """The drive's id."""


@dataclass(frozen=True, slots=True)
class Turned:
    """Where a motor stands, in counts, and why it is not where it should be; empty where it is."""

    counts: int
    trouble: str = ""


class DriveAtHand(Protocol):
    """A drive that has come to the bus alone with its id. Whatever writes or turns asks first."""

    @property
    def firmware(self) -> str:
        """Its firmware in its own words; empty where it does not tell."""

    @property
    def keeps_settings(self) -> bool:
        """Whether a drive that was set up before still is, as far as it tells."""

    def settle(self) -> Talk[int]:
        """Set it up; return its motor current in mA, 0 where it was left alone."""

    def calibrate(self) -> Talk[bool]:
        """Offer to calibrate its encoder; return whether that is calibrated now."""

    def offer_zero(self) -> Talk[None]:
        """Offer a new zero where it counts too far from its own."""

    def switch_on(self) -> Talk[bool]:
        """Have its motor hold; return whether it does."""

    def where(self) -> Talk[int | None]:
        """Read where it stands, in counts."""

    def turn_to(self, target: int, counts: int) -> Talk[Turned]:
        """Turn to a count, as slowly as a motion of so many counts is to be watched."""

    def try_watchdog(self, counts: int) -> Talk[bool | None]:
        """Try by a run of so many counts whether it stops when the bus falls silent.

        None where that was not tried.
        """


@dataclass(frozen=True, slots=True)
class CommissioningTools:
    """How one dialect's drives are set up, one at a time.

    `new_id` is the id of every new drive. `arrive` brings a drive to its id: it takes the arm's
    name, its section of the arm file, the drive, and whether the arm has other drives, and returns
    None where the person leaves the drive out. `alone` tells whether one drive, and no more,
    answers to an id. `section` gives what the arm file says of drives with these ids, all of which
    have this current where it is not 0.
    """

    new_id: int
    counts_per_turn: int
    steps: tuple[str, ...]
    caution: str
    arrive: Callable[[str, Any, DrivePlace, bool], Talk[DriveAtHand | None]]
    alone: Callable[[int], Talk[bool]]
    section: Callable[[Any, Sequence[int], int], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class BusTools:
    """One protocol of a CAN bus, as a survey goes through it. Asking only ever reads.

    `most` is the highest id. `harmless` says that asking does nothing to drives of any other
    protocol, so that it is done first; `leaves_free` is the highest id that can be asked in
    another protocol where nodes of this one are, None where that may be any. `reads_answer` tells
    what cannot be another program's command, and `reads_command` what is one (the second value is
    the id of a master whose heartbeat would be one). `heard` gives who was heard in frames that
    passed, `bit_rates` the rates that such drives have. `connects` tells that connecting to such an
    arm sets nothing, so that its settings may be compared unasked; `next` is the command for drives
    that no arm file has, and `hint` what is said of it to who makes such a file otherwise.
    """

    name: str
    dialect: str
    most: int
    host: Callable[[], BusHost]
    ask: Callable[[Sequence[int], Heard], Talk[Answers]]
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
