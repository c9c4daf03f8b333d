"""Every error that a person can meet, with the number that the command line ends with.

    ArmError                      1   root: something is wrong, and the sentence says what to do
    +-- Refused                   3   nothing was sent, nothing moved
    |   +-- BadRequest            2   a word or number of the call itself is wrong
    |   |   +-- UnknownPoint      2   no point or sequence has that name
    |   |   +-- BadArgument       2   an argument is of the wrong kind, or there are too many
    |   +-- NotReferenced         3   planned motion needs a position that can be trusted
    |   +-- OperatorNeeded        3   a person has to look at the arm first
    |   +-- WrongState            3   not allowed in the present state of the arm
    |   +-- OutOfBounds           3   a limit or a guard would be passed
    |   +-- SettingsDiffer        3   the device is set up for another arm
    |   +-- ArmInUse              4   another program holds the arm
    +-- InputTimeout              1   an input did not become what was waited for in time
    +-- WaitTimeout               1   a motion had not ended when its wait was given up
    +-- Stopped                   5   a motion ended early because somebody stopped it
    |   +-- PendantStop           5   the STOP key of the pendant
    +-- DeviceFault               6   the controller said no, or something else than expected
    |   +-- NoAnswer              6   the deadline passed without an answer
    |   +-- PositionMismatch      6   the read-back differs from what was commanded
    |   +-- ProgramHalfWritten    6   a program did not come into the arm's memory whole
    +-- LinkError                 4
    |   +-- PortUnavailable       4   the port cannot be opened
    |   |   +-- NoSuchPort        4   there is no such device, or nothing behind it
    |   |   +-- PortInUse         4   another program has it
    |   |   +-- PortForbidden     4   the user may not open it
    |   |   +-- NoConnection      4   nobody answers at the other end of the network
    |   +-- LinkLost              4   the wire broke
    +-- ArmFileError              2   an arm file that cannot be used
    +-- PointsFileError           2   a file of points that cannot be used
    |   +-- PointsChanged         2   somebody else has changed a point meanwhile
    +-- PendantFileError          2   a file of a pendant's program that cannot be used
    +-- StateFileError            1   a state file that cannot be used
    +-- RecordingError            2   a recording that cannot be used
    +-- KeyFileError              2   a file of the desk's keys that cannot be used
    +-- ProgramError              2   a program that cannot be read, or that cannot go on

`ProgramError` stands in programs/problems.py.

What the kinematics refuse in a call of an arm is a `Refused` too (kinematic.py): a goal that
cannot be reached is both that and `kinematics.Unreachable`, and ends with 3. What each means for
the arm and what to do stands in table.py, by `error.code`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from armdrive.errors.printable import as_message

if TYPE_CHECKING:  # every module imports this one, and few need a pose
    from kinematics.spaces import Pose


class ArmError(Exception):
    """Root of armdrive's errors. The message says what was wrong and what to do.

    A message may quote what came from a file or a device, so as text it is always printable.
    """

    exit_code: ClassVar[int] = 1
    code: ClassVar[str] = "E001"
    """The code under which the catalogue (`armdrive errors`) has this kind of error."""

    def __str__(self) -> str:
        return as_message(super().__str__())


class Refused(ArmError):
    """The call was refused before anything was sent: nothing moved."""

    exit_code = 3
    code = "E201"


class BadRequest(Refused, ValueError):
    """A name or a number in the call is wrong."""

    exit_code = 2
    code = "E101"


class UnknownPoint(BadRequest, KeyError):
    """No point, or no sequence, has that name; the message suggests one."""

    code = "E109"

    def __str__(self) -> str:
        return as_message(Exception.__str__(self))  # a KeyError would show the message in quotes


class BadArgument(BadRequest, TypeError):
    """An argument of a call is of the wrong kind, missing, or one that the call does not have."""

    code = "E115"


class NotReferenced(Refused):
    """Planned motion needs a trusted position; `home` gives one."""

    code = "E203"


class OperatorNeeded(Refused):
    """The arm has no switches: a person must confirm its posture before it has a reference."""

    code = "E204"


class WrongState(Refused):
    """The call is not allowed in the state that the arm is in."""

    code = "E202"


class OutOfBounds(Refused):
    """Some point of the motion would pass a joint limit or a guard.

    `name` is the joint or guard, `value` and `bound` are in the unit that the message names, and
    `nearest` is the nearest pose that is allowed, where the goal itself was at fault.
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
    """The device is not set up as the arm file says; the message gives the mending lines."""

    code = "E206"


class ArmInUse(Refused):
    """Another program holds the arm."""

    exit_code = 4
    code = "E408"


class InputTimeout(ArmError, TimeoutError):
    """An input did not become what was waited for before the deadline. Nothing was stopped."""

    code = "E114"


class WaitTimeout(ArmError, TimeoutError):
    """A motion had not ended within the time that the call was ready to wait; it goes on."""

    code = "E106"


class Stopped(ArmError):
    """A motion ended early because somebody stopped it."""

    exit_code = 5
    code = "E301"


class PendantStop(Stopped):
    """The STOP key of the arm's own pendant was pressed."""

    code = "E302"


class DeviceFault(ArmError):
    """The controller answered something else than it should have."""

    exit_code = 6
    code = "E501"


class NoAnswer(DeviceFault):
    """The controller did not answer before the deadline that was computed for it."""

    code = "E502"


class PositionMismatch(DeviceFault):
    """The controller's registers are not where the acknowledged motion should have left them."""

    code = "E503"


class ProgramHalfWritten(DeviceFault):
    """A program was not brought into the arm's own memory whole, or reads otherwise there.

    `written` are the numbers of the rows that are in the arm, `doubtful` of those that may be, or
    read otherwise; the others are as they were before.
    """

    code = "E505"

    def __init__(
        self, message: str, *, written: tuple[int, ...], doubtful: tuple[int, ...]
    ) -> None:
        self.written = written
        self.doubtful = doubtful
        super().__init__(message)


class LinkError(ArmError):
    """Something is wrong with the wire."""

    exit_code = 4
    code = "E401"


class PortUnavailable(LinkError):
    """The port cannot be opened."""

    code = "E402"


class NoSuchPort(PortUnavailable):
    """There is no such device, or nothing behind it."""

    code = "E403"


class PortInUse(PortUnavailable):
    """Another program has the port."""

    code = "E404"


class PortForbidden(PortUnavailable):
    """The user may not open the port."""

    code = "E405"


class NoConnection(PortUnavailable):
    """Nobody answers at that host and port."""

    code = "E406"


class LinkLost(LinkError):
    """The wire broke: cable pulled, adapter gone, simulated device ended."""

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
    """A point or a sequence was changed in the file since it was read: nothing was written."""

    code = "E110"


class PendantFileError(ArmError):
    """A file of a pendant's program that cannot be used; the message names the line."""

    exit_code = 2
    code = "E112"


class StateFileError(ArmError):
    """A saved state that cannot be used; the message says why."""

    code = "E105"


class RecordingError(ArmError):
    """A flight recorder's file that cannot be used; the message says which line and why."""

    exit_code = 2
    code = "E107"


class KeyFileError(ArmError):
    """A file of the desk's keys that cannot be used; the message names the row or the key."""

    exit_code = 2
    code = "E111"
