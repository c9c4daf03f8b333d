"""A dialect's work on a CAN bus without a connected arm: surveying drives and setting them up.

Each dialect fills in one `BusTools`, which its registry entry carries. Code that surveys a bus or
commissions drives goes through these entries and names no dialect. Work on the wire is a script
(`armdrive.dialects.exchange`), and a `DriveDialog` asks a person. Nothing here
touches a wire or a clock.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.dialects.exchange import Received, Script, ScriptIO, ScriptLoop
from armdrive.dialog import Dialog, Finding, note, ok, problem
from armdrive.tasks import MeasuredUnits
from armdrive.transports.can_health import BusHealth, BusState
from firmware_protocol.frames import Frame, Unpacker
from kinematics.text import counted

# The ids that are asked by default.
IDS = tuple(range(1, 17))
# Any program that drives an arm sends commands far more often than this.
LISTEN_S = 1.0

# The nodes that sent something on their own, and the state each reported.
SeenNodes: TypeAlias = Mapping[int, Any]


# Work on the wire during a dialog, and raw frames for scripts that read them.

T = TypeVar("T")
# Carries out one request at a time, without wire or clock.
Executor: TypeAlias = Controller | ScriptLoop[Any]


# Carries out a controller's request or a script; returns its reply.
CarryOut: TypeAlias = Callable[[Executor, Any], Any]


@dataclass(frozen=True, slots=True)
class DriveDialog(Dialog):
    """A dialog about drives, with the wire to them."""

    scripts: ScriptLoop[Any]
    carry_out: CarryOut

    def on_wire(self, script: Callable[..., Script[Any, T]], *args: object) -> T:
        """Carry out a script with the wire and these arguments; return its result."""
        work = partial(script, self.scripts.io, *args)
        result: T = self.carry_out(self.scripts, work)
        return result


FrameIO: TypeAlias = ScriptIO[Frame]


def frame_scripts() -> ScriptLoop[Frame]:
    """Return a loop for scripts that receive frames."""
    return ScriptLoop(Received(Unpacker().feed), ScriptIO(lambda _frame: None))


# A survey: the traffic on an undisturbed bus, and the nodes that answer.


@dataclass(frozen=True, slots=True)
class Listened:
    """The frames that passed while nothing was sent, and which of them command drives.

    `commands` is empty unless another program drives the arm.
    """

    passing: tuple[Frame, ...] = ()
    commands: tuple[Frame, ...] = ()


def listen(
    io: FrameIO, is_command: Callable[[Frame], bool], seconds: float = LISTEN_S
) -> Script[Frame, Listened]:
    """Listen for a while, whatever the protocol."""
    frames = yield from io.collect(seconds)
    return Listened(frames, tuple(filter(is_command, frames)))


@dataclass(frozen=True, slots=True)
class Answers:
    """The answers in one protocol: the nodes that are there, in words and as plain data.

    `drives` are the nodes that an arm can use, without devices of other kinds.
    """

    protocol: str
    asked: tuple[int, ...]
    there: tuple[int, ...] = ()
    drives: tuple[int, ...] = ()
    views: tuple[dict[str, object], ...] = ()
    findings: Callable[[BusHealth, str], list[Finding]] = lambda _health, _arm: []
    of_arm: Callable[[Sequence[int]], list[Finding]] = lambda _ids: []


class SurveyedNode(Protocol):
    """What a survey knows of any node."""

    @property
    def missed(self) -> int:
        """How many questions had to be repeated."""


S = TypeVar("S", bound=SurveyedNode)


@dataclass(frozen=True, slots=True)
class Survey(Generic[S]):
    """The ids that were asked, the nodes found, and the number of unreadable answers."""

    asked: tuple[int, ...] = ()
    nodes: tuple[S, ...] = ()
    garbled: int = 0

    def answering(self, what: str, there: str, health: BusHealth) -> list[Finding]:
        """Report the ids that answer (`what` they are called), and lost or broken frames."""
        if not there:
            return []
        answer = ok(f"of the {what} {numbers(self.asked)} these answer: {there}")
        return [answer, *of_lost(sum(each.missed for each in self.nodes), self.garbled, health)]


# Commissioning: each new drive gets its id and settings.


@dataclass(frozen=True, slots=True)
class DrivePlace:
    """One motor of an arm by index and name, and the id that its drive should have."""

    motor: int
    name: str
    node: int


@dataclass(frozen=True, slots=True)
class CommissioningTools:
    """How one dialect's drives are set up, one at a time.

    `new_id` is the id of every new drive. `set_up` takes a drive through its steps: it takes the
    dialog, the arm, the drive, and whether a drive that is ready is set up again; it returns the
    motor current in mA, or None if the drive is not ready. `alone` takes the wire and finds out
    whether exactly one drive answers to an id. `section` returns the arm file's section for drives
    with these ids and this current (0: not stated).
    """

    new_id: int
    steps: tuple[str, ...]
    caution: str
    set_up: Callable[[DriveDialog, ArmConfig, DrivePlace, bool], int | None]
    alone: Callable[[Any, int], Script[Any, bool]]
    section: Callable[[Any, Sequence[int], int], Mapping[str, Any]]


# Returns the keys of the arm file's section, from that section and what was measured.
UnitKeys: TypeAlias = Callable[[Any, Sequence[MeasuredUnits]], Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class BusTools:
    """One protocol of a CAN bus, as a survey uses it. Asking only ever reads.

    `scripts` returns a loop for scripts on the wire to some ids; `ask` is such a script. `most` is
    the highest id. `harmless` means that asking does nothing to drives of any other protocol, so it
    comes first. `leaves_free` is the highest id that may be asked in another protocol if nodes of
    this one are present; None for any.

    `reads_command` recognises another program's command (its second argument is the id of a master
    whose heartbeat counts as one), `reads_answer` a frame that cannot be one. `heard` returns the
    nodes that sent some frames. `connects` means that connecting to such an arm sets nothing, so
    its settings may be compared without asking.
    `units` returns what the arm file has to say of measured units; None if they are known anyway.
    `next` is the command for drives that no arm file names; `hint` recommends it to people who
    write the file another way.
    """

    name: str
    dialect: str
    most: int
    scripts: Callable[[Sequence[int]], ScriptLoop[Any]]
    ask: Callable[[Any, Sequence[int], SeenNodes], Script[Any, Answers]]
    reads_command: Callable[[Frame, int | None], bool]
    reads_answer: Callable[[Frame], bool] = lambda _frame: False
    heard: Callable[[Iterable[Frame]], SeenNodes] = field(default=lambda _frames: {})
    harmless: bool = False
    leaves_free: int | None = None
    connects: bool = False
    next: tuple[str, ...] = ()
    hint: str = ""
    commissioning: CommissioningTools | None = None
    units: UnitKeys | None = None


# Findings that do not depend on the protocol.
#
# A wrong bit rate, a bus without nodes and an open wire look alike from one end: such a finding
# names all of them, and how to tell them apart.

RESISTORS = (
    "with the supply off, measure between CAN H and L: 60 ohm is right, 120 ohm means that one of "
    "the two resistors at the ends is missing, an open circuit that both are"
)
NO_ANSWER_REMEDY = (
    "check the drives' motor supply, that H and L are not swapped, and the bit rate "
    "(CanRate in the menu of an MKS drive): write another one into the adapter's address"
)
# Up to this many late answers are normal on a busy computer.
USUAL_LATE_ANSWERS = 2


def of_lost(missed: int, garbled: int, health: BusHealth) -> list[Finding]:
    """Report lost and broken frames, and what causes them."""
    what = (
        f"{counted(missed, 'answer')} came only after a second question, "
        f"{counted(garbled, 'frame was', 'frames were')} unreadable, "
        f"{counted(health.error_frames, 'error frame was', 'error frames were')} seen"
    )
    wiring = f"a missing resistor, a loose plug or a long stub causes that: {RESISTORS}"
    if missed > USUAL_LATE_ANSWERS or garbled or health.error_frames:
        return [problem(what, wiring)]
    return (
        [note(what, f"a busy computer causes that too; if it persists, {wiring}")] if missed else []
    )


def of_nobody(asked: Sequence[int], health: BusHealth) -> Finding:
    """Report that no node answered, and the likely reasons."""
    what = f"no node answers to the ids {numbers(asked)}"
    passive = health.state in (BusState.PASSIVE, BusState.OFF)
    if health.refused or passive:
        return problem(
            f"{what}, and no node acknowledges a frame: none is connected and uses this bit rate",
            NO_ANSWER_REMEDY,
        )
    if health.error_frames:
        return problem(
            f"{what}, and the bus has errors: a node uses another bit rate", NO_ANSWER_REMEDY
        )
    return problem(
        f"{what}, though the adapter took every frame: there is a node with other ids, or none at "
        "all (early CANable firmware does not report that)",
        f"ask for more ids with --ids 1-127; {NO_ANSWER_REMEDY}",
    )


def numbers(ids: Sequence[int]) -> str:
    """Return ids as text, a run of them as `1 to 16`."""
    numbers = sorted(ids)
    if len(numbers) > 2 and numbers == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers)) or "none"
