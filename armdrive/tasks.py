"""Work in progress: a generator that yields what it waits for, and what has become of it.

A task's body yields what it waits for, an `Exchange` or a `SleepUntil`, and is resumed with the
reply or the time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Generic, TypeVar

from armdrive.errors import ArmError, LinkLost
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class _PlainRequest:
    """A request whose name says all of it."""


# What the driver asks of a controller that keeps a program of its own, and what it hears.


class ReadProgram(_PlainRequest):
    """Ask for the program that the device keeps by itself. Never moves anything."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class WriteRow:
    """Write one row of the device's own program, in the device's words. Moves nothing."""

    words: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class DeviceProgram:
    """The device's own program, row by row in its own words, as the device told it."""

    rows: tuple[tuple[int, ...], ...]

    def __str__(self) -> str:
        return f"a program of {len(self.rows)} rows"


# What a look at the settings of a device found: its firmware, and what is not as expected.


@dataclass(frozen=True, slots=True)
class Difference:
    """A setting of the device that is not what the arm file expects, and the line that mends it.

    `must` says that nothing may move before it is mended.
    """

    setting: str
    found: str
    expected: str
    mend: str
    must: bool = True

    def __str__(self) -> str:
        return f"{self.setting} is {self.found}, expected {self.expected}: send `{self.mend}`"


@dataclass(frozen=True, slots=True)
class DeviceSettings:
    """What `ReadSettings` found; no differences where the dialect has no settings to compare."""

    differences: tuple[Difference, ...] = ()
    firmware: str = ""

    def __str__(self) -> str:
        return "; ".join(map(str, self.differences)) or "the settings are as expected"


# What the driver asks of any controller and what it hears back, in motor steps and seconds.
#
# Requests and replies name no dialect. Registers are the controller's own counts; the driver adds
# its reference offset (runtime/position.py). A request is answered with exactly one `Reply`,
# however many messages that takes on the wire; an `Alert` may come at any time, asked or not.

# -- what is asked ------------------------------------------------------------------------------


def never() -> bool:
    """Tell that nobody lets go, and that nothing is held back."""
    return False


@dataclass(frozen=True, slots=True)
class MoveBy:
    """Move all motors together; the busiest one at `rate_hz` steps a second or slower.

    A device that needs messages before the one that sets motors going gives up, and answers
    `Halted`, where `let_go()` has become true by then.
    """

    steps: Motors
    rate_hz: float
    let_go: Callable[[], bool] = field(default=never, compare=False, repr=False)

    @property
    def duration_s(self) -> float:
        """How long it takes at that rate, without any ramp."""
        return self.steps.largest / self.rate_hz if self.steps.largest else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MoveAlong:
    """Move along segments that the device queues, never more than `ahead_s` of them ahead.

    `segments` is drawn from only when there is room for one more, so that what a jog does next is
    decided at the last moment. As soon as `let_go()` is true, what is queued is given up as well.
    While `held_back()` is true, nothing is drawn, and what was drawn is not sent any more; where it
    is so until all that was sent is driven, the answer is `Done` and tells what is `unsent`.
    For a jog, the device's own way of jogging is used where it has one. The answer is `Done` when
    everything has been driven, `Halted` when some of it was given up.
    """

    segments: Iterator[MoveBy]
    ahead_s: float
    jog: bool = False
    let_go: Callable[[], bool] = never
    held_back: Callable[[], bool] = never


class ReadPosition(_PlainRequest):
    """Ask for the position registers and the inputs. Never moves anything."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class SetOutputs:
    """Write the output bits. Never moves anything."""

    bits: int


@dataclass(frozen=True, slots=True)
class SetGripper:
    """Bring a gripper that is no stepper to a share of its range: 0 is closed, 1 is open."""

    share: float


class DropCurrent(_PlainRequest):
    """Switch the motor current off: the arm can sag. Sent by an explicit `disable` alone."""

    __slots__ = ()


class SwitchOn(_PlainRequest):
    """Switch the motor current on: the arm is held where it stands. Moves nothing."""

    __slots__ = ()


class ClearFault(_PlainRequest):
    """Leave the device's own state of alarm, if it has one. Moves nothing."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class HomeDevice:
    """Run the device's own homing, of all axes or of groups of them one after another."""

    groups: tuple[tuple[int, ...], ...] = ()


class ReadSettings(_PlainRequest):
    """Read the device's settings and compare them with what the arm file expects."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class MendSetting:
    """Write one line that mends a setting. Sent when a person has asked for it."""

    line: str


Request = (
    MoveBy | MoveAlong | ReadPosition | SetOutputs | SetGripper | DropCurrent | SwitchOn
    | ClearFault | HomeDevice | ReadSettings | MendSetting | ReadProgram | WriteRow
)  # fmt: skip

# -- what is answered ---------------------------------------------------------------------------

SWITCHED_ON = "Check that the arm is switched on and its cable plugged in"


@dataclass(frozen=True, slots=True)
class Done:
    """The request was carried out, and the motion has ended.

    `timely` is False where the answer's time is hard to believe: one far too early may belong to
    another request, one far too late may be that of another motion. The registers are to be
    looked at then. `unsent` is how many segments were drawn last and held back, 0 or 1.
    """

    timely: bool = True
    unsent: int = 0

    def __str__(self) -> str:
        return "done"


@dataclass(frozen=True, slots=True)
class Halted:
    """A stop from here ended the motion part of the way.

    `kept` is False where the device stopped dead, so that motors may have lost steps. A device may
    come to rest `beyond` its target, by so many steps of a motor.
    """

    kept: bool = True
    beyond: int = 0

    def __str__(self) -> str:
        return "halted"


@dataclass(frozen=True, slots=True)
class Interrupted:
    """The operator's own stop (a pendant key) ended the motion part of the way."""

    def __str__(self) -> str:
        return "stopped at the pendant"


@dataclass(frozen=True, slots=True)
class RequestRejected:
    """The controller understood nothing, or refused; `reason` says why where that is known.

    `moved` is False where it is certain that nothing of the request was carried out. `silent`
    where nobody refused anything, but a part of the device fell silent in the middle of it.
    """

    reason: str = ""
    moved: bool = True
    silent: bool = False

    def __str__(self) -> str:
        return f"refused: {self.reason}" if self.reason else "refused"


@dataclass(frozen=True, slots=True)
class Timeout:
    """No answer, and none is waited for any longer. `look_at` is what a person does about it."""

    to: str
    waited_s: float
    look_at: str = field(default=SWITCHED_ON, compare=False, repr=False)

    def __str__(self) -> str:
        return f"no answer to `{self.to}` within {self.waited_s:.1f} s"


@dataclass(frozen=True, slots=True)
class Registers:
    """The controller's position counts, in its own origin, and its input bits.

    `held` says whether all motors have current, or none has; None where it does not tell.
    """

    positions: Motors
    inputs: int = 0
    gripping: bool = False
    key: str = "NONE"
    held: bool | None = field(default=None, compare=False)

    def __str__(self) -> str:
        pressed = f", key {self.key}" if self.key != NO_KEY else ""
        return f"registers {' '.join(map(str, self.positions))}, inputs {self.inputs}{pressed}"


NO_KEY = "NONE"
"""What `Registers.key` says while no key has been pressed."""


Reply = (
    Done
    | Halted
    | Interrupted
    | RequestRejected
    | Timeout
    | Registers
    | DeviceSettings
    | DeviceProgram
)

# -- what nobody asked --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ProtocolWarning:
    """Something on the wire that answers nothing: garbage, a line nobody asked for."""

    text: str


@dataclass(frozen=True, slots=True)
class Progress:
    """Where the motors are while they move, as the device reports it."""

    registers: Registers


class AlertKind(Enum):
    """What an unasked message of the device means for the arm."""

    RESTARTED = "the controller was reset or lost its power"
    ALARM = "the controller is in alarm"
    ALARM_LOST = "the controller is in alarm, and its position is lost"
    SWITCHED_OFF = "the controller switched the motors off"
    ASTRAY = "the arm is not on the path that was sent"


@dataclass(frozen=True, slots=True)
class Alert:
    """A message that ends trust or motion, whenever it comes; `text` says what and what to do."""

    kind: AlertKind
    text: str


Event = Reply | ProtocolWarning | Progress | Alert

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Exchange:
    """Wait for the answer to a request."""

    request: Request


@dataclass(frozen=True, slots=True)
class SleepUntil:
    """Wait until a time, or until somebody asks for a stop."""

    time_s: float


TaskBody = Generator[Exchange | SleepUntil, Any, T]
"""Work in progress; an `Exchange` is answered with a `Reply`, an `SleepUntil` with the time."""


class Task(Generic[T]):
    """A task that was handed to the engine, and what became of it."""

    def __init__(
        self, body: TaskBody[T], *, routine: bool = False, within_s: float = math.inf
    ) -> None:
        """`routine` marks what the engine does by itself in quiet times.

        `within_s` is how long the task may take. The engine ends it then, whatever the wire says.
        """
        self.body = body
        self.routine = routine
        self.within_s = within_s
        self.since_s = math.nan
        """When its time began to count; the engine sets it."""
        self.started = False
        self.over = False
        """Whether the task has ended."""
        self.done = False
        """Whether the engine has let go of it: whoever waits for it may go on."""
        self.value: T | None = None
        self.error: BaseException | None = None

    @property
    def until_s(self) -> float:
        """When its time is over; infinity while it has not begun to count."""
        return math.inf if math.isnan(self.since_s) else self.since_s + self.within_s

    def result(self) -> T:
        """Return what the task returned, or raise what it raised."""
        if self.error is not None:
            raise self.error
        return self.value  # type: ignore[return-value]

    def step(self, outcome: Reply | float | ArmError) -> Exchange | SleepUntil | None:
        """Resume the task; return what it waits for next, None where it is over.

        A loss of the wire is raised, and leaves the task as it is. What else ends the task is
        for its waiter; what no program handles, as Ctrl-C, is raised as well.
        """
        try:
            if isinstance(outcome, ArmError):
                return self.body.throw(outcome)
            value = outcome if self.started else None
            self.started = True
            return self.body.send(value)
        except StopIteration as end:
            self.over, self.value = True, end.value
        except LinkLost:
            raise
        except Exception as error:  # the task's own end: its waiter hears of it
            self.over, self.error = True, error
        except BaseException as error:
            self.over, self.error = True, error
            raise
        return None

    def fail(self, error: ArmError) -> None:
        """End a task that has not begun."""
        self.body.close()
        self.error, self.done = error, True

    def give_up(self, error: ArmError) -> None:
        """End a task that answers the end of its time by waiting for something else."""
        self.body.close()
        self.over, self.error = True, error

    def abandon(self, lost: LinkLost) -> None:
        """Let the task hear of the loss of the wire where it waits, and end it."""
        self.error = lost
        try:
            self.body.throw(lost)
        except Exception as error:  # the task's own words, where it has some
            self.error = error if isinstance(error, ArmError) else lost
        else:  # it wants to wait for something: there is nothing left to wait for
            self.body.close()
