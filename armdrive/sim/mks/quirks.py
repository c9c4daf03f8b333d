"""What real MKS drives do that is not plain, or that no source tells: one row a quirk."""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.sim.bus.node import Quirk
from firmware_protocol.mks import COUNTS_PER_TURN

_MANUALS = "CAN manuals 1.0.6 and 1.0.9"
_NOTES = "version notes of makerbase-motor/MKS-SERVO42D-57D"

QUIRKS: tuple[Quirk, ...] = (
    Quirk(
        "stall_turns",
        "turns behind its set-point that are a stall",
        "not published; the manuals name no threshold of the stall protection (88)",
        default=0.1,
        guess=True,
        most=1.0,
        above_zero=True,
    ),
    Quirk(
        "enabled_on",
        "drives hold their shafts as soon as they have power",
        "not published; one that holds again obeys the next order from its new zero",
        default=True,
        guess=True,
    ),
    Quirk(
        "keeps_angle",
        "after power-on a position is the angle within a turn, not 0",
        "not published for these; of the sister model 42C makerbase-mks/MKS-SERVO42C says that "
        'the encoder is set to zero on power up ("Serial command to set the encoder value to 0")',
        default=False,
        guess=True,
    ),
    Quirk(
        "says_done",
        "drives say that a motion is done",
        f"{_MANUALS}: reply 2; it may never come, as firmware 1.0.5 has shown (makerbase-motor/"
        'MKS-SERVO42D-57D, "Position Mode by Relative Axis Never Reports Complete")',
        default=True,
    ),
    Quirk(
        "says_refused",
        "drives say that they do not do a thing now",
        f"{_MANUALS}: reply 0, failed",
        default=True,
    ),
    Quirk(
        "superseded",
        "when a replaced motion is said to have failed: before or after the new one has begun",
        "a public transcription of the manual says that it is said, not when; said first, nothing "
        "tells it from a refusal of the new one",
        default="first",
        guess=True,
        choices=("first", "last", "never"),
    ),
    Quirk(
        "stays_armed",
        "a synchronous start does not end the storing of motions",
        "the manuals do not say (4A, 4B)",
        default=False,
        guess=True,
    ),
    Quirk(
        "watchdog_hears_all",
        "frames to other drives feed a drive's watchdog too",
        "the manual 1.0.9 does not say (98); if they do not, each drive has to be fed by itself",
        default=False,
        guess=True,
    ),
    Quirk(
        "new_id_answers",
        "a drive that is given an id answers by the new one",
        "the authors of a public driver; not in the manuals (8B)",
        default=True,
    ),
    Quirk(
        "short_version",
        "drives tell two bytes of their version, not three",
        "two by the manual 1.0.9 (40), three by what public programs read",
        default=False,
    ),
    Quirk(
        "answer_ms",
        "milliseconds until a drive has its answer ready",
        "not published, and no real drive was measured",
        default=0.2,
        guess=True,
    ),
    Quirk(
        "boot_ms",
        "milliseconds from a restart until a drive holds its shaft and answers again",
        "not published, and no real drive was measured",
        default=500.0,
        guess=True,
    ),
    Quirk(
        "silent_restart",
        "a drive that restarts says nothing, counts from a new zero, and obeys the next order",
        f"{_MANUALS}: there is no boot message, heartbeat or error message",
    ),
    Quirk(
        "silent_watchdog",
        "a drive that its watchdog has stopped says nothing",
        "the manual 1.0.9 names no reply for it (98)",
    ),
    Quirk(
        "silent_group",
        "from 1.0.2 on a drive does not answer what is for all or for its group",
        f"{_NOTES}, V1.0.2",
    ),
    Quirk(
        "done_without_shaft",
        "before 1.0.8 a motion is done when its set-point ends, wherever the shaft is",
        f"no threshold of arrival before it ({_NOTES}, V1.0.8)",
        guess=True,
    ),
    Quirk(
        "one_stop",
        "a stop of any code ends whatever is under way, and forgets what is stored",
        "the manuals tell each stop with its own motion alone",
        guess=True,
    ),
    Quirk(
        "pulls_on",
        "without protection a blocked drive pulls on, and springs to its set-point when freed",
        "a closed loop does; no manual describes it",
        guess=True,
    ),
)
"""Those without a default are no setting: the drives are always so."""


@dataclass(frozen=True, slots=True)
class MksQuirks:
    """The choice for each row that has one, by its name."""

    stall_turns: float
    enabled_on: bool
    keeps_angle: bool
    says_done: bool
    says_refused: bool
    superseded: str
    stays_armed: bool
    watchdog_hears_all: bool
    new_id_answers: bool
    short_version: bool
    answer_ms: float
    boot_ms: float

    @property
    def stall_counts(self) -> int:
        """How far behind its set-point a shaft is that stalls."""
        return round(self.stall_turns * COUNTS_PER_TURN)
