"""What a record holds, and its text: JSON with a checksum, read back strictly.

Whatever is not exactly what was written is a `StateFileError` that says what is wrong with it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from armdrive.errors import StateFileError
from armdrive.status import Trust
from kinematics.errors import finite
from kinematics.spaces import Motors

FORMAT = 2
"""1 had no checksum."""

LONGEST = 16384
"""Bytes. No record is a tenth as long; what is longer is not even read."""

MOST_MOTORS = 64
STEPS_MOST = 10_000_000_000
"""No motor has ever stood further from its zero; arithmetic with it stays exact."""

COORDINATE_MOST = 1e6
RESTORING = frozenset({Trust.REFERENCED.value, Trust.RESTORED.value})
"""The next program takes up a position that was recorded with one of these."""

_CHECK = "check"
_OPTIONAL = ("taken", "unsure")


@dataclass(frozen=True, slots=True)
class Record:
    """The last known position of one arm: registers plus reference offset, and how trusted.

    Of an arm with backlash, `taken` says where each motor is within it, but assumes that of the
    motors `unsure`, counted from 0. Of others both are empty, and not written.
    """

    arm: str
    calibration: str
    offset: tuple[int, ...]
    registers: tuple[int, ...]
    coordinates: tuple[float, ...]
    trust: str
    reason: str
    in_motion: bool = False
    taken: tuple[int, ...] = ()
    unsure: tuple[int, ...] = ()

    @property
    def would_restore(self) -> bool:
        """Whether the next program would take this for the position if the registers agree."""
        return not self.in_motion and self.trust in RESTORING

    def require_owner(self, arm: str, calibration: str, motors: int) -> None:
        """Raise `StateFileError` unless this was recorded of such an arm."""
        if self.arm != arm:
            raise StateFileError(f"it is of the arm {self.arm}")
        if self.calibration != calibration:
            raise StateFileError("it was made with another calibration")
        if len(self.offset) != motors:
            raise StateFileError("it is of an arm with other motors")


def to_text(record: Record) -> bytes:
    """Return the text of a record."""
    entries = {"format": FORMAT, **asdict(record)}
    for name in _OPTIONAL:
        if not entries[name]:
            del entries[name]
    return json.dumps({**entries, _CHECK: _check(entries)}, indent=1).encode() + b"\n"


def from_text(text: bytes) -> Record:
    """Return the record of a text; raises `StateFileError` with the reason, and nothing else."""
    if len(text) > LONGEST:
        raise StateFileError(f"it is damaged: no record is longer than {LONGEST} bytes")
    if not text.strip(b" \r\n\t\x00"):
        raise StateFileError("it is empty")
    try:
        return _checked(_of_our_format(json.loads(text.decode("utf-8"))))
    except (ValueError, TypeError, RecursionError) as error:
        raise StateFileError(f"it is damaged: {error}") from None
    except KeyError as error:
        raise StateFileError(f"it is damaged: the entry {error} is missing") from None


def _of_our_format(entries: Any) -> dict[str, Any]:
    if not isinstance(entries, dict):
        raise TypeError("it is no table")
    number = entries.pop("format", None)
    if type(number) is not int:
        raise TypeError("it does not say its format")
    if number > FORMAT:
        raise StateFileError(f"a newer armdrive wrote it (format {number!s:.9}, not {FORMAT})")
    if number < FORMAT:
        raise StateFileError(f"an older armdrive wrote it (format {number!s:.9}, not {FORMAT})")
    return entries


def _checked(entries: dict[str, Any]) -> Record:
    if entries.pop(_CHECK) != _check({"format": FORMAT, **entries}):
        raise ValueError("its checksum is another one")
    record = Record(
        arm=_text(entries.pop("arm")),
        calibration=_text(entries.pop("calibration")),
        offset=_steps(entries.pop("offset")),
        registers=_steps(entries.pop("registers")),
        coordinates=tuple(map(_coordinate, _items(entries.pop("coordinates")))),
        trust=Trust(entries.pop("trust")).value,
        reason=_text(entries.pop("reason")),
        in_motion=_flag(entries.pop("in_motion")),
        **{name: _steps(entries.pop(name)) for name in _OPTIONAL if name in entries},
    )
    if entries:
        raise ValueError(f"nobody knows its entry {min(entries)!r:.40}")
    if len(record.offset) != len(record.registers):
        raise ValueError("it has more registers than offsets, or fewer")
    if not set(record.unsure) <= set(range(len(record.taken))):
        raise ValueError("it doubts motors that it says nothing of")
    return record


def _check(entries: Mapping[str, Any]) -> str:
    """Return a checksum of what the entries say, however they are laid out."""
    plain = json.dumps(entries, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(plain.encode()).hexdigest()


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.40} stands where text belongs")
    value.encode("utf-8")  # half a character is no text
    return value


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise TypeError(f"{value!r:.40} stands where true or false belongs")
    return value


def _items(value: object) -> list[object]:
    if not isinstance(value, list) or not 1 <= len(value) <= MOST_MOTORS:
        raise TypeError(f"{value!r:.40} stands where a list of numbers belongs")
    return value


def _steps(value: object) -> tuple[int, ...]:
    steps = Motors(_items(value))  # type: ignore[arg-type]
    if steps.largest > STEPS_MOST:
        raise ValueError("no motor has ever made so many steps")
    return steps


def _coordinate(value: object) -> float:
    number = finite("a coordinate", value)
    if abs(number) > COORDINATE_MOST:
        raise ValueError(f"{number:g} is no coordinate of an arm")
    return number
