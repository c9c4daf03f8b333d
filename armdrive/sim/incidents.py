"""What can go wrong around an arm, physically: incidents, which no controller hears of."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class IncidentKind(Enum):
    """What can go wrong in the world of the arm."""

    TABLE = "table touched"
    KNOCK = "block knocked"
    STOP = "mechanical stop"


@dataclass(frozen=True, slots=True)
class Incident:
    """Something went wrong: with what, when (s, on the device's clock), and a sentence."""

    kind: IncidentKind
    what: str
    sentence: str
    time_s: float
