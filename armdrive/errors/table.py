"""The one catalogue of errors: code, title, cause, effect on the arm, and what to do.

Help, docs/reference/errors.md, `--json` and the status take their codes from it. Rows go by the
name of a class of errors, of a member of `Evidence`, or of a situation that is neither. Each class
of errors has its own code as well, so that an error can be raised without this table.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.errors import BadRequest
from kinematics.errors import nearest_word

# One row of the catalogue of errors: what it is called, and the four things a person asks.

NOTHING_SENT = "Nothing was sent, nothing moved."
NO_ARM = "None: no arm is concerned."
STANDS = "The arm stands once its last burst has ended, and is held where its motors have current."


@dataclass(frozen=True, slots=True)
class CatalogueEntry:
    """One kind of error.

    `name` is the class of an error, the member of `Evidence`, or the situation. A `code` is never
    given to another error, so that it can be looked up in any version.
    """

    code: str
    name: str
    title: str
    cause: str
    effect: str
    remedy: str


# E0 to E3: what is wrong with a call or a file, what is refused, and what was stopped.

LATCHED = "The arm stands, and error-stop is latched: nothing moves before `reset()`."

GENERAL = (
    CatalogueEntry(
        "E001", "ArmError", "something is wrong",
        "What the sentence says; no narrower kind of error fits.",
        "What the sentence says. A motion that was under way was stopped.",
        "Do what the sentence says; `armdrive status` shows how the arm is.",
    ),
    CatalogueEntry(
        "E002", "OSError", "this computer refused",
        "A file or folder cannot be read or written, or the disk is full.",
        "Where an arm was connected, it was stopped and given back.",
        "Make room, or the folder writable, and try again.",
    ),
    CatalogueEntry(
        "E003", "KeyboardInterrupt", "interrupted from the keyboard",
        "Ctrl-C was pressed.",
        "An arm that moved was stopped. " + STANDS,
        "None is needed; the position is kept.",
    ),
    CatalogueEntry(
        "E004", "Ended", "ended by a signal",
        "The terminal was closed, or somebody asked this program to end.",
        "An arm that moved was stopped. " + STANDS,
        "None is needed; the position is kept.",
    ),
    CatalogueEntry(
        "E005", "Unexpected", "a fault of armdrive itself",
        "Something happened that armdrive does not foresee. The sentence names the file with the "
        "details; `ARMDRIVE_TRACEBACK=1` in the environment prints them instead.",
        "Where an arm was connected, it was stopped and given back.",
        "Look at the arm, then at `armdrive status`. Report the fault with the file.",
    ),
)  # fmt: skip

REQUESTS = (
    CatalogueEntry(
        "E101", "BadRequest", "the request itself is wrong",
        "A name or a number of the call or the command is none that fits.",
        NOTHING_SENT,
        "Correct what the sentence names; `armdrive COMMAND --help` shows examples.",
    ),
    CatalogueEntry(
        "E102", "WrongAnswer", "an answer that does not fit its question",
        "An answer of the interview for an arm file cannot be read, or is out of its bounds.",
        NO_ARM,
        "Answer again as the sentence says, or correct the file of answers.",
    ),
    CatalogueEntry(
        "E103", "ArgumentTypeError", "an option that cannot be read",
        "An option of the command is no number, or not in its bounds.",
        NOTHING_SENT,
        "Correct the option; `armdrive COMMAND --help` lists them all.",
    ),
    CatalogueEntry(
        "E104", "ArmFileError", "an arm file that cannot be used",
        "The file is missing, is no TOML, or has a key or a value that makes no sense.",
        "Nothing was opened, nothing moved.",
        "Correct the key that the sentence names; `armdrive config check` reads the file anew.",
    ),
    CatalogueEntry(
        "E105", "StateFileError", "a saved state that cannot be used",
        "What an earlier program saved is damaged or cannot be read, or the position cannot be "
        "saved now: the disk is full, or the folder is not writable.",
        "Nothing moved: no motion begins whose end could not be remembered.",
        "Make room or the folder writable. A damaged file may be deleted: the arm then has to be "
        "referenced again.",
    ),
    CatalogueEntry(
        "E106", "WaitTimeout", "a wait that was given up",
        "The motion had not ended within the time that the call was ready to wait.",
        "The motion goes on.",
        "Wait again, or stop the arm.",
    ),
    CatalogueEntry(
        "E107", "RecordingError", "a recording that cannot be used",
        "The file is damaged, of another format, or of another arm.",
        NO_ARM,
        "Choose another recording; a damaged one is of use up to the line that the sentence names.",
    ),
    CatalogueEntry(
        "E108", "PointsFileError", "a file of points that cannot be used",
        "The file is no TOML, has a key or a value that makes no sense, is of an arm with other "
        "joints, or has a sequence that goes to a point there is not.",
        "Nothing moved, and the file is as it was.",
        "Correct the key that the sentence names; `armdrive points list` reads the file anew.",
    ),
    CatalogueEntry(
        "E109", "UnknownPoint", "no point has that name",
        "A point or a sequence was asked for that the arm's file of points does not have.",
        NOTHING_SENT,
        "`armdrive points list` shows the names; `armdrive points save NAME` makes one.",
    ),
    CatalogueEntry(
        "E110", "PointsChanged", "a point was changed meanwhile",
        "Another program, or somebody with an editor, has changed this point or sequence in the "
        "file since it was read.",
        "Nothing was written: the other change stays.",
        "Look at what stands there now, and make the change again.",
    ),
    CatalogueEntry(
        "E111", "KeyFileError", "a file of keys that cannot be used",
        "It is missing, is no TOML, names what is no key or nothing that the desk does, or gives "
        "one key to two things.",
        "Nothing was opened, nothing moved.",
        "Correct the line that the sentence names; `armdrive jog --show-keys` lists what has keys.",
    ),
    CatalogueEntry(
        "E112", "PendantFileError", "a file of a pendant's program that cannot be used",
        "A line of it is no row of a program, or a number does not fit into the arm's memory.",
        "Nothing was sent, nothing moved; the arm's memory is as it was.",
        "Correct the line that the sentence names; `armdrive pendant read FILE` shows the form.",
    ),
    CatalogueEntry(
        "E113", "ProgramError", "a program that cannot be used",
        "A line of it cannot be read, names what there is not, or came to where it cannot go on: "
        "a division by zero, a wait that was given up, something that it expected and is not so.",
        "What cannot be read moves nothing. A program that ended under way leaves the arm where "
        "the line before brought it.",
        "Correct the place under the caret, or what the sentence says of the arm; "
        "docs/reference/programs.md has every word.",
    ),
    CatalogueEntry(
        "E114", "InputTimeout", "an input that did not come",
        "The program waited for an input to become high or low, and the deadline that it gave "
        "passed first.",
        "None: the wait stopped nothing and moved nothing.",
        "Look at the sensor and its cable, and at the number: inputs are counted from 1. "
        "`armdrive status` shows them.",
    ),
    CatalogueEntry(
        "E115", "BadArgument", "an argument of the wrong kind",
        "A call of a program was given text where a pose belongs, too many values, or an option "
        "that it does not have.",
        NOTHING_SENT,
        "Correct the argument that the sentence names; docs/reference/python-api.md shows what "
        "each call takes.",
    ),
)  # fmt: skip

REFUSALS = (
    CatalogueEntry(
        "E201", "Refused", "refused",
        "The call asks for what this arm cannot do, or not now; the sentence says what.",
        NOTHING_SENT,
        "Do what the sentence says.",
    ),
    CatalogueEntry(
        "E202", "WrongState", "not in this state",
        "The arm is disconnected, disabled, in motion or in error-stop, and the call is not "
        "allowed then. Or the arm was paused for so long that the motion was given up.",
        "Nothing was sent, nothing moved. After a pause, the arm stands on its way, still paused.",
        "Wait for the end of a motion, call `enable()`, or look at the arm and call `reset()`, "
        "as the sentence says.",
    ),
    CatalogueEntry(
        "E203", "NotReferenced", "the position cannot be trusted",
        "Planned motion was asked for while the position is unknown or suspect, or restored from "
        "a record that nobody has confirmed.",
        NOTHING_SENT,
        "Look at the arm, then call `home()`. If it is restored and right, "
        "call `confirm_restored()`, or connect with `allow_restored=True`. "
        "Joints can be jogged meanwhile, slowly.",
    ),
    CatalogueEntry(
        "E204", "OperatorNeeded", "somebody has to look at the arm",
        "The arm has no switches and no encoders, or the question is one that only a person who "
        "sees the arm can answer.",
        NOTHING_SENT,
        "Run the command in a terminal, or say the answer beforehand with the option that the "
        "sentence names.",
    ),
    CatalogueEntry(
        "E205", "OutOfBounds", "a limit or a guard is in the way",
        "A point of the way would pass a joint limit, the table, a box that is kept out of, or "
        "the arm's own body.",
        "Nothing was sent, nothing moved. A jog stops at the bound.",
        "Choose another goal or way; where the goal was at fault, the sentence names the nearest "
        "pose that is allowed.",
    ),
    CatalogueEntry(
        "E206", "SettingsDiffer", "the controller is set up for another arm",
        "A setting of the controller is not the arm file's, and motion would be wrong by it.",
        NOTHING_SENT,
        "`armdrive doctor --mend` writes the settings; or correct the arm file.",
    ),
)  # fmt: skip

STOPS = (
    CatalogueEntry(
        "E301", "Stopped", "stopped before the end",
        "Somebody asked for a stop: a key, `armdrive stop`, another thread, or this program had "
        "stood still while the arm moved.",
        "The arm stands, short of its goal, and is held. The position is kept.",
        "Look why, then move on: nothing has to be reset.",
    ),
    CatalogueEntry(
        "E302", "PendantStop", "stopped at the pendant",
        "The STOP key of the arm's own pendant was pressed.",
        LATCHED + " The position is kept: the registers counted how far it came.",
        "Look at the arm, then call `reset()`.",
    ),
    CatalogueEntry(
        "E303", "EMERGENCY_STOP", "emergency stop",
        "Somebody asked for an emergency stop.",
        LATCHED + " Whether the motors hold it depends on the controller "
        "(docs/background/stopping.md). A controller that stops dead may have lost steps: then "
        "the position is suspect.",
        "Look at the arm, then call `reset()`, which moves nothing.",
    ),
)  # fmt: skip


# E7: why a position is unknown, restored or suspect, a row for each `Evidence` against it.

NO_PLANNING = "Planned motion is refused until the arm is referenced; jogging stays allowed."
_LOOK_AND_HOME = "Look at the arm, then call `home()`."

POSITIONS = (
    CatalogueEntry(
        "E701", "NO_RECORD", "nothing is known of the position",
        "No program has referenced this arm yet, or its record was deleted.",
        "The arm stands. " + NO_PLANNING,
        "Call `home()`.",
    ),
    CatalogueEntry(
        "E702", "RECORD_MATCHES", "the position is an earlier program's",
        "It was recorded, and the registers agree; but an arm without encoders may have been "
        "moved by hand.",
        "The arm stands. Planned motion is refused until somebody has confirmed the posture.",
        "Compare the arm with the drawn posture, then call `confirm_restored()`, or connect "
        "with `allow_restored=True`.",
    ),
    CatalogueEntry(
        "E703", "RECORD_DIFFERS", "the registers differ from the recorded ones",
        "The arm was moved by its pendant or another program, or lost its power.",
        "The arm stands, its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    CatalogueEntry(
        "E704", "ENDED_IN_MOTION", "the last program ended in mid-motion",
        "It was killed, or its computer lost power, while the arm moved.",
        "The arm stands somewhere on its way, its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    CatalogueEntry(
        "E705", "RECORD_UNUSABLE", "the recorded position cannot be used",
        "Its file is damaged, or of another arm or another calibration.",
        "The arm stands, its position is unknown. " + NO_PLANNING,
        "Call `home()`.",
    ),
    CatalogueEntry(
        "E706", "ANSWER_LOST", "a motion without an answer",
        "A motion was sent, and its answer never came: it may have been made, or not.",
        "The arm stands once the motion has ended, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E707", "SILENT", "the controller fell silent",
        "It, or one of its drives, did not answer, and may have lost its power.",
        "The arm stands, or has sagged without current; its position is suspect; error-stop is "
        "latched.",
        "Check power and cable, look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E708", "READ_BACK_DIFFERS", "the motion ended elsewhere",
        "The registers are not where the motion should have left them: a byte was lost.",
        "The arm stands off its goal, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E709", "MOTION_REFUSED", "a motion that was refused",
        "The controller refused what it should have understood; a byte may have been garbled.",
        "The arm stands, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E710", "HOMING_FAILED", "homing did not end",
        "A switch was not found, was met too early, or homing was stopped.",
        "The arm stands somewhere on its way, its position is suspect. " + NO_PLANNING,
        "Look at the switches and the arm, call `reset()`, then `home()` again.",
    ),
    CatalogueEntry(
        "E711", "STOPPED_DEAD", "stopped dead in motion",
        "An emergency stop ended the motion without a ramp: steps may have been lost.",
        "The arm stands, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E712", "ALARM", "an alarm in motion",
        "The controller ended the motion by itself: a limit switch, or its own check.",
        "The arm stands, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E713", "OFF_THE_PATH", "a position off the path",
        "The controller reported a position where the motion that was sent never leads.",
        "The arm was stopped, its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E714", "SWITCHED_OFF", "the controller switched the motors off",
        "Its watchdog, a fault or an idle time-out took the motor current away.",
        "**The arm can sag.** Its position is suspect; error-stop is latched.",
        "Support the arm, look at it, call `reset()`, then `enable()` and `home()`.",
    ),
    CatalogueEntry(
        "E715", "CURRENT_DROPPED", "the motors were switched off",
        "The motor current was switched off on request.",
        "**The arm can sag.** Its position is suspect. " + NO_PLANNING,
        "Call `enable()`, then `home()`. To be spared that, park the arm first.",
    ),
    CatalogueEntry(
        "E716", "LOST_IN_MOTION", "the wire was lost in motion",
        "The cable was pulled, or the adapter or network has gone, while the arm moved.",
        "The arm finishes what was sent and stands; its position is suspect.",
        "Plug the cable in, connect again, look at the arm, then call `home()`.",
    ),
    CatalogueEntry(
        "E717", "MOVED_BY_OTHERS", "somebody else moved the arm",
        "The registers changed while nothing was sent from here: a pendant or a hand, say.",
        "The arm stands where the others left it, its position is suspect. " + NO_PLANNING,
        "Look at the arm, then call `home()`.",
    ),
    CatalogueEntry(
        "E718", "RESTARTED", "the controller restarted",
        "It announced itself anew: reset, power lost, or the port's opening resets it.",
        "**The arm may have sagged meanwhile.** Its position is suspect; error-stop is latched.",
        "Look at the arm, call `reset()`, `enable()` where the motors are off, then `home()`.",
    ),
    CatalogueEntry(
        "E719", "CONTROLLER_RESTARTED", "the registers fell to zero",
        "The controller was reset or lost its power.",
        "**The arm may have sagged meanwhile.** Its position is suspect. " + NO_PLANNING,
        "Look at the arm, then call `home()`.",
    ),
    CatalogueEntry(
        "E720", "LINK_BACK", "the wire was lost and is back",
        "The registers agree with what they were; but an arm without encoders may have been moved "
        "by hand meanwhile.",
        "The arm stands, and error-stop is latched. After `reset()`, planned motion is refused "
        "until somebody has confirmed the posture.",
        "Look at the arm, call `reset()`, then call `confirm_restored()`, "
        "or connect with `allow_restored=True`.",
    ),
    CatalogueEntry(
        "E721", "OFF_ITS_MARK", "off its position at the mark",
        "`verify` measured the arm with its finger tips on the mark, and nobody took that posture "
        "for the new reference: steps were lost, cables have slack, or the arm file's numbers are "
        "wrong.",
        "The arm stands at its mark, its position is suspect. " + NO_PLANNING,
        "Call `home()` where it stands. If it comes again, look for what slips.",
    ),
    CatalogueEntry(
        "E722", "BROKEN_OFF", "a motion that was broken off",
        "A motion that could not go on was ended, and its reason is told beside it: a drive in "
        "another mode, an open door, a motor that does not come to rest.",
        "The arm stands on its way, its position is suspect; error-stop is latched.",
        "Mend what the reason names, look at the arm, call `reset()`, then `home()`.",
    ),
)  # fmt: skip


# E4, E5 and E8: ports and wires, what the controller does, and bytes that make no sense.

NOTHING_OPENED = "Nothing was opened, nothing moved."

WIRES = (
    CatalogueEntry(
        "E401", "LinkError", "something is wrong with the wire",
        "What the sentence says.",
        "The arm stands once its last burst has ended.",
        "Check the cable and the port.",
    ),
    CatalogueEntry(
        "E402", "PortUnavailable", "the port cannot be opened",
        "Its name, its settings or the environment forbid it; the sentence says which.",
        NOTHING_OPENED,
        "Do what the sentence says; `armdrive ports` lists what is there.",
    ),
    CatalogueEntry(
        "E403", "NoSuchPort", "there is no such port",
        "The adapter is not plugged in, has another name, or no port has that USB serial number.",
        NOTHING_OPENED,
        "Check the cable; `armdrive ports` lists what is there. `usb_serial` in the arm file finds "
        "an adapter under any name.",
    ),
    CatalogueEntry(
        "E404", "PortInUse", "another program has the port",
        "A port is opened by one program alone, and another one was first.",
        NOTHING_OPENED,
        "End the program that the sentence names.",
    ),
    CatalogueEntry(
        "E405", "PortForbidden", "no permission to open the port",
        "The port belongs to a group that this user is no member of.",
        NOTHING_OPENED,
        "Join the group that the sentence names, then log in again.",
    ),
    CatalogueEntry(
        "E406", "NoConnection", "nobody answers on the network",
        "The host is not known, is off, or no program listens at that port.",
        NOTHING_OPENED,
        "Check the address, that the controller is on, and the network.",
    ),
    CatalogueEntry(
        "E407", "LinkLost", "the connection was lost",
        "The cable was pulled, the adapter or the network has gone, or the port was closed.",
        "What was sent already is finished, which the status bounds in seconds and mm; then the "
        "arm stands. Nothing that was queued here is ever sent. A position that was lost in motion "
        "is suspect.",
        "Plug the cable in and connect again, or have it looked for (docs/how-to/sharing.md): that "
        "ends in error-stop, which only `reset()` leaves, and moves nothing.",
    ),
    CatalogueEntry(
        "E408", "ArmInUse", "another program holds the arm",
        "One program drives an arm at a time, and another one was first.",
        NOTHING_OPENED,
        "End the program that the sentence names; `armdrive stop` stops what it moves.",
    ),
    CatalogueEntry(
        "E409", "RECONNECTED", "the connection was lost and is back",
        "The wire broke meanwhile, and the controller was found again.",
        LATCHED + " The position is not more than restored: somebody may have moved the arm.",
        "Look at the arm, call `reset()`, and confirm the drawn posture or call `home()`.",
    ),
)  # fmt: skip

CONTROLLERS = (
    CatalogueEntry(
        "E501", "DeviceFault", "the controller says no",
        "The controller refused, or answered something else than it should have: a garbled byte, "
        "another dialect, a fault of its own.",
        LATCHED,
        "Look at the arm and the cable, then call `reset()`. At connecting, `armdrive doctor` "
        "finds out what is on the port.",
    ),
    CatalogueEntry(
        "E502", "NoAnswer", "the controller does not answer",
        "The deadline for the answer has passed: switched off, wrong baud rate, a cable, or the "
        "pendant has control; or something else is on the wire. A call that moves nothing takes "
        "20 s at most, and the sentence says what was received.",
        "A motion that was sent may have been made or not: the arm stands once it has ended, its "
        "position is suspect, and error-stop is latched.",
        "Check that the arm is on and its cable plugged in, look at it, then call "
        "`reset()` and `home()`.",
    ),
    CatalogueEntry(
        "E503", "PositionMismatch", "the registers are not where they should be",
        "A byte was lost on the wire, or the controller lost its power in motion.",
        LATCHED + " The position is suspect.",
        "Look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E504", "ALARM_VOUCHED", "the controller raised an alarm and kept its position",
        "A limit or the controller's own check was met; its words are in the sentence.",
        LATCHED + " The controller vouches for the position.",
        "Look at the arm, then call `reset()`.",
    ),
    CatalogueEntry(
        "E505", "ProgramHalfWritten", "a program is not whole in the arm's memory",
        "Writing the arm's own program was broken off, or it reads otherwise than it was written.",
        "Nothing moved. The sentence says which rows are in the arm, and which may be.",
        "Write the program again before it is run at the pendant.",
    ),
)  # fmt: skip

BYTES = (
    CatalogueEntry(
        "E801", "ProtocolError", "a message that the dialect does not have",
        "Something was to be sent or was heard that the controller's language cannot say.",
        "Nothing was sent on its account.",
        "Report it: the driver should have caught it.",
    ),
    CatalogueEntry(
        "E802", "LocalProtocolError", "this side asked for what the dialect cannot say",
        "A request does not exist in the controller's language, or not now.",
        NOTHING_SENT,
        "Choose another request; the controller's page in docs/ says what it can do.",
    ),
    CatalogueEntry(
        "E803", "BadField", "a number that the dialect cannot carry",
        "A field of a message is out of the range of the controller's language.",
        NOTHING_SENT,
        "Use a number that the sentence allows.",
    ),
    CatalogueEntry(
        "E804", "RemoteProtocolError", "unreadable bytes from the controller",
        "The line is disturbed, the baud rate is wrong, or another dialect is spoken.",
        "What could not be read changed nothing; an answer that it spoiled is missing.",
        "Check cable, baud rate and dialect; `armdrive doctor` listens and tells.",
    ),
    CatalogueEntry(
        "E805", "GcodeError", "G-code that a board would refuse",
        "A simulated board was sent a line with a word or a number that it does not know.",
        "The line changed nothing.",
        "Correct the line; the number after `error:` is GRBL's own.",
    ),
)  # fmt: skip


# E6: what the kinematics refuse. None of these has sent anything to an arm.

MATHEMATICS = (
    CatalogueEntry(
        "E601", "KinematicsError", "the mathematics refuse",
        "What the sentence says.",
        NOTHING_SENT,
        "Correct what the sentence names.",
    ),
    CatalogueEntry(
        "E602", "BadNumber", "not a finite number",
        "Text, nothing, NaN or an infinity stands where a length or an angle belongs.",
        NOTHING_SENT,
        "Give a number.",
    ),
    CatalogueEntry(
        "E603", "JointLimit", "a joint beyond its limit",
        "An angle is outside the range that the arm file gives its joint.",
        NOTHING_SENT,
        "Choose an angle inside; the sentence says by how much it is too far.",
    ),
    CatalogueEntry(
        "E604", "Unreachable", "out of reach",
        "No posture within the joint limits brings the tip to that pose.",
        NOTHING_SENT,
        "Take the nearest pose, which the sentence names, or another pitch.",
    ),
    CatalogueEntry(
        "E605", "PathBroken", "a line, an arc or a route that cannot be followed",
        "On its way it leaves the reach, or the arm would have to change its posture.",
        NOTHING_SENT,
        "Use a joint motion, or a way that keeps clear of the point that the sentence names.",
    ),
    CatalogueEntry(
        "E606", "SingularTransmission", "motors that do not tell the joints apart",
        "Steps per turn or couplings of the arm file make two motors say the same.",
        NO_ARM,
        "Correct the motor that the sentence names in the arm file.",
    ),
    CatalogueEntry(
        "E607", "UnknownPreset", "no such preset arm",
        "No preset has that key.",
        NO_ARM,
        "Take the nearest, which the sentence names.",
    ),
    CatalogueEntry(
        "E608", "UnknownSystem", "no such system of the textbook",
        "No worked system has that name.",
        NO_ARM,
        "Take one of those that the sentence lists.",
    ),
    CatalogueEntry(
        "E609", "OutOfReach", "a textbook goal out of reach",
        "No posture of the named system meets the goal.",
        NO_ARM,
        "Take the goal that the sentence names instead.",
    ),
    CatalogueEntry(
        "E610", "ZeroVector", "a vector without direction",
        "The zero vector was given where a direction is needed.",
        NO_ARM,
        "Give a vector with some length.",
    ),
    CatalogueEntry(
        "E611", "FlatBasis", "three axes in one plane",
        "The three vectors span no space.",
        NO_ARM,
        "Give three independent vectors.",
    ),
    CatalogueEntry(
        "E612", "NotARotation", "a matrix that is no rotation",
        "Its columns are not of length 1, not normal to each other, or left-handed.",
        NO_ARM,
        "Correct the matrix, or take the nearest rotation where only rounding spoiled it.",
    ),
    CatalogueEntry(
        "E613", "NoNearestRotation", "no rotation is the nearest",
        "The matrix is a mirror image, or flat in two directions or more.",
        NO_ARM,
        "Correct the matrix.",
    ),
    CatalogueEntry(
        "E614", "NotAUnitQuaternion", "a quaternion that is no rotation",
        "Its length is not 1.",
        NO_ARM,
        "Scale it to length 1.",
    ),
    CatalogueEntry(
        "E615", "UnknownFrame", "no such frame",
        "No frame of the graph has that name.",
        NO_ARM,
        "Take one of those that the sentence lists.",
    ),
    CatalogueEntry(
        "E616", "FramesNotConnected", "frames that nothing joins",
        "No chain of known transforms leads from one frame to the other.",
        NO_ARM,
        "Add a relation between the two groups.",
    ),
    CatalogueEntry(
        "E617", "FramesDisagree", "frames that contradict one another",
        "Two ways between the same frames give different transforms.",
        NO_ARM,
        "Correct one of them, or widen the tolerances where they were measured.",
    ),
    CatalogueEntry(
        "E618", "NoArc", "no arc leads through these points",
        "Two of the three points are the same one, or all of them lie in a line.",
        NOTHING_SENT,
        "Use a straight line, or choose a via point well beside the line from start to goal.",
    ),
)  # fmt: skip

GROUPS: Mapping[str, tuple[CatalogueEntry, ...]] = MappingProxyType(
    {
        "Anything": GENERAL,
        "Requests and files": REQUESTS,
        "Refusals": REFUSALS,
        "Stops": STOPS,
        "Ports and wires": WIRES,
        "Controllers": CONTROLLERS,
        "Kinematics": MATHEMATICS,
        "Positions": POSITIONS,
        "Bytes": BYTES,
    }
)
"""The rows by what they are about."""

ENTRIES: tuple[CatalogueEntry, ...] = tuple(row for rows in GROUPS.values() for row in rows)
"""Every row, in the order of the codes."""

_BY_NAME = MappingProxyType({row.name: row for row in ENTRIES})
_BY_CODE = MappingProxyType({row.code: row for row in ENTRIES})


def named(name: str) -> CatalogueEntry:
    """Return the row of a class, an evidence or a situation by its name."""
    return _BY_NAME[name]


def entry(error: BaseException) -> CatalogueEntry:
    """Return the row of an error: its own class's, or the nearest one's that it is made from."""
    names = (kind.__name__ for kind in type(error).__mro__)
    return next((_BY_NAME[name] for name in names if name in _BY_NAME), _BY_NAME["ArmError"])


def entry_of(evidence: Enum) -> CatalogueEntry | None:
    """Return the row of an evidence; None of one that speaks for the position."""
    return _BY_NAME.get(evidence.name)


def code_of_name(name: str) -> str:
    """Return the code of a class of errors or of an evidence; nothing where it has no row."""
    row = _BY_NAME.get(name)
    return "" if row is None else row.code


def found(words: str) -> tuple[CatalogueEntry, ...]:
    """Return the rows in which all these words stand, in any capitals; they are apart by commas."""
    wanted = words.lower().split(",")
    return tuple(row for row in ENTRIES if all(word in _said(row) for word in wanted))


def _said(row: CatalogueEntry) -> str:
    return " ".join((row.code, row.name, row.title, row.cause, row.effect, row.remedy)).lower()


def by_code(code: str) -> CatalogueEntry:
    """Return the row of a code. Raises `BadRequest` with the nearest one."""
    wanted = code.strip().strip("[]").upper()
    if wanted in _BY_CODE:
        return _BY_CODE[wanted]
    near = nearest_word(wanted, _BY_CODE)
    hint = "" if near is None else f"did you mean {near}? "
    raise BadRequest(f"there is no error {code!r}; {hint}`armdrive errors` lists them all")


def tagged(error: BaseException) -> str:
    """Return an error's sentence behind its code, as people are shown it."""
    return f"[{entry(error).code}] {error}"


def error_view(error: BaseException) -> dict[str, str]:
    """Return an error as plain data: what `--json` prints."""
    row = entry(error)
    return {
        "code": row.code,
        "title": row.title,
        "message": str(error),
        "effect": row.effect,
        "remedy": row.remedy,
    }
