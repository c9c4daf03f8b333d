"""Tasks of the engine, and the requests and replies that they exchange with a controller.

A task's body is a generator. It yields an `Exchange` or a `SleepUntil`, and the engine resumes it
with the reply or the time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Generic, TypeVar

from armdrive.errors import ArmError, LinkLost
from kinematics.spaces import Motors
from kinematics.text import counted

# Requests and replies about a program in the device's own memory.


@dataclass(frozen=True, slots=True)
class ReadProgram:
    """Read the program in the device's own memory. Moves nothing."""


@dataclass(frozen=True, slots=True)
class WriteRow:
    """Write one row of the device's own program, in its machine words. Moves nothing."""

    words: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class DeviceProgram:
    """The device's own program as it was read: rows of machine words."""

    rows: tuple[tuple[int, ...], ...]

    def __str__(self) -> str:
        return f"a program of {counted(len(self.rows), 'row')}"


# The settings of a device, compared with the arm file.


LISTED = 3  # a new board differs in dozens of settings, and nobody reads them in one sentence


@dataclass(frozen=True, slots=True)
class Difference:
    """A device setting that differs from the arm file, and the line that corrects it, if any does.

    If `must` is true, nothing may move until the setting is corrected. If `homes` is true, the
    device may not home until then.
    """

    setting: str
    found: str
    expected: str
    fix: str
    must: bool = True
    homes: bool = False

    @property
    def forbids(self) -> bool:
        """Whether it keeps the arm from moving or homing."""
        return self.must or self.homes

    def __str__(self) -> str:
        send = f": send `{self.fix}`" if self.fix else ""
        return f"{self.setting} is {self.found}, expected {self.expected}{send}"


def listed(differences: Sequence[Difference]) -> str:
    """Name the first differences, those that forbid something first, and count the rest."""
    first = sorted(differences, key=lambda each: not each.forbids)[:LISTED]
    more = len(differences) - len(first)
    rest = [f"and {more} more, which `armdrive doctor` lists"] if more else []
    return "; ".join([*map(str, first), *rest])


@dataclass(frozen=True, slots=True)
class DeviceSettings:
    """The reply to `ReadSettings`; a dialect without settings reports no differences."""

    differences: tuple[Difference, ...] = ()
    firmware: str = ""

    def __str__(self) -> str:
        return listed(self.differences) or "the settings are as expected"


# Requests to any controller, and its replies, in motor steps and seconds.
#
# Requests and replies are the same for every dialect. Registers are the controller's own counts;
# the driver adds its reference offset (runtime/position.py). Each request gets exactly one `Reply`,
# however many messages it takes on the wire; an `Alert` may arrive at any time.

# -- requests -----------------------------------------------------------------------------------


def never() -> bool:
    """Return False: the default for conditions that never become true."""
    return False


def unreported(_: object) -> None:
    """Ignore a report: the default if no report of progress was requested."""


@dataclass(frozen=True, slots=True)
class MoveBy:
    """Move all motors together, with the busiest one at no more than `rate_hz` steps a second.

    Some devices need other messages before the one that starts the motors. If `released()` becomes
    true before that one is sent, the motion is dropped and the reply is `Halted`.
    """

    steps: Motors
    rate_hz: float
    released: Callable[[], bool] = field(default=never, compare=False, repr=False)

    @property
    def duration_s(self) -> float:
        """The duration at `rate_hz`, without ramps."""
        return self.steps.largest / self.rate_hz if self.steps.largest else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MoveAlong:
    """Move along segments that the device queues, at most `ahead_s` in advance.

    - `segments`: a segment is drawn only when the queue has room for it, so that a jog decides its
      next step at the last moment.
    - `released`: once it is true, the queue is dropped too.
    - `held_back`: while it is true, no segment is drawn or sent, except while drives that brake
      along the path have not come to rest. If the device runs out of segments meanwhile, the reply
      is `Done` with the number of `unsent` segments.
    - `jog`: use the device's own jogging mode if it has one.

    The reply is `Done` after the last segment, or `Halted` if segments were dropped.
    """

    segments: Iterator[MoveBy]
    ahead_s: float
    jog: bool = False
    released: Callable[[], bool] = never
    held_back: Callable[[], bool] = never


@dataclass(frozen=True, slots=True)
class ReadPosition:
    """Read the position registers and the inputs. Moves nothing.

    If the reading comes `midway` through a motion, a drive that has stopped by itself meanwhile is
    not taken back: the motion has to end.
    """

    midway: bool = field(default=False, repr=False)


@dataclass(frozen=True, slots=True)
class SetOutputs:
    """Write the output bits. Moves nothing."""

    bits: int


@dataclass(frozen=True, slots=True)
class SetGripper:
    """Move a servo gripper to a share of its range: 0 is closed, 1 is open."""

    share: float


@dataclass(frozen=True, slots=True)
class DropCurrent:
    """Switch the motor current off: the arm can sag. Only an explicit `disable` sends this."""


@dataclass(frozen=True, slots=True)
class SwitchOn:
    """Switch the motor current on, which holds the arm in place. Moves nothing."""


@dataclass(frozen=True, slots=True)
class ClearFault:
    """Clear the device's own alarm state, if it has one. Moves nothing."""


@dataclass(frozen=True, slots=True)
class HomeDevice:
    """Run the device's own homing, of all axes or of groups of them one after another."""

    groups: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class ReadSettings:
    """Read the device's settings and compare them with what the arm file expects."""


@dataclass(frozen=True, slots=True)
class FixSetting:
    """Write one line that corrects a setting. Sent only on a person's request."""

    line: str


@dataclass(frozen=True, slots=True)
class MeasureUnits:
    """Measure in which units a motor's drive counts speeds and ramps. Motors count from 0.

    The motor turns slowly by at most `steps`, and back.
    """

    motor: int
    steps: int


Request = (
    MoveBy | MoveAlong | ReadPosition | SetOutputs | SetGripper | DropCurrent | SwitchOn
    | ClearFault | HomeDevice | ReadSettings | FixSetting | ReadProgram | WriteRow
    | MeasureUnits
)  # fmt: skip

# -- replies ------------------------------------------------------------------------------------

SWITCHED_ON = "Check that the arm is switched on and its cable plugged in"


@dataclass(frozen=True, slots=True)
class Done:
    """The request was carried out, and the motion has ended.

    `timely` is False if the reply came at an implausible time: a reply that is far too early or far
    too late may belong to a different request, so the caller has to read the registers. `unsent`
    is the number of segments, 0 or 1, that were drawn but held back.
    """

    timely: bool = True
    unsent: int = 0

    def __str__(self) -> str:
        return "done"


@dataclass(frozen=True, slots=True)
class Halted:
    """A stop from the host ended the motion early.

    `kept` is False if the device stopped without a ramp, so that motors may have lost steps.
    `beyond` is the number of motor steps by which the device overshot its target.
    """

    kept: bool = True
    beyond: int = 0

    def __str__(self) -> str:
        return "halted"


@dataclass(frozen=True, slots=True)
class Interrupted:
    """A stop at the pendant ended the motion early."""

    def __str__(self) -> str:
        return "stopped at the pendant"


@dataclass(frozen=True, slots=True)
class RequestRejected:
    """The controller did not understand the request or refused it, for the `reason` if known.

    `moved` is False if certainly no part of the request was carried out. `silent` is True if the
    device did not refuse, but a part of it stopped answering midway.
    """

    reason: str = ""
    moved: bool = True
    silent: bool = False

    def __str__(self) -> str:
        return f"refused: {self.reason}" if self.reason else "refused"


@dataclass(frozen=True, slots=True)
class Timeout:
    """No reply came in time.

    `look_at` says what to check, and `note` what was done meanwhile.
    """

    to: str
    waited_s: float
    look_at: str = field(default=SWITCHED_ON, compare=False, repr=False)
    note: str = ""

    def __str__(self) -> str:
        more = f", {self.note}" if self.note else ""
        to = f" to `{self.to}`" if self.to else ""
        return f"no answer{to} within {self.waited_s:.1f} s{more}"


@dataclass(frozen=True, slots=True)
class Registers:
    """The controller's position counts, relative to its own origin, and its input bits.

    `held` is True if all motors have current, False if none has, and None if the controller does
    not report it.
    """

    positions: Motors
    inputs: int = 0
    gripping: bool = False
    key: str = "NONE"
    held: bool | None = field(default=None, compare=False)

    def __str__(self) -> str:
        pressed = f", key {self.key}" if self.key != NO_KEY else ""
        return f"registers {' '.join(map(str, self.positions))}, inputs {self.inputs}{pressed}"


@dataclass(frozen=True, slots=True)
class MeasuredUnits:
    """The reply to `MeasureUnits`: a unit of speed in steps/s, and one of ramps in steps/s².

    `reported` is whether the drive reports the same by itself.
    """

    speed_hz: float
    ramp_hz_s: float
    reported: bool
    words: str

    def __str__(self) -> str:
        return self.words


NO_KEY = "NONE"  # the value of `Registers.key` while no pendant key has been pressed


Reply = (
    Done
    | Halted
    | Interrupted
    | RequestRejected
    | Timeout
    | Registers
    | DeviceSettings
    | DeviceProgram
    | MeasuredUnits
)

# -- unsolicited messages -----------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ProtocolWarning:
    """Data on the wire that answers no request: noise, or an unexpected line."""

    text: str


@dataclass(frozen=True, slots=True)
class Progress:
    """The motors' position during a motion, as the device reports it."""

    registers: Registers


class AlertKind(Enum):
    """The meaning of an alert for the arm."""

    RESTARTED = "the controller was reset or lost its power"
    ALARM = "the controller is in alarm"
    ALARM_LOST = "the controller is in alarm, and its position is lost"
    SWITCHED_OFF = "the controller switched the motors off"
    OFF_PATH = "the arm is not on the path that was sent"
    LOCKED = "the controller was found locked, and moves nothing until it is reset"


@dataclass(frozen=True, slots=True)
class Alert:
    """A message that ends trust or motion, or says that none is possible.

    `text` says what happened and what to do.
    """

    kind: AlertKind
    text: str


Event = Reply | ProtocolWarning | Progress | Alert

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Exchange:
    """Send a request and wait for its reply."""

    request: Request


@dataclass(frozen=True, slots=True)
class SleepUntil:
    """Wait until a time, or until a stop is requested."""

    time_s: float


# A task's generator; it gets a `Reply` for each `Exchange`, and the time for a `SleepUntil`.
TaskBody = Generator[Exchange | SleepUntil, Any, T]


class Task(Generic[T]):
    """A task of the engine, and its outcome."""

    def __init__(
        self, body: TaskBody[T], *, routine: bool = False, within_s: float = math.inf
    ) -> None:
        """`routine` marks the engine's own tasks, which run while the arm is idle.

        `within_s` is the task's time limit; the engine then ends the task, whatever it waits for.
        """
        self.body = body
        self.routine = routine
        self.within_s = within_s
        self.since_s = math.nan
        """When the time limit began to count; set by the engine."""
        self.started = False
        self.over = False
        """Whether the body has ended."""
        self.done = False
        """Whether the engine has finished with the task, so that its waiters may continue."""
        self.value: T | None = None
        self.error: BaseException | None = None

    @property
    def until_s(self) -> float:
        """When the time limit passes; infinity before it begins to count."""
        return math.inf if math.isnan(self.since_s) else self.since_s + self.within_s

    def result(self) -> T:
        """Return the task's result, or raise its error."""
        if self.error is not None:
            raise self.error
        return self.value  # type: ignore[return-value]

    def step(self, outcome: Reply | float | ArmError) -> Exchange | SleepUntil | None:
        """Resume the task; return what it waits for next, or None once it has ended.

        `LinkLost` is raised here and leaves the task as it is. Other errors end the task and are
        raised by `result`; exceptions such as Ctrl-C are raised here as well.
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
        except Exception as error:  # the task has failed; `result` raises the error
            self.over, self.error = True, error
        except BaseException as error:
            self.over, self.error = True, error
            raise
        return None

    def fail(self, error: ArmError) -> None:
        """End a task that has not started."""
        self.body.close()
        self.error, self.done = error, True

    def give_up(self, error: ArmError) -> None:
        """End a task that still waits for something after its time limit was raised in it."""
        self.body.close()
        self.over, self.error = True, error

    def abandon(self, lost: LinkLost) -> None:
        """Raise the loss of the link in the task, where it waits, and end the task."""
        self.error = lost
        try:
            self.body.throw(lost)
        except Exception as error:  # the task may raise a more specific error
            self.error = error if isinstance(error, ArmError) else lost
        else:  # the task wants to wait, but without a link there is nothing to wait for
            self.body.close()
