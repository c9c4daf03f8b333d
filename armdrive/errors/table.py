"""The one catalogue of errors: code, title, cause, effect on the arm, and what to do.

Help, docs/reference/errors.md, `--json` and the status take their codes from it. A row has the
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

NOTHING_SENT = "Nothing was sent, nothing moved."
NO_ARM = "None: no arm is involved."
STANDS = "The arm stops after its last burst; motors that have current hold it there."


@dataclass(frozen=True, slots=True)
class CatalogueEntry:
    """One kind of error: its title, and answers to the four questions that a person asks.

    `name` is the class of an error, the member of `Evidence`, or the situation. A `code` is never
    given to another error, so that it can be looked up in any version.
    """

    code: str
    name: str
    title: str
    cause: str
    effect: str
    remedy: str


# E0 to E3: faults in general, wrong calls and files, refusals, and stops.

LATCHED = "The arm stands still, and error-stop is latched: nothing moves before `reset()`."

GENERAL = (
    CatalogueEntry(
        "E001", "ArmError", "something is wrong",
        "The message says what; no more specific error fits.",
        "The message says. A motion in progress was stopped.",
        "Follow the message; `armdrive status` shows the state of the arm.",
    ),
    CatalogueEntry(
        "E002", "OSError", "this computer refused",
        "A file or folder cannot be read or written, or the disk is full.",
        "An arm that was connected was stopped and released.",
        "Free some space or make the folder writable, then try again.",
    ),
    CatalogueEntry(
        "E003", "KeyboardInterrupt", "interrupted from the keyboard",
        "Ctrl-C was pressed.",
        "A moving arm was stopped. " + STANDS,
        "Nothing to do; the position is kept.",
    ),
    CatalogueEntry(
        "E004", "Ended", "ended by a signal",
        "The terminal was closed, or another program or the system ended this one.",
        "A moving arm was stopped. " + STANDS,
        "Nothing to do; the position is kept.",
    ),
    CatalogueEntry(
        "E005", "Unexpected", "a fault of armdrive itself",
        "armdrive ran into something that it does not handle. The message names the file with the "
        "details; `ARMDRIVE_TRACEBACK=1` in the environment prints them instead.",
        "An arm that was connected was stopped and released.",
        "Look at the arm, then at `armdrive status`. Please report the fault with the file.",
    ),
)  # fmt: skip

REQUESTS = (
    CatalogueEntry(
        "E101", "BadRequest", "the request itself is wrong",
        "A name or a number in the call or the command is wrong.",
        NOTHING_SENT,
        "Correct what the message names; `armdrive COMMAND --help` shows examples.",
    ),
    CatalogueEntry(
        "E102", "WrongAnswer", "an answer that does not fit its question",
        "An answer in the interview for an arm file cannot be read, or is out of bounds.",
        NO_ARM,
        "Answer again as the message says, or correct the file of answers.",
    ),
    CatalogueEntry(
        "E103", "ArgumentTypeError", "an option that cannot be read",
        "The value of an option is not a number, or is out of bounds.",
        NOTHING_SENT,
        "Correct the option; `armdrive COMMAND --help` lists them all.",
    ),
    CatalogueEntry(
        "E104", "ArmFileError", "an arm file that cannot be used",
        "The file is missing, is not TOML, or has a key or a value that makes no sense.",
        "Nothing was opened, nothing moved.",
        "Correct the key that the message names, then run `armdrive config check`.",
    ),
    CatalogueEntry(
        "E105", "StateFileError", "a saved state that cannot be used",
        "The state saved by an earlier program is damaged or unreadable, or the position cannot be "
        "saved now because the disk is full or the folder is not writable.",
        "Nothing moved: a motion begins only if its end can be saved.",
        "Free some space or make the folder writable. A damaged file may be deleted; the arm then "
        "needs a new reference.",
    ),
    CatalogueEntry(
        "E106", "WaitTimeout", "the wait timed out",
        "The motion took longer than the timeout of the call.",
        "The motion continues.",
        "Wait again, or stop the arm.",
    ),
    CatalogueEntry(
        "E107", "RecordingError", "a recording that cannot be used",
        "The file is damaged, has another format, or belongs to another arm.",
        NO_ARM,
        "Choose another recording. A damaged one is usable up to the line that the message names.",
    ),
    CatalogueEntry(
        "E108", "PointsFileError", "a file of points that cannot be used",
        "The file is not TOML, has a key or a value that makes no sense, belongs to an arm with "
        "other joints, or has a sequence that uses a missing point.",
        "Nothing moved, and the file is unchanged.",
        "Correct the key that the message names, then run `armdrive points list`.",
    ),
    CatalogueEntry(
        "E109", "UnknownPoint", "no point has that name",
        "The arm's file of points has no point or sequence of that name.",
        NOTHING_SENT,
        "`armdrive points list` shows the names; `armdrive points save NAME` adds one.",
    ),
    CatalogueEntry(
        "E110", "PointsChanged", "a point was changed in the meantime",
        "Another program or an editor changed this point or sequence after it was read.",
        "Nothing was written: the other change stays.",
        "Look at the point as it is now, and make your change again.",
    ),
    CatalogueEntry(
        "E111", "KeyFileError", "a file of keys that cannot be used",
        "The file is missing, is not TOML, names an unknown key or action, or uses a key twice.",
        "Nothing was opened, nothing moved.",
        "Correct the line that the message names; `armdrive jog --show-keys` lists all actions.",
    ),
    CatalogueEntry(
        "E112", "PendantFileError", "a pendant program that cannot be used",
        "A line of the file is not a row of a program, or a number does not fit into the arm's "
        "memory.",
        "Nothing was sent, nothing moved; the arm's memory is unchanged.",
        "Correct the line that the message names; `armdrive pendant read FILE` shows the format.",
    ),
    CatalogueEntry(
        "E113", "ProgramError", "a program that cannot be used",
        "A line cannot be read, uses an unknown name, or cannot continue: it divides by zero, a "
        "wait timed out, or the arm is not as the line expects.",
        "A program that cannot be read moves nothing. A program that ends in the middle leaves the "
        "arm where the line before left it.",
        "Correct the place above the caret, or what the message says about the arm; "
        "docs/reference/programs.md explains every word.",
    ),
    CatalogueEntry(
        "E114", "InputTimeout", "an input did not change in time",
        "A program waited for an input to become high or low, and its timeout passed.",
        "None: waiting moves nothing, and the timeout stops nothing.",
        "Check the sensor, its cable and the input's number: inputs are counted from 1. "
        "`armdrive status` shows them.",
    ),
    CatalogueEntry(
        "E115", "BadArgument", "an argument of the wrong kind",
        "A Python call got, for example, text instead of a pose, too many values, or an unknown "
        "option.",
        NOTHING_SENT,
        "Correct the argument that the message names; docs/reference/python-api.md lists what each "
        "call takes.",
    ),
)  # fmt: skip

REFUSALS = (
    CatalogueEntry(
        "E201", "Refused", "refused",
        "This arm cannot do what the call asks for, or not now; the message says why.",
        NOTHING_SENT,
        "Follow the message.",
    ),
    CatalogueEntry(
        "E202", "WrongState", "not in this state",
        "The arm is disconnected, disabled, moving or in error-stop, and the call is not allowed "
        "then. Or the arm was paused so long that its motion was cancelled.",
        "Nothing was sent, nothing moved. After a pause, the arm is part of the way along its "
        "path, and still paused.",
        "Wait for the motion to end, call `enable()`, or look at the arm and call `reset()`, "
        "as the message says.",
    ),
    CatalogueEntry(
        "E203", "NotReferenced", "the position cannot be trusted",
        "Planned motion needs a trusted position, and this one is unknown, suspect, or restored "
        "from a record without confirmation.",
        NOTHING_SENT,
        "Look at the arm, then call `home()`. If it is restored and right, "
        "call `confirm_restored()`, or connect with `allow_restored=True`. "
        "Until then, the joints can be jogged slowly.",
    ),
    CatalogueEntry(
        "E204", "OperatorNeeded", "a person has to look at the arm",
        "The arm has no switches and no encoders, or the question needs a person who can see "
        "the arm.",
        NOTHING_SENT,
        "Run the command in a terminal, or give the answer in advance with the option that the "
        "message names.",
    ),
    CatalogueEntry(
        "E205", "OutOfBounds", "a limit or a guard is in the way",
        "The path would violate a joint limit, or hit the table, a keep-out box or the arm itself.",
        "Nothing was sent, nothing moved. A jog stops at the bound.",
        "Choose another goal or path. If the goal is the problem, the message names the nearest "
        "pose that is allowed.",
    ),
    CatalogueEntry(
        "E206", "SettingsDiffer", "the controller is set up for another arm",
        "A setting of the controller differs from the arm file, so motions would be wrong.",
        NOTHING_SENT,
        "Run `armdrive doctor --mend` to write the settings, or correct the arm file.",
    ),
)  # fmt: skip

STOPS = (
    CatalogueEntry(
        "E301", "Stopped", "stopped before the end",
        "A key, `armdrive stop` or another thread stopped the arm, or this program was suspended "
        "while the arm moved.",
        "The arm stands short of its goal, and its motors hold it. The position is kept.",
        "Find out why, then go on: no reset is needed.",
    ),
    CatalogueEntry(
        "E302", "PendantStop", "stopped at the pendant",
        "The STOP key of the arm's own pendant was pressed.",
        LATCHED + " The position is kept: the registers counted how far the arm came.",
        "Look at the arm, then call `reset()`.",
    ),
    CatalogueEntry(
        "E303", "EMERGENCY_STOP", "emergency stop",
        "An emergency stop was requested.",
        LATCHED + " Whether the motors hold the arm depends on the controller "
        "(docs/background/stopping.md). A controller that stops without a ramp may have lost "
        "steps: then the position is suspect.",
        "Look at the arm, then call `reset()`, which moves nothing.",
    ),
)  # fmt: skip


# E7: why a position is unknown, restored or suspect, a row for each `Evidence` against it.

NO_PLANNING = "Planned motion is refused until the arm is referenced; jogging is still allowed."
SUSPECT_LATCHED = "The arm stands still, its position is suspect, and error-stop is latched."
_LOOK_AND_HOME = "Look at the arm, then call `home()`."
_LOOK_RESET_HOME = "Look at the arm, call `reset()`, then `home()`."

POSITIONS = (
    CatalogueEntry(
        "E701", "NO_RECORD", "the position is unknown",
        "No program has referenced this arm yet, or its record was deleted.",
        "The arm stands still. " + NO_PLANNING,
        "Call `home()`.",
    ),
    CatalogueEntry(
        "E702", "RECORD_MATCHES", "the position comes from the last session",
        "The last session saved it, and the registers match. An arm without encoders may still "
        "have been moved by hand.",
        "The arm stands still. Planned motion is refused until a person confirms the posture.",
        "Compare the arm with the drawn posture, then call `confirm_restored()`, or connect "
        "with `allow_restored=True`.",
    ),
    CatalogueEntry(
        "E703", "RECORD_DIFFERS", "the registers differ from the record",
        "The arm was moved with its pendant or by another program, or its power was off.",
        "The arm stands still, and its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    CatalogueEntry(
        "E704", "ENDED_IN_MOTION", "the last program ended during a motion",
        "The program was killed, or its computer lost power, while the arm was moving.",
        "The arm stands somewhere on its path, and its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    CatalogueEntry(
        "E705", "RECORD_UNUSABLE", "the recorded position cannot be used",
        "The file is damaged, or was saved for another arm or another calibration.",
        "The arm stands still, and its position is unknown. " + NO_PLANNING,
        "Call `home()`.",
    ),
    CatalogueEntry(
        "E706", "ANSWER_LOST", "a motion was not acknowledged",
        "A motion was sent, and the controller's answer was lost: the arm may have moved or not.",
        "The arm stands still once the motion has ended, its position is suspect, and error-stop "
        "is latched.",
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E707", "SILENT", "the controller fell silent",
        "The controller, or one of its drives, stopped answering, and may have lost power.",
        "The arm stands still, or has sagged without current; its position is suspect, and "
        "error-stop is latched.",
        "Check power and cable, look at the arm, call `reset()`, then `home()`.",
    ),
    CatalogueEntry(
        "E708", "READ_BACK_DIFFERS", "the motion missed its goal",
        "The registers differ from the goal of the motion: a byte was lost.",
        "The arm stands off its goal, its position is suspect, and error-stop is latched.",
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E709", "MOTION_REFUSED", "the controller refused a motion",
        "The motion was valid: a byte was probably corrupted on the wire.",
        SUSPECT_LATCHED,
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E710", "HOMING_FAILED", "homing failed",
        "A switch was not reached, or it closed too early, or homing was stopped.",
        "The arm stands somewhere on its path, and its position is suspect. " + NO_PLANNING,
        "Look at the switches and the arm, call `reset()`, then `home()` again.",
    ),
    CatalogueEntry(
        "E711", "STOPPED_DEAD", "stopped without a ramp",
        "An emergency stop ended the motion without a ramp, so motors may have lost steps.",
        SUSPECT_LATCHED,
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E712", "ALARM", "an alarm during a motion",
        "A limit switch or a check of the controller ended the motion.",
        SUSPECT_LATCHED,
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E713", "OFF_THE_PATH", "a position off the path",
        "The controller reported a position that is not on the path of the motion.",
        "The arm was stopped, its position is suspect, and error-stop is latched.",
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E714", "SWITCHED_OFF", "the controller switched the motors off",
        "Its watchdog, a fault or an idle timeout switched the motor current off.",
        "**The arm can sag.** Its position is suspect, and error-stop is latched.",
        "Support the arm, look at it, call `reset()`, then `enable()` and `home()`.",
    ),
    CatalogueEntry(
        "E715", "CURRENT_DROPPED", "the motors were switched off",
        "The motor current was switched off on request.",
        "**The arm can sag.** Its position is suspect. " + NO_PLANNING,
        "Call `enable()`, then `home()`. To avoid this, park the arm before you switch it off.",
    ),
    CatalogueEntry(
        "E716", "LOST_IN_MOTION", "the connection was lost during a motion",
        "The cable was pulled, or the adapter or the network went away, while the arm moved.",
        "The arm finishes what was sent, then stops; its position is suspect.",
        "Plug the cable in, connect again, look at the arm, then call `home()`.",
    ),
    CatalogueEntry(
        "E717", "MOVED_BY_OTHERS", "the arm was moved from elsewhere",
        "The registers changed although this program sent nothing: a pendant or a hand moved the "
        "arm.",
        "The arm stands where it was moved to, and its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    CatalogueEntry(
        "E718", "RESTARTED", "the controller restarted",
        "It sent its greeting again: it was reset, lost power, or restarts when its port is "
        "opened.",
        "**The arm may have sagged in the meantime.** Its position is suspect, and error-stop is "
        "latched.",
        "Look at the arm, call `reset()`, `enable()` if the motors are off, then `home()`.",
    ),
    CatalogueEntry(
        "E719", "CONTROLLER_RESTARTED", "the registers fell to zero",
        "The controller was reset or lost power.",
        "**The arm may have sagged in the meantime.** Its position is suspect. " + NO_PLANNING,
        _LOOK_AND_HOME,
    ),
    CatalogueEntry(
        "E720", "LINK_BACK", "the connection was lost and is back",
        "The registers have not changed, but an arm without encoders may have been moved by hand "
        "in the meantime.",
        "The arm stands still, and error-stop is latched. After `reset()`, planned motion is "
        "refused until a person confirms the posture.",
        "Look at the arm, call `reset()`, then call `confirm_restored()`, "
        "or connect with `allow_restored=True`.",
    ),
    CatalogueEntry(
        "E721", "OFF_ITS_MARK", "the position was wrong at the mark",
        "`verify` found a difference between the counts and the mark, and the posture was "
        "not accepted as the new reference. Steps were lost, cables are slack, or the arm file has "
        "wrong numbers.",
        "The arm stands at its mark, and its position is suspect. " + NO_PLANNING,
        "Call `home()` where the arm stands. If the drift comes back, look for what slips.",
    ),
    CatalogueEntry(
        "E722", "BROKEN_OFF", "a motion was cancelled",
        "The motion could not go on; the message gives the reason: a drive in another mode, an "
        "open door, a motor that does not come to rest.",
        "The arm stands somewhere on its path, its position is suspect, and error-stop is latched.",
        "Fix what the message names, look at the arm, call `reset()`, then `home()`.",
    ),
)  # fmt: skip


# E4, E5 and E8: ports and connections, controllers, and bytes that make no sense.

NOTHING_OPENED = "Nothing was opened, nothing moved."

WIRES = (
    CatalogueEntry(
        "E401", "LinkError", "something is wrong with the connection",
        "The message says what.",
        "The arm stops after its last burst.",
        "Check the cable and the port.",
    ),
    CatalogueEntry(
        "E402", "PortUnavailable", "the port cannot be opened",
        "Its name, its settings or the environment forbid it; the message says which.",
        NOTHING_OPENED,
        "Follow the message; `armdrive ports` lists the ports.",
    ),
    CatalogueEntry(
        "E403", "NoSuchPort", "there is no such port",
        "The adapter is not plugged in or has another name, or no port has that USB serial number.",
        NOTHING_OPENED,
        "Check the cable; `armdrive ports` lists the ports. With `usb_serial` in the arm file, an "
        "adapter is found under any name.",
    ),
    CatalogueEntry(
        "E404", "PortInUse", "another program has the port",
        "Only one program at a time can open a port, and another program has this one open.",
        NOTHING_OPENED,
        "End the program that the message names.",
    ),
    CatalogueEntry(
        "E405", "PortForbidden", "no permission to open the port",
        "The port belongs to a group, and this user is not a member.",
        NOTHING_OPENED,
        "Join the group that the message names, then log in again.",
    ),
    CatalogueEntry(
        "E406", "NoConnection", "no answer on the network",
        "The host is unknown or off, or no program listens at that port.",
        NOTHING_OPENED,
        "Check the address, the controller's power, and the network.",
    ),
    CatalogueEntry(
        "E407", "LinkLost", "the connection was lost",
        "The cable was pulled, the adapter or the network went away, or the port was closed.",
        "The arm finishes what was already sent, within the time and the distance that the status "
        "shows, then stops. What was still queued here is never sent. If the arm was moving, its "
        "position is suspect.",
        "Plug the cable in and connect again, or let armdrive reconnect (docs/how-to/sharing.md). "
        "Reconnecting moves nothing and ends in error-stop; only `reset()` leaves that.",
    ),
    CatalogueEntry(
        "E408", "ArmInUse", "another program is driving the arm",
        "Only one program at a time can drive an arm.",
        NOTHING_OPENED,
        "End the program that the message names; `armdrive stop` stops the arm.",
    ),
    CatalogueEntry(
        "E409", "RECONNECTED", "the connection was lost and is back",
        "The connection broke, and the controller was found again.",
        LATCHED + " The position is restored at best: the arm may have been moved by hand.",
        "Look at the arm, call `reset()`, and confirm the drawn posture or call `home()`.",
    ),
)  # fmt: skip

CONTROLLERS = (
    CatalogueEntry(
        "E501", "DeviceFault", "the controller reports a fault",
        "The controller refused, or gave an unexpected answer: a garbled byte, another dialect, or "
        "a fault of its own.",
        LATCHED,
        "Look at the arm and the cable, then call `reset()`. If connecting fails, "
        "`armdrive doctor` finds out what is on the port.",
    ),
    CatalogueEntry(
        "E502", "NoAnswer", "the controller does not answer",
        "The timeout passed: the controller is off, the baud rate or the cable is wrong, the "
        "pendant has control, or something else is on the line. A call that moves nothing takes "
        "20 s at most, and the message quotes what was received.",
        "If a motion was sent, the arm may have moved or not: it stands still once the motion has "
        "ended, its position is suspect, and error-stop is latched.",
        "Check the power and the cable, look at the arm, then call "
        "`reset()` and `home()`.",
    ),
    CatalogueEntry(
        "E503", "PositionMismatch", "the registers differ from the goal",
        "A byte was lost on the line, or the controller lost power during the motion.",
        LATCHED + " The position is suspect.",
        _LOOK_RESET_HOME,
    ),
    CatalogueEntry(
        "E504", "ALARM_VOUCHED", "the controller raised an alarm and kept its position",
        "A limit switch or the controller's own check; the message quotes the controller.",
        LATCHED + " The controller guarantees the position.",
        "Look at the arm, then call `reset()`.",
    ),
    CatalogueEntry(
        "E505", "ProgramHalfWritten", "the program in the arm's memory is incomplete",
        "Writing the arm's own program was interrupted, or the rows read back differ.",
        "Nothing moved. The message says which rows are in the arm, and which may be.",
        "Write the program again before you run it at the pendant.",
    ),
)  # fmt: skip

BYTES = (
    CatalogueEntry(
        "E801", "ProtocolError", "a message that does not exist in the dialect",
        "armdrive sent or received a message that the controller's language does not have.",
        "The message had no effect.",
        "Please report it: the driver should have caught it.",
    ),
    CatalogueEntry(
        "E802", "LocalProtocolError", "a request that the dialect does not support",
        "The controller's language has no such request, or not at this moment.",
        NOTHING_SENT,
        "Choose another request; the controller's page in docs/ lists what it can do.",
    ),
    CatalogueEntry(
        "E803", "BadField", "a number out of range for the dialect",
        "A number does not fit into its field of the message.",
        NOTHING_SENT,
        "Use a number that the message allows.",
    ),
    CatalogueEntry(
        "E804", "RemoteProtocolError", "unreadable bytes from the controller",
        "The line is noisy, the baud rate is wrong, or the controller speaks another dialect.",
        "The unreadable bytes changed nothing; if they were an answer, that answer is missing.",
        "Check cable, baud rate and dialect; `armdrive doctor` listens and reports.",
    ),
    CatalogueEntry(
        "E805", "GcodeError", "G-code that a board would refuse",
        "A simulated board got a line with an unknown word or number.",
        "The line changed nothing.",
        "Correct the line; the number after `error:` is GRBL's own.",
    ),
)  # fmt: skip


# E6: refusals of the kinematics. None of them has sent anything to an arm.

MATHEMATICS = (
    CatalogueEntry(
        "E601", "KinematicsError", "the kinematics refused",
        "The message says why.",
        NOTHING_SENT,
        "Correct what the message names.",
    ),
    CatalogueEntry(
        "E602", "BadNumber", "not a finite number",
        "A length or an angle is text, missing, NaN or infinite, or an angle of a pose is beyond "
        "two turns, as when degrees are given for rad.",
        NOTHING_SENT,
        "Give a number; give degrees where degrees are expected.",
    ),
    CatalogueEntry(
        "E603", "JointLimit", "a joint beyond its limit",
        "An angle is outside the range that the arm file gives for the joint.",
        NOTHING_SENT,
        "Choose an angle within the range; the message says how far off it is.",
    ),
    CatalogueEntry(
        "E604", "Unreachable", "out of reach",
        "No posture within the joint limits brings the tip to that pose.",
        NOTHING_SENT,
        "Use the nearest pose, which the message names, or another pitch.",
    ),
    CatalogueEntry(
        "E605", "PathBroken", "a path that the arm cannot follow",
        "Along the line, arc or route, the arm would leave its reach or have to change its "
        "posture.",
        NOTHING_SENT,
        "Use a joint motion, or a path that keeps away from the point that the message names.",
    ),
    CatalogueEntry(
        "E606", "SingularTransmission", "joint angles that the motors do not determine",
        "By the steps per turn and couplings in the arm file, two motors turn the same joints in "
        "the same proportion, so motor steps do not determine the joint angles.",
        NO_ARM,
        "Correct the motor that the message names in the arm file.",
    ),
    CatalogueEntry(
        "E607", "UnknownPreset", "no such preset arm",
        "No preset has that key.",
        NO_ARM,
        "Use the nearest one, which the message names.",
    ),
    CatalogueEntry(
        "E608", "UnknownSystem", "no such system in the textbook",
        "No worked system has that name.",
        NO_ARM,
        "Use one of those that the message lists.",
    ),
    CatalogueEntry(
        "E609", "OutOfReach", "a textbook goal out of reach",
        "No posture of the named system meets the goal.",
        NO_ARM,
        "Use the goal that the message names instead.",
    ),
    CatalogueEntry(
        "E610", "ZeroVector", "a vector without direction",
        "A direction is needed, and the vector is zero.",
        NO_ARM,
        "Give a vector that is not zero.",
    ),
    CatalogueEntry(
        "E611", "FlatBasis", "three axes in one plane",
        "The three vectors do not span space.",
        NO_ARM,
        "Give three independent vectors.",
    ),
    CatalogueEntry(
        "E612", "NotARotation", "a matrix that is not a rotation",
        "Its columns are not of length 1, not perpendicular, or left-handed.",
        NO_ARM,
        "Correct the matrix; if only rounding spoiled it, use the nearest rotation.",
    ),
    CatalogueEntry(
        "E613", "NoNearestRotation", "no nearest rotation",
        "The matrix is a mirror image, or flat in two or more directions.",
        NO_ARM,
        "Correct the matrix.",
    ),
    CatalogueEntry(
        "E614", "NotAUnitQuaternion", "a quaternion that is not a rotation",
        "Its length is not 1.",
        NO_ARM,
        "Scale it to length 1.",
    ),
    CatalogueEntry(
        "E615", "UnknownFrame", "no such frame",
        "No frame in the graph has that name.",
        NO_ARM,
        "Use one of those that the message lists.",
    ),
    CatalogueEntry(
        "E616", "FramesNotConnected", "frames that are not connected",
        "No chain of known transforms leads from one frame to the other.",
        NO_ARM,
        "Add a transform between the two groups.",
    ),
    CatalogueEntry(
        "E617", "FramesDisagree", "frames that contradict one another",
        "Two chains of transforms between the same frames give different results.",
        NO_ARM,
        "Correct one of them, or widen the tolerances if they were measured.",
    ),
    CatalogueEntry(
        "E618", "NoArc", "no arc leads through these points",
        "Two of the three points coincide, or all three lie on a line.",
        NOTHING_SENT,
        "Use a straight line, or choose a via point farther from the line from start to goal.",
    ),
)  # fmt: skip

GROUPS: Mapping[str, tuple[CatalogueEntry, ...]] = MappingProxyType(
    {
        "Anything": GENERAL,
        "Requests and files": REQUESTS,
        "Refusals": REFUSALS,
        "Stops": STOPS,
        "Ports and connections": WIRES,
        "Controllers": CONTROLLERS,
        "Kinematics": MATHEMATICS,
        "Positions": POSITIONS,
        "Bytes": BYTES,
    }
)
"""The rows by subject."""

ENTRIES: tuple[CatalogueEntry, ...] = tuple(row for rows in GROUPS.values() for row in rows)
"""Every row, in the order of the codes."""

_BY_NAME = MappingProxyType({row.name: row for row in ENTRIES})
_BY_CODE = MappingProxyType({row.code: row for row in ENTRIES})


def named(name: str) -> CatalogueEntry:
    """Return the row of a class, an evidence or a situation by its name."""
    return _BY_NAME[name]


def entry(error: BaseException) -> CatalogueEntry:
    """Return the row of an error: that of its class, or of the nearest class it derives from."""
    names = (kind.__name__ for kind in type(error).__mro__)
    return next((_BY_NAME[name] for name in names if name in _BY_NAME), _BY_NAME["ArmError"])


def entry_of(evidence: Enum) -> CatalogueEntry | None:
    """Return the row of an evidence; None if it speaks for the position."""
    return _BY_NAME.get(evidence.name)


def code_of_name(name: str) -> str:
    """Return the code of a class of errors or of an evidence; "" if it has no row."""
    row = _BY_NAME.get(name)
    return "" if row is None else row.code


def found(words: str) -> tuple[CatalogueEntry, ...]:
    """Return the rows that have all these words, separated by commas, in upper or lower case."""
    wanted = words.lower().split(",")
    return tuple(row for row in ENTRIES if all(word in _text(row) for word in wanted))


def _text(row: CatalogueEntry) -> str:
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
    """Return an error's message after its code, as people see it."""
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
