"""What the kinematics refuse in a call of an arm: each of these errors is of both packages.

The kinematics know nothing of an arm that is driven, so their errors are no `ArmError`. A program
that drives an arm catches `ArmError` alone, and reads `error.code`; one that catches
`kinematics.Unreachable` goes on to work, since a refusal is that as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import kinematics.errors as mathematics
from armdrive.errors import BadRequest, Refused


class KinematicsError(Refused, mathematics.KinematicsError):
    """The kinematics refuse the call, for what the sentence says."""

    code = "E601"


class BadNumber(BadRequest, mathematics.BadNumber):
    """Text, nothing, NaN or an infinity stands where a number belongs; `name` says where."""

    code = "E602"


class JointLimit(KinematicsError, mathematics.JointLimit):
    """A joint angle outside its range."""

    code = "E603"


class Unreachable(KinematicsError, mathematics.Unreachable):
    """No posture within the limits reaches the pose; `nearest` is one that can be reached."""

    code = "E604"


class PathBroken(KinematicsError, mathematics.PathBroken):
    """A line, an arc or a route leaves the reach, or the arm's posture, on its way."""

    code = "E605"


class NoArc(KinematicsError, mathematics.NoArc):
    """No arc leads through these points."""

    code = "E618"


_REFUSALS: Mapping[type[mathematics.KinematicsError], type[Refused]] = MappingProxyType(
    {
        mathematics.KinematicsError: KinematicsError,
        mathematics.BadNumber: BadNumber,
        mathematics.JointLimit: JointLimit,
        mathematics.Unreachable: Unreachable,
        mathematics.PathBroken: PathBroken,
        mathematics.NoArc: NoArc,
    }
)


def checked_number(name: str, value: object) -> float:
    """Return a finite number; raises the `BadNumber` of an arm that names it."""
    try:
        return mathematics.finite(name, value)
    except mathematics.BadNumber as error:
        raise refusal_of(error) from None


def refusal_of(error: mathematics.KinematicsError) -> Refused:
    """Return the same refusal as an `ArmError`, with all that the error tells."""
    if isinstance(error, Refused):
        return error
    kind = next(_REFUSALS[each] for each in type(error).__mro__ if each in _REFUSALS)
    made = kind.__new__(kind, *error.args)  # not made anew: the sentence is already there
    vars(made).update(vars(error))
    return made.with_traceback(error.__traceback__)
