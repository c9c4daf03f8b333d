"""Peculiarities of real MKS drives, and points on which no source says what they do."""

from __future__ import annotations

from armdrive.sim.bus.node import Quirk

_MANUALS = "CAN manuals 1.0.6 and 1.0.9"
_NOTES = "version notes of makerbase-motor/MKS-SERVO42D-57D"
_UNKNOWN = "not published, and no real drive was measured"

# Each row: name, default, what it does, source. A quirk without a default is always on.
# fmt: off
QUIRKS: tuple[Quirk, ...] = (
    Quirk("stall_turns", 0.1, "turns behind its set-point that are a stall",
          _UNKNOWN, guess=True, most=1.0, above_zero=True),
    Quirk("enabled_on", True, "drives hold their shafts as soon as they have power",
          "not published; one that holds again obeys the next order from its new zero", guess=True),
    Quirk("keeps_angle", False, "after power-on a position is the angle within a turn, not 0",
          "not published; of its sister it is zero by a user of makerbase-mks/MKS-SERVO42C on "
          'GitHub ("Serial command to set the encoder value to 0")', guess=True),
    Quirk("says_done", True, "drives say that a motion is done",
          f"{_MANUALS}: reply 2; firmware 1.0.5 has failed to (makerbase-motor/MKS-SERVO42D-57D, "
          '"Position Mode by Relative Axis Never Reports Complete")'),
    Quirk("says_refused", True, "drives say that they do not do a thing now",
          f"{_MANUALS}: reply 0, failed"),
    Quirk("superseded", "first",
          "when a replaced motion is reported as failed: before or after the new one has begun",
          "a public transcription of the manual does not say when; reported first, it "
          "looks like a refusal of the new one", ("first", "last", "never"), guess=True),
    Quirk("stays_armed", False, "a synchronous start does not end the storing of motions",
          f"{_MANUALS} do not say (4A, 4B)", guess=True),
    Quirk("watchdog_hears_all", False, "frames to other drives feed a drive's watchdog too",
          "the manual 1.0.9 does not say (98); if not, each is fed by itself", guess=True),
    Quirk("new_id_answers", True, "a drive that is given an id answers by the new one",
          "the authors of a public driver; not in the manuals (8B)"),
    Quirk("short_version", False, "drives tell two bytes of their version, not three",
          "two by the manual 1.0.9, three by what public programs read"),
    Quirk("answer_ms", 1.0, "milliseconds until a drive has its answer ready",
          f"{_UNKNOWN}; the later, the older is what it tells", guess=True),
    Quirk("boot_ms", 150.0, "milliseconds from a restart until a drive holds and answers again",
          f"{_UNKNOWN}; the sooner, the less shows that it was away", guess=True),
    Quirk("silent_restart", None,
          "a drive that restarts says nothing, counts from a new zero, and obeys the next order",
          "no manual or program that is known has a boot message or heartbeat", guess=True),
    Quirk("silent_watchdog", None, "a drive that its watchdog has stopped says nothing",
          "no manual or program that is known has a reply for it (98)", guess=True),
    Quirk("silent_group", None, "from 1.0.2 on a drive answers nothing that is for all or a group",
          f"{_NOTES}, V1.0.2"),
    Quirk("done_anyway", None,
          "before 1.0.8 a motion is done when its set-point ends, wherever the shaft is",
          f"no threshold of arrival before it ({_NOTES}, V1.0.8)", guess=True),
    Quirk("one_stop", None, "a stop of any code ends what is under way and forgets what is stored",
          "the manuals tell each stop with its own motion alone", guess=True),
    Quirk("pulls_on", None,
          "unprotected, a blocked drive pulls on, and springs to its set-point when freed",
          "a closed loop does; no manual describes it", guess=True),
)
# fmt: on
