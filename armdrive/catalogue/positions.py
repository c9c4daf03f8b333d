"""E7: why a position is unknown, restored or suspect, a row for each evidence of trust.py."""

from __future__ import annotations

from armdrive.catalogue.entry import Entry

NO_PLANNING = "Planned motion is refused until the arm is referenced; jogging stays allowed."
_LOOK_AND_HOME = "Look at the arm, then call `home()`."

POSITIONS = (
    Entry(
        "E701", "NO_RECORD", "nothing is known of the position",
        "No program has referenced this arm yet, or its record was deleted.",
        "The arm stands. " + NO_PLANNING,
        "Call `home()`.",
    ),
    Entry(
        "E702", "RECORD_MATCHES", "the position is an earlier program's",
        "It was recorded, and the registers agree; but an arm without encoders may have been "
        "moved by hand.",
        "The arm stands. Planned motion is refused until somebody has confirmed the posture.",
        "Compare the arm with the drawn posture, then call `confirm_restored()`, or connect "
        "with `allow_restored=True`.",
    ),
    Entry(
        "E703", "RECORD_DIFFERS", "the registers differ from the recorded ones",
        "The arm was moved by its pendant or another program, or lost its power.",
        "The arm stands, its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    Entry(
        "E704", "ENDED_IN_MOTION", "the last program ended in mid-motion",
        "It was killed, or its computer lost power, while the arm moved.",
        "The arm stands somewhere on its way, its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    Entry(
        "E705", "RECORD_UNUSABLE", "the recorded position cannot be used",
        "Its file is damaged, or of another arm or another calibration.",
        "The arm stands, its position is unknown. " + NO_PLANNING,
        "Call `home()`.",
    ),
    Entry(
        "E706", "ANSWER_LOST", "a motion without an answer",
        "A motion was sent, and its answer never came: it may have been made, or not.",
        "The arm stands once the motion has ended, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E707", "SILENT", "the controller fell silent",
        "It, or one of its drives, did not answer, and may have lost its power.",
        "The arm stands, or has sagged without current; its position is suspect; error-stop is "
        "latched.",
        "Check power and cable, look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E708", "READ_BACK_DIFFERS", "the motion ended elsewhere",
        "The registers are not where the motion should have left them: a byte was lost.",
        "The arm stands off its goal, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E709", "MOTION_REFUSED", "a motion that was refused",
        "The controller refused what it should have understood; a byte may have been garbled.",
        "The arm stands, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E710", "HOMING_FAILED", "homing did not end",
        "A switch was not found, was met too early, or homing was stopped.",
        "The arm stands somewhere on its way, its position is suspect. " + NO_PLANNING,
        "Look at the switches and the arm, call `reset()`, then `home()` again.",
    ),
    Entry(
        "E711", "STOPPED_DEAD", "stopped dead in motion",
        "An emergency stop ended the motion without a ramp: steps may have been lost.",
        "The arm stands, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E712", "ALARM", "an alarm in motion",
        "The controller ended the motion by itself: a limit switch, or its own check.",
        "The arm stands, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E713", "OFF_THE_PATH", "a position off the path",
        "The controller reported a position where the motion that was sent never leads.",
        "The arm was stopped, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    Entry(
        "E714", "SWITCHED_OFF", "the controller switched the motors off",
        "Its watchdog, a fault or an idle time-out took the motor current away.",
        "**The arm can sag.** Its position is suspect; error-stop is latched.",
        "Support the arm, look at it, call `reset()`, then `enable()` and `home()`.",
    ),
    Entry(
        "E715", "CURRENT_DROPPED", "the motors were switched off",
        "The motor current was switched off on request.",
        "**The arm can sag.** Its position is suspect. " + NO_PLANNING,
        "Call `enable()`, then `home()`. To be spared that, park the arm first.",
    ),
    Entry(
        "E716", "LOST_IN_MOTION", "the wire was lost in motion",
        "The cable was pulled, or the adapter or network has gone, while the arm moved.",
        "The arm finishes what was sent and stands; its position is suspect.",
        "Plug the cable in, connect again, look at the arm, then call `home()`.",
    ),
    Entry(
        "E717", "MOVED_BY_OTHERS", "somebody else moved the arm",
        "The registers changed while nothing was sent from here: a pendant or a hand, say.",
        "The arm stands where the others left it, its position is suspect. " + NO_PLANNING,
        "Look at the arm, then call `home()`.",
    ),
    Entry(
        "E718", "RESTARTED", "the controller restarted",
        "It announced itself anew: reset, power lost, or the port's opening resets it.",
        "**The arm may have sagged meanwhile.** Its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, `enable()` where the motors are off, then `home()`.",
    ),
    Entry(
        "E719", "CONTROLLER_RESTARTED", "the registers fell to zero",
        "The controller was reset or lost its power.",
        "**The arm may have sagged meanwhile.** Its position is suspect. " + NO_PLANNING,
        "Look at the arm, then call `home()`.",
    ),
    Entry(
        "E720", "LINK_BACK", "the wire was lost and is back",
        "The registers agree with what they were; but an arm without encoders may have been moved "
        "by hand meanwhile.",
        "The arm stands, and error-stop is latched. After `reset()`, planned motion is refused "
        "until somebody has confirmed the posture.",
        "Look at the arm, call `reset()`, then call `confirm_restored()`, "
        "or connect with `allow_restored=True`.",
    ),
    Entry(
        "E721", "OFF_ITS_MARK", "off its position at the mark",
        "`verify` measured the arm with its finger tips on the mark, and nobody took that posture "
        "for the new reference: steps were lost, cables have slack, or the arm file's numbers are "
        "wrong.",
        "The arm stands at its mark, its position is suspect. " + NO_PLANNING,
        "Call `home()` where it stands. If it comes again, look for what slips.",
    ),
    Entry(
        "E722", "BROKEN_OFF", "a motion that was broken off",
        "A motion that could not go on was ended, and its reason is told beside it: a drive in "
        "another mode, an open door, a motor that does not come to rest.",
        "The arm stands on its way, its position is suspect; error-stop is latched.",
        "Mend what the reason names, look at the arm, call `reset()`, then `home()`.",
    ),
)  # fmt: skip
