"""Refusals of the kinematics in a call of an arm: each is an error of both packages.

The kinematics know nothing of driving an arm, so their errors are not `ArmError`s. A program that
drives an arm only has to catch `ArmError`, and reads `error.code`; a program that catches
`kinematics.Unreachable` works too, because a refusal is that as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import kinematics.errors as mathematics
import kinematics.geometry as geometry
from armdrive.errors import BadRequest, Refused


class KinematicsError(Refused, mathematics.KinematicsError):
    """The kinematics refuse the call; the message says why."""

    code = "E601"


class BadNumber(BadRequest, mathematics.BadNumber):
    """Text, None, NaN or infinity instead of a number; `name` says where."""

    code = "E602"


class JointLimit(KinematicsError, mathematics.JointLimit):
    """A joint angle outside its range."""

    code = "E603"


class Unreachable(KinematicsError, geometry.Unreachable):
    """No posture within the limits reaches the pose; `nearest` is one that can be reached."""

    code = "E604"


class PathBroken(KinematicsError, geometry.PathBroken):
    """Along a line, an arc or a route, the arm would leave its reach or change its posture."""

    code = "E605"


class NoArc(KinematicsError, mathematics.NoArc):
    """No arc leads through these points."""

    code = "E618"


_REFUSALS: Mapping[type[mathematics.KinematicsError], type[Refused]] = MappingProxyType(
    {
        mathematics.KinematicsError: KinematicsError,
        mathematics.BadNumber: BadNumber,
        mathematics.JointLimit: JointLimit,
        geometry.Unreachable: Unreachable,
        geometry.PathBroken: PathBroken,
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
    """Return the same refusal as an `ArmError`, with all attributes of the error."""
    if isinstance(error, Refused):
        return error
    kind = next(_REFUSALS[each] for each in type(error).__mro__ if each in _REFUSALS)
    made = mathematics.remade(kind, error.args, vars(error))
    return made.with_traceback(error.__traceback__)
