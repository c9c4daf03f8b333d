"""Peculiarities of real MKS drives, and points on which no source says what they do."""

from __future__ import annotations

from armdrive.sim.bus.node import Quirk

_MANUALS = "CAN manuals 1.0.6 and 1.0.9"
_NOTES = "version notes of makerbase-motor/MKS-SERVO42D-57D"
_UNKNOWN = "not published, and no real drive was measured"

# Each row: name, default, what it does, source. A quirk without a default is always on.
# fmt: off
QUIRKS: tuple[Quirk, ...] = (
    Quirk("stall_turns", 0.1, "following error, in turns, at which a drive reports a stall",
          _UNKNOWN, guess=True, most=1.0, above_zero=True),
    Quirk("enabled_on", True, "drives hold their shafts as soon as they are powered",
          "not published; a drive that holds again counts from a new zero", guess=True),
    Quirk("keeps_angle", False, "after power-on a position is the angle within a turn, not 0",
          "not published; on the related SERVO42C it is 0, according to a user of "
          'makerbase-mks/MKS-SERVO42C ("Serial command to set the encoder value to 0")',
          guess=True),
    Quirk("says_done", True, "drives report the end of a motion",
          f"{_MANUALS}: reply 2; firmware 1.0.5 did not always (makerbase-motor/MKS-SERVO42D-57D, "
          '"Position Mode by Relative Axis Never Reports Complete")'),
    Quirk("says_refused", True, "drives report that they refuse an order",
          f"{_MANUALS}: reply 0, failed"),
    Quirk("superseded", "first",
          "when a replaced motion is reported as failed: before or after the new one has begun",
          "a public transcription of the manual does not say when; reported first, it "
          "looks like a refusal of the new one", ("first", "last", "never"), guess=True),
    Quirk("stays_armed", False, "drives keep storing motions after a synchronous start",
          f"{_MANUALS} do not say (4A, 4B)", guess=True),
    Quirk("watchdog_hears_all", False, "frames to other drives also reset a drive's watchdog",
          "the manual 1.0.9 does not say (98); if not, each needs frames of its own", guess=True),
    Quirk("new_id_answers", True, "a drive answers a change of its id under the new id",
          "the authors of a public driver; not in the manuals (8B)"),
    Quirk("short_version", False, "drives report two bytes of their version instead of three",
          "the manual 1.0.9 says two; public programs read three"),
    Quirk("answer_ms", 1.0, "milliseconds until a drive has its answer ready",
          f"{_UNKNOWN}; a late answer describes an older state", guess=True),
    Quirk("boot_ms", 150.0, "milliseconds from a restart until a drive holds and answers again",
          f"{_UNKNOWN}; a fast restart is harder to notice", guess=True),
    Quirk("silent_restart", None,
          "a drive restarts without a message, counts from a new zero, and obeys the next order",
          "no known manual or program has a boot message or heartbeat", guess=True),
    Quirk("silent_watchdog", None, "a drive stopped by its watchdog sends no message",
          "no known manual or program has a reply for it (98)", guess=True),
    Quirk("silent_group", None, "from 1.0.2 on, drives do not answer broadcasts and groups",
          f"{_NOTES}, V1.0.2"),
    Quirk("done_anyway", None,
          "before 1.0.8, a motion ends with its set-point, wherever the shaft is",
          f"the in-position threshold came with V1.0.8 ({_NOTES})", guess=True),
    Quirk("one_stop", None, "any stop command ends every motion and drops stored ones",
          "the manuals describe each stop only with its own kind of motion", guess=True),
    Quirk("pulls_on", None,
          "without protection, a blocked drive keeps pulling and jumps to its set-point when freed",
          "any closed loop does; no manual describes it", guess=True),
)
# fmt: on
