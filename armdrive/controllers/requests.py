"""What the driver asks of any controller and what it hears back, in motor steps and seconds.

Requests and replies name no dialect. Registers are the controller's own counts; the driver adds
its reference offset (core.py). A request is answered with exactly one `Reply`, however many
messages that takes on the wire; an `Alert` may come at any time, asked or not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum

from armdrive.controllers.program_requests import Program, ReadProgram, WriteRow
from armdrive.controllers.settings import Settings
from kinematics.spaces import Motors

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


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
class ReadPosition:
    """Ask for the position registers and the inputs. Never moves anything."""


@dataclass(frozen=True, slots=True)
class SetOutputs:
    """Write the output bits. Never moves anything."""

    bits: int


@dataclass(frozen=True, slots=True)
class SetGripper:
    """Bring a gripper that is no stepper to a share of its range: 0 is closed, 1 is open."""

    share: float


@dataclass(frozen=True, slots=True)
class DropCurrent:
    """Switch the motor current off: the arm can sag. Sent by an explicit `disable` alone."""


@dataclass(frozen=True, slots=True)
class SwitchOn:
    """Switch the motor current on: the arm is held where it stands. Moves nothing."""


@dataclass(frozen=True, slots=True)
class ClearFault:
    """Leave the device's own state of alarm, if it has one. Moves nothing."""


@dataclass(frozen=True, slots=True)
class HomeDevice:
    """Run the device's own homing, of all axes or of groups of them one after another."""

    groups: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class ReadSettings:
    """Read the device's settings and compare them with what the arm file expects."""


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
class Denied:
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
class Silence:
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


Reply = Done | Halted | Interrupted | Denied | Silence | Registers | Settings | Program

# -- what nobody asked --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Oddity:
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


Event = Reply | Oddity | Progress | Alert
