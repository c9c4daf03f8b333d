"""Every error that a person can meet, with the exit code of the command line.

    ArmError                      1   root: something is wrong, and the message says what to do
    +-- Refused                   3   nothing was sent, nothing moved
    |   +-- BadRequest            2   a word or number of the call itself is wrong
    |   |   +-- UnknownPoint      2   no point has that name
    |   |   +-- BadArgument       2   an argument is of the wrong kind, or there are too many
    |   +-- NotReferenced         3   planned motion needs a position that can be trusted
    |   +-- OperatorNeeded        3   a person has to look at the arm first
    |   +-- WrongState            3   not allowed in the present state of the arm
    |   +-- OutOfBounds           3   the motion would violate a limit or a guard
    |   +-- SettingsDiffer        3   the device is set up for another arm
    |   +-- ArmInUse              4   another program is driving the arm
    +-- InputTimeout              1   an input did not change before the timeout
    +-- WaitTimeout               1   a motion took longer than the timeout of the call
    +-- Stopped                   5   a motion was stopped before its goal
    |   +-- PendantStop           5   the STOP key of the pendant
    +-- DeviceFault               6   the controller refused, or gave an unexpected answer
    |   +-- NoAnswer              6   the timeout passed without an answer
    |   +-- PositionMismatch      6   the read-back differs from the commanded position
    |   +-- ProgramHalfWritten    6   the program in the arm's memory is incomplete
    +-- LinkError                 4
    |   +-- PortUnavailable       4   the port cannot be opened
    |   |   +-- NoSuchPort        4   the port does not exist, or no device is behind it
    |   |   +-- PortInUse         4   another program has it
    |   |   +-- PortForbidden     4   the user has no permission
    |   |   +-- NoConnection      4   the host on the network does not answer
    |   +-- LinkLost              4   the connection was lost
    +-- ArmFileError              2   an arm file that cannot be used
    +-- PointsFileError           2   a file of points that cannot be used
    |   +-- PointsChanged         2   another program changed a point after it was read
    +-- PendantFileError          2   a pendant program that cannot be used
    +-- StateFileError            1   a state file that cannot be used
    +-- RecordingError            2   a recording that cannot be used
    +-- ProgramError              2   a program that cannot be read or cannot continue

programs/problems.py defines `ProgramError`. Which file decides what:

    table, catalogue.txt   the code of every error: title, cause, what it does to the arm, remedy
    actions                what a sentence asks a person to do, in the words of each interface
    kinematic              which error of a call a refusal of the kinematics becomes
    arguments              the checks of arguments, by annotation
    printable              what is shown of text that came from elsewhere

A refusal of the kinematics in a call of an arm is a `Refused` too (kinematic.py): an unreachable
goal is both that and a `kinematics.Unreachable`, with exit code 3. table.py says for each
`error.code` what the error does to the arm, and what to do.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from armdrive.errors.printable import as_message
from kinematics.errors import remade

if TYPE_CHECKING:  # every module imports this one, and few need a pose
    from kinematics.spaces import Pose


class ArmError(Exception):
    """Root of armdrive's errors. The message says what is wrong and what to do.

    A message may quote a file or a device; `str` escapes what is not printable.
    """

    exit_code: ClassVar[int] = 1
    code: ClassVar[str] = "E001"
    """The code of this kind of error in the catalogue (`armdrive errors`)."""

    def __str__(self) -> str:
        return as_message(super().__str__())

    @property
    def __notes__(self) -> list[str]:  # type: ignore[override] # `add_note` appends to it
        """What a traceback shows below the message: code, effect on the arm, what to do."""
        from armdrive.errors.table import advice  # read for the few errors that are printed so

        notes: list[str] = vars(self).setdefault("notes", [advice(self)])
        return notes

    def __reduce__(self) -> tuple[Any, ...]:
        return remade, (type(self), self.args, vars(self))


class Refused(ArmError):
    """The call was refused before anything was sent: nothing moved."""

    exit_code = 3
    code = "E201"


class BadRequest(Refused, ValueError):
    """A name or a number in the call is wrong."""

    exit_code = 2
    code = "E101"


class UnknownPoint(BadRequest, KeyError):
    """No point has that name; the message suggests one."""

    code = "E109"

    def __str__(self) -> str:
        return as_message(Exception.__str__(self))  # a KeyError would show the message in quotes


class BadArgument(BadRequest, TypeError):
    """An argument of a call is of the wrong kind, missing or unknown; or an attribute is."""

    code = "E115"


class NotReferenced(Refused):
    """Planned motion needs a trusted position; `home` establishes one."""

    code = "E203"


class OperatorNeeded(Refused):
    """A person has to look at the arm: it has no switches that would find its reference."""

    code = "E204"


class WrongState(Refused):
    """The call is not allowed in the state that the arm is in."""

    code = "E202"


class OutOfBounds(Refused):
    """A point of the motion would violate a joint limit or a guard.

    `name` is the joint or guard, `value` and `bound` are in the unit that the message names.
    `nearest` is None unless the goal itself is at fault and a joint motion reaches an allowed pose
    near it.
    """

    code = "E205"

    def __init__(
        self,
        message: str,
        *,
        name: str,
        value: float,
        bound: float,
        nearest: Pose | None = None,
    ) -> None:
        self.name = name
        self.nearest = nearest
        self.value = value
        self.bound = bound
        super().__init__(message)


class SettingsDiffer(Refused):
    """The device's settings differ from the arm file; the message has the lines that fix them."""

    code = "E206"


class ArmInUse(Refused):
    """Another program is driving the arm."""

    exit_code = 4
    code = "E408"


class HolderError(ArmError):
    """A request for the program that drives an arm failed: none does, or it did not comply."""

    code = "E410"


class InputTimeout(ArmError, TimeoutError):
    """An input did not change before the timeout. Nothing was stopped."""

    code = "E114"


class WaitTimeout(ArmError, TimeoutError):
    """A motion took longer than the timeout of the call; it continues."""

    code = "E106"


class Stopped(ArmError):
    """A motion was stopped before its goal."""

    exit_code = 5
    code = "E301"


class PendantStop(Stopped):
    """The STOP key of the arm's own pendant was pressed."""

    code = "E302"


class DeviceFault(ArmError):
    """The controller refused, or gave an unexpected answer."""

    exit_code = 6
    code = "E501"


class NoAnswer(DeviceFault):
    """The controller did not answer within its timeout."""

    code = "E502"


class PositionMismatch(DeviceFault):
    """The controller's registers differ from the goal of the acknowledged motion."""

    code = "E503"


class ProgramHalfWritten(DeviceFault):
    """A program was not written completely to the arm's own memory, or reads back differently.

    The message names the rows that are in the arm, and those that may be. All others are unchanged.
    """

    code = "E505"


class LinkError(ArmError):
    """Something is wrong with the connection."""

    exit_code = 4
    code = "E401"


class PortUnavailable(LinkError):
    """The port cannot be opened."""

    code = "E402"


class NoSuchPort(PortUnavailable):
    """The port does not exist, or no device is behind it."""

    code = "E403"


class PortInUse(PortUnavailable):
    """Another program has the port."""

    code = "E404"


class PortForbidden(PortUnavailable):
    """The user has no permission to open the port."""

    code = "E405"


class NoConnection(PortUnavailable):
    """The host does not answer at that network port."""

    code = "E406"


class LinkLost(LinkError):
    """The connection was lost: cable pulled, adapter gone, simulated device ended."""

    code = "E407"


class ArmFileError(ArmError):
    """An arm file that cannot be used; the message names the key."""

    exit_code = 2
    code = "E104"


class PointsFileError(ArmError):
    """A file of points that cannot be used; the message names the key."""

    exit_code = 2
    code = "E108"


class PointsChanged(PointsFileError):
    """Another program changed a point after it was read: nothing was written."""

    code = "E110"


class PendantFileError(ArmError):
    """A pendant program that cannot be used; the message names the line."""

    exit_code = 2
    code = "E112"


class StateFileError(ArmError):
    """A saved state that cannot be used; the message says why."""

    code = "E105"


class RecordingError(ArmError):
    """A recording that cannot be used; the message says which line and why."""

    exit_code = 2
    code = "E107"
