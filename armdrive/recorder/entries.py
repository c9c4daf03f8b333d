"""What a recording is made of: one entry for each thing that happened, with its time."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from types import MappingProxyType
from typing import NamedTuple


class Kind(StrEnum):
    """What happened."""

    SENT = "sent"
    HEARD = "heard"
    CALL = "call"
    RAISED = "raised"
    REQUEST = "request"
    REGISTERS = "registers"
    REPLY = "reply"
    SILENCE = "silence"
    ALERT = "alert"
    ODDITY = "oddity"
    STATE = "state"
    OFFSET = "offset"
    TRUST = "trust"
    CURRENT = "current"
    NOTICE = "notice"
    ERROR = "error"
    STOP = "stop"
    LOST = "lost"
    FAILED = "failed"
    GAP = "gap"


TITLES: Mapping[Kind, str] = MappingProxyType(
    {
        Kind.SENT: "bytes to the arm",
        Kind.HEARD: "bytes from the arm",
        Kind.CALL: "a call of a program or a person, with its arguments",
        Kind.RAISED: "what a call or a task raised",
        Kind.REQUEST: "a request that the driver began",
        Kind.REGISTERS: "the controller's counts, in answer to a request",
        Kind.REPLY: "any other answer to a request",
        Kind.SILENCE: "no answer, and none was waited for any longer",
        Kind.ALERT: "what the device said unasked, and what it means",
        Kind.ODDITY: "something on the wire that answers nothing",
        Kind.STATE: "the state machine's new state",
        Kind.OFFSET: "what is added to the controller's counts, in motor steps",
        Kind.TRUST: "the position's new trust, and why",
        Kind.CURRENT: "whether the motors are held",
        Kind.NOTICE: "the status's notice",
        Kind.ERROR: "the status's error",
        Kind.STOP: "a stop was asked for",
        Kind.LOST: "the wire was lost",
        Kind.FAILED: "the engine itself failed",
        Kind.GAP: "what came next is no longer in the recording, apart from lasting settings",
    }
)
"""Every kind, and what it stands for: the docs are checked against this table."""

WIRE = frozenset((Kind.SENT, Kind.HEARD))
"""The kinds that hold bytes; all others hold text."""


class Entry(NamedTuple):
    """One thing that happened. `time_s` is on the arm's clock; `what` is bytes on the wire.

    A tuple, since thousands of them are made beside motions.
    """

    time_s: float
    kind: Kind
    what: bytes | str
