"""The numbers by which an MKS drive says how it fares with what is no reading, one table a kind."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.mks.actions import MOTION_CODES
from firmware_protocol.mks.forms import one_of, sized
from firmware_protocol.mks.reads import READ_CODES
from firmware_protocol.mks.settings import SETTING_CODES
from firmware_protocol.mks.values import Code, Outcome

_PLAIN = {0: Outcome.FAILED, 1: Outcome.DONE}
_MOTION = {
    0: Outcome.FAILED,
    1: Outcome.STARTED,
    2: Outcome.DONE,
    3: Outcome.LIMIT_STOP,
    5: Outcome.STORED,
}
_TABLES: dict[Code, dict[int, Outcome]] = {
    **dict.fromkeys(SETTING_CODES, _PLAIN),
    **dict.fromkeys(MOTION_CODES, _MOTION),
    **dict.fromkeys((Code.ENABLE, Code.EMERGENCY_STOP, Code.ARM, Code.ZERO), _PLAIN),
    **dict.fromkeys((Code.CLEAR_STALL, Code.RESTART, Code.REPORT), _PLAIN),
    # 2 is of a current that is not kept; a device here says 1 of that too
    Code.CURRENT: {0: Outcome.FAILED, 1: Outcome.DONE, 2: Outcome.DONE},
    Code.HOME: {0: Outcome.FAILED, 1: Outcome.STARTED, 2: Outcome.DONE},
    Code.CALIBRATE: {0: Outcome.STARTED, 1: Outcome.DONE, 2: Outcome.FAILED},
}
COURSE_CODES = MOTION_CODES | {Code.HOME, Code.CALIBRATE}
"""What starts first and ends later."""


@dataclass(frozen=True, slots=True)
class Status:
    """How a drive fares with a code; `reading` is what a report by itself is to tell."""

    code: Code
    outcome: Outcome
    reading: Code | None = None

    def __post_init__(self) -> None:
        one_of("code", self.code, Code)
        outcomes = set(_TABLES.get(self.code, {}).values())
        if self.outcome not in outcomes:
            words = ", ".join(sorted(outcome.name for outcome in outcomes)) or "none"
            raise BadField("outcome", self.outcome, f"for {self.code.name} one of: {words}")
        if (self.code is Code.REPORT) != (self.reading in READ_CODES):
            raise BadField("reading", self.reading, "a reading's Code, for Code.REPORT alone")

    @property
    def payload(self) -> bytes:
        """The number, behind what it is about."""
        numbers = {outcome: key for key, outcome in reversed(_TABLES[self.code].items())}
        about = b"" if self.reading is None else bytes((self.reading,))
        return about + bytes((numbers[self.outcome],))

    @classmethod
    def of(cls, code: Code, payload: bytes) -> Status:
        """Read a payload; raises `RemoteProtocolError`, or ValueError for an unknown reading."""
        reading = Code(sized(payload, 2)[0]) if code is Code.REPORT else None
        (number,) = sized(payload if reading is None else payload[1:], 1)
        outcome = _TABLES.get(code, {}).get(number)
        if outcome is None:
            raise RemoteProtocolError(f"{number} says nothing of {code.name}")
        return cls(code, outcome, reading)
