"""The errors of the kinematics. Each names the quantity, its value and what to do.

KinematicsError            base class
+-- BadNumber              not a finite number where one belongs
+-- JointLimit             a joint angle outside its range
+-- Unreachable            a pose no posture can reach (in `geometry`)
+-- PathBroken             a path leaves the reach, or would change the posture (in `geometry`)
+-- NoArc                  three points that lie in a line, or are fewer than three
+-- SingularTransmission   motors that do not determine the joint angles
+-- UnknownPreset          no preset arm has that key
+-- UnknownSystem          no system of the textbook has that name
+-- OutOfReach             a goal that no posture of a named system meets
+-- ZeroVector             the zero vector where a direction is needed
+-- NotARotation           a matrix that is not a rotation: which property fails, and by how much
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from kinematics.text import beyond, joint_text, shown_name

RaisedError = TypeVar("RaisedError", bound=BaseException)


def remade(
    kind: type[RaisedError], words: tuple[object, ...], further: Mapping[str, object]
) -> RaisedError:
    """Return an error with this message and these attributes, as a copy or another process needs.

    `__init__` is not called: many errors write their message there.
    """
    made = kind.__new__(kind, *words)
    vars(made).update(further)
    return made


class KinematicsError(ValueError):
    """Base class of the kinematics' errors."""

    def __reduce__(self) -> tuple[Any, ...]:
        return remade, (type(self), self.args, vars(self))


class BadNumber(KinematicsError):
    """A value that is not a finite number, or an angle of many turns; `name` says which one."""

    def __init__(self, name: str, value: object, rule: str = "must be a finite number") -> None:
        self.name = name
        self.value = value
        super().__init__(f"{name} {rule}, not {value!r:.80}")


class JointLimit(KinematicsError):
    """A joint angle outside its range; angles in rad."""

    def __init__(self, joint: str, value_rad: float, bound_rad: float) -> None:
        self.joint = joint
        self.value_rad = value_rad
        self.bound_rad = bound_rad
        self.excess_rad = abs(value_rad - bound_rad)
        super().__init__(limit_sentence(joint, value_rad, bound_rad))


class NoArc(KinematicsError):
    """Three points that determine no circle.

    `off_mm` is the distance of two of them that are the same point, else how far the three are
    from lying in a line; `part` the number, from 1, of the part of a route, or None.
    """

    def __init__(self, reason: str, remedy: str, off_mm: float, *, part: int | None = None) -> None:
        self.reason = reason
        self.remedy = remedy
        self.off_mm = off_mm
        self.part = part
        where = f" of part {part} of the route" if part is not None else ""
        super().__init__(f"no arc leads through the points{where}: {reason}; {remedy}")

    def of_part(self, number: int) -> NoArc:
        """Return the same refusal with the number of the part of a route that it is about."""
        return NoArc(self.reason, self.remedy, self.off_mm, part=number)


class SingularTransmission(KinematicsError):
    """Motors whose readings do not determine the joints; `motor` is the row that adds nothing."""

    def __init__(self, motor: str) -> None:
        self.motor = motor
        super().__init__(
            f"the steps of motor {motor!r} follow from those of the other motors, so joint angles "
            "cannot be computed from steps; check what it sees and its steps per unit"
        )


class _UnknownName(KinematicsError):
    """No item of a kind has this name; `nearest` is the most similar known name, or None."""

    kind = ""

    def __init__(self, name: str, names: Iterable[str]) -> None:
        self.name, self.nearest = name, nearest_word(str(name), names)
        hint = f"; did you mean {self.nearest!r}?" if self.nearest else ""
        super().__init__(f"no {self.kind} is named {name!r}{hint} (there are {', '.join(names)})")


class UnknownPreset(_UnknownName):
    """No preset arm has this name."""

    kind = "preset arm"


class UnknownSystem(_UnknownName):
    """No system of the textbook has this name."""

    kind = "system"


class ZeroVector(KinematicsError):
    """The zero vector where a direction is needed."""

    def __init__(self) -> None:
        super().__init__("the zero vector has no direction; give one with some length")


class NotARotation(KinematicsError):
    """A matrix that is no rotation; `flaws` says which properties fail, and by how much."""

    def __init__(self, flaws: tuple[str, ...]) -> None:
        self.flaws = flaws
        super().__init__(f"not a rotation: {'; '.join(flaws)}")


class OutOfReach(KinematicsError):
    """A goal that no posture of a named system reaches, even without joint limits.

    `nearest` is a goal that can be met, in the system's own `coordinates`, `away_mm` from it.
    """

    def __init__(
        self,
        system: str,
        away_mm: float,
        coordinates: tuple[str, ...],
        nearest: tuple[float, ...],
    ) -> None:
        self.system = system
        self.away_mm = away_mm
        self.coordinates = coordinates
        self.nearest = nearest
        instead = ", ".join(
            f"{name} {number:.6g}" for name, number in zip(coordinates, nearest, strict=True)
        )
        super().__init__(
            f"{system} cannot reach this goal, only to {away_mm:.3g} mm from it; a goal that it "
            f"reaches: {instead}"
        )


def limit_sentence(joint: str, value: float, bound: float, unit: str = "rad") -> str:
    """Say by how much a joint would pass its limit: in degrees, or of a sliding joint in mm."""
    name, at = shown_name(joint), joint_text(value, unit)
    return f"the {name} would have to be at {at}, {beyond(value, bound, unit)}"


def finite(name: str, value: object) -> float:
    """Return `value` as a float, or raise `BadNumber` that names it.

    Text, None, booleans, NaN and infinities are refused: none of them is a length or an angle.
    """
    if type(value) is float and value - value == 0.0:
        return value  # the usual case comes first, because every value type checks many numbers
    if isinstance(value, bool | str | bytes):
        raise BadNumber(name, value)
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise BadNumber(name, value) from None
    if number - number != 0.0:  # NaN and both infinities differ from themselves
        raise BadNumber(name, value)
    return number


# Two turns: no pose needs more, and most angles in degrees exceed them.
MOST_TURN_RAD = 4.0 * math.pi


def hand_angle(name: str, value: object, in_degrees: str = "") -> float:
    """Return an angle of a goal in rad, or raise `BadNumber` if it exceeds two turns.

    The value is in degrees if its name ends in `_deg`, else in rad. Such an angle in rad is
    probably in degrees: the message says how to write it. `in_degrees` is that hint for goals other
    than poses.
    """
    given = finite(name, value)
    stem, _, unit = name.rpartition("_")
    angle = math.radians(given) if unit == "deg" else given
    if -MOST_TURN_RAD <= angle <= MOST_TURN_RAD:
        return angle
    if unit == "deg":
        most = f"{math.degrees(MOST_TURN_RAD):.0f}° either way"
    else:
        in_degrees = in_degrees or f"Pose.of({stem}_deg=...)"
        most = f"{MOST_TURN_RAD:.2f} rad either way (degrees: {in_degrees})"
    raise BadNumber(name, value, f"must be within two turns, {most}")


def positive(name: str, value: float, *, endless: bool = False) -> float:
    """Return a number above zero, or raise `KinematicsError` or `BadNumber`.

    It is finite, unless it may be `endless`.
    """
    number = value if endless and value == math.inf else finite(name, value)
    if number <= 0.0:
        raise KinematicsError(f"{name} must be more than 0, not {number}")
    return number


def not_negative(name: str, value: object) -> float:
    """Return a finite number of zero or more, or raise `KinematicsError` or `BadNumber`."""
    number = finite(name, value)
    if number < 0.0:
        raise KinematicsError(f"{name} must not be less than 0, not {number}")
    return number


def check_fields(value: object, check: Callable[[str, Any], object], *names: str) -> None:
    """Replace some fields of a frozen value by what their check returns."""
    for name in names:
        object.__setattr__(value, name, check(name, getattr(value, name)))


def require(name: str, value: object, kind: type, example: str) -> None:
    """Raise `KinematicsError` for a value of another class; the message gives an example."""
    if not isinstance(value, kind):
        raise KinematicsError(
            f"{name} must be of the class {kind.__name__}, not {value!r}; for example {example}"
        )


# Suggestions for misspelt words. difflib is imported at the first mistake, because most programs
# make none and it would slow down every start.


# The least similarity of words that counts, as difflib's ratio measures it, 0 to 1.
LIKENESS = 0.6


def nearest_word(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that begins with this one, or is most similar to it, or None.

    Upper and lower case are the same. Of equally similar words it is the first.
    """
    from difflib import SequenceMatcher

    typed = word.lower()

    def likeness(other: str) -> float:
        begins = bool(typed) and other.lower().startswith(typed)
        return SequenceMatcher(None, other.lower(), typed).ratio() + begins

    near = max(known, key=likeness, default="")
    return near if near and likeness(near) >= LIKENESS else None


def did_you_mean(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return "did you mean 'word'?", or `otherwise` if no known word is similar."""
    near = nearest_word(word, known)
    return otherwise if near is None else f"did you mean {near!r}?"


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return the same question as the end of a sentence, or an empty string.

    If only the unit of a word is wrong, the sentence says that the value has to change too.
    """
    known = tuple(known)
    stem, _, unit = word.rpartition("_")
    for right, to in _ANGLE_UNITS.items():
        if unit in _ANGLE_UNITS and unit != right and f"{stem}_{right}" in known:
            return f"; write {stem}_{right}=math.{to}(...)"
    asked = did_you_mean(word, known)
    return f"; {asked}" if asked else ""


# The units of angles, and the function of `math` that converts the other one to each.
_ANGLE_UNITS = {"deg": "degrees", "rad": "radians"}
