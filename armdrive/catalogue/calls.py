"""E0 to E3: what is wrong with a call or a file, what is refused, and what was stopped."""

from __future__ import annotations

from armdrive.catalogue.entry import NO_ARM, NOTHING_SENT, STANDS, Entry

LATCHED = "The arm stands, and error-stop is latched: nothing moves before `reset()`."

GENERAL = (
    Entry(
        "E001", "ArmError", "something is wrong",
        "What the sentence says; no narrower kind of error fits.",
        "What the sentence says. A motion that was under way was stopped.",
        "Do what the sentence says; `armdrive status` shows how the arm is.",
    ),
    Entry(
        "E002", "OSError", "this computer refused",
        "A file or folder cannot be read or written, or the disk is full.",
        "Where an arm was connected, it was stopped and given back.",
        "Make room, or the folder writable, and try again.",
    ),
    Entry(
        "E003", "KeyboardInterrupt", "interrupted from the keyboard",
        "Ctrl-C was pressed.",
        "An arm that moved was stopped. " + STANDS,
        "None is needed; the position is kept.",
    ),
    Entry(
        "E004", "Ended", "ended by a signal",
        "The terminal was closed, or somebody asked this program to end.",
        "An arm that moved was stopped. " + STANDS,
        "None is needed; the position is kept.",
    ),
    Entry(
        "E005", "Unexpected", "a fault of armdrive itself",
        "Something happened that armdrive does not foresee. The sentence names the file with the "
        "details; `ARMDRIVE_TRACEBACK=1` in the environment prints them instead.",
        "Where an arm was connected, it was stopped and given back.",
        "Look at the arm, then at `armdrive status`. Report the fault with the file.",
    ),
)  # fmt: skip

REQUESTS = (
    Entry(
        "E101", "BadRequest", "the request itself is wrong",
        "A name or a number of the call or the command is none that fits.",
        NOTHING_SENT,
        "Correct what the sentence names; `armdrive COMMAND --help` shows examples.",
    ),
    Entry(
        "E102", "WrongAnswer", "an answer that does not fit its question",
        "An answer of the interview for an arm file cannot be read, or is out of its bounds.",
        NO_ARM,
        "Answer again as the sentence says, or correct the file of answers.",
    ),
    Entry(
        "E103", "ArgumentTypeError", "an option that cannot be read",
        "An option of the command is no number, or not in its bounds.",
        NOTHING_SENT,
        "Correct the option; `armdrive COMMAND --help` lists them all.",
    ),
    Entry(
        "E104", "ArmFileError", "an arm file that cannot be used",
        "The file is missing, is no TOML, or has a key or a value that makes no sense.",
        "Nothing was opened, nothing moved.",
        "Correct the key that the sentence names; `armdrive config check` reads the file anew.",
    ),
    Entry(
        "E105", "StateFileError", "a saved state that cannot be used",
        "What an earlier program saved is damaged or cannot be read, or the position cannot be "
        "saved now: the disk is full, or the folder is not writable.",
        "Nothing moved: no motion begins whose end could not be remembered.",
        "Make room or the folder writable. A damaged file may be deleted: the arm then has to be "
        "referenced again.",
    ),
    Entry(
        "E106", "TimeoutError", "a wait that was given up",
        "The motion had not ended within the time that the call was ready to wait.",
        "The motion goes on.",
        "Wait again, or stop the arm.",
    ),
    Entry(
        "E107", "RecordingError", "a recording that cannot be used",
        "The file is damaged, of another format, or of another arm.",
        NO_ARM,
        "Choose another recording; a damaged one is of use up to the line that the sentence names.",
    ),
    Entry(
        "E108", "PointsFileError", "a file of points that cannot be used",
        "The file is no TOML, has a key or a value that makes no sense, is of an arm with other "
        "joints, or has a sequence that goes to a point there is not.",
        "Nothing moved, and the file is as it was.",
        "Correct the key that the sentence names; `armdrive points list` reads the file anew.",
    ),
    Entry(
        "E109", "UnknownPoint", "no point has that name",
        "A point or a sequence was asked for that the arm's file of points does not have.",
        NOTHING_SENT,
        "`armdrive points list` shows the names; `armdrive points save NAME` makes one.",
    ),
    Entry(
        "E110", "PointsChanged", "a point was changed meanwhile",
        "Another program, or somebody with an editor, has changed this point or sequence in the "
        "file since it was read.",
        "Nothing was written: the other change stays.",
        "Look at what stands there now, and make the change again.",
    ),
    Entry(
        "E111", "KeyFileError", "a file of keys that cannot be used",
        "It is missing, is no TOML, names what is no key or nothing that the desk does, or gives "
        "one key to two things.",
        "Nothing was opened, nothing moved.",
        "Correct the line that the sentence names; `armdrive jog --show-keys` lists what has keys.",
    ),
    Entry(
        "E112", "PendantFileError", "a file of a pendant's program that cannot be used",
        "A line of it is no row of a program, or a number does not fit into the arm's memory.",
        "Nothing was sent, nothing moved; the arm's memory is as it was.",
        "Correct the line that the sentence names; `armdrive pendant read FILE` shows the form.",
    ),
    Entry(
        "E113", "ProgramError", "a program that cannot be used",
        "A line of it cannot be read, names what there is not, or came to where it cannot go on: "
        "a division by zero, a wait that was given up, something that it expected and is not so.",
        "What cannot be read moves nothing. A program that ended under way leaves the arm where "
        "the line before brought it.",
        "Correct the place under the caret, or what the sentence says of the arm; docs/programs.md "
        "has every word.",
    ),
    Entry(
        "E114", "InputTimeout", "an input that did not come",
        "The program waited for an input to become high or low, and the deadline that it gave "
        "passed first.",
        "None: the wait stopped nothing and moved nothing.",
        "Look at the sensor and its cable, and at the number: inputs are counted from 1. "
        "`armdrive status` shows them.",
    ),
)  # fmt: skip

REFUSALS = (
    Entry(
        "E201", "Refused", "refused",
        "The call asks for what this arm cannot do, or not now; the sentence says what.",
        NOTHING_SENT,
        "Do what the sentence says.",
    ),
    Entry(
        "E202", "WrongState", "not in this state",
        "The arm is disconnected, disabled, in motion or in error-stop, and the call is not "
        "allowed then. Or the arm was paused for so long that the motion was given up.",
        "Nothing was sent, nothing moved. After a pause, the arm stands on its way, still paused.",
        "Wait for the end of a motion, call `enable()`, or look at the arm and call `reset()`, "
        "as the sentence says.",
    ),
    Entry(
        "E203", "NotReferenced", "the position cannot be trusted",
        "Planned motion was asked for while the position is unknown or suspect, or restored from "
        "a record that nobody has confirmed.",
        NOTHING_SENT,
        "Look at the arm, then call `home()`. If it is restored and right, "
        "call `confirm_restored()`, or connect with `allow_restored=True`. "
        "Joints can be jogged meanwhile, slowly.",
    ),
    Entry(
        "E204", "OperatorNeeded", "somebody has to look at the arm",
        "The arm has no switches and no encoders, or the question is one that only a person who "
        "sees the arm can answer.",
        NOTHING_SENT,
        "Run the command in a terminal, or say the answer beforehand with the option that the "
        "sentence names.",
    ),
    Entry(
        "E205", "OutOfBounds", "a limit or a guard is in the way",
        "A point of the way would pass a joint limit, the table, a box that is kept out of, or "
        "the arm's own body.",
        "Nothing was sent, nothing moved. A jog stops at the bound.",
        "Choose another goal or way; where the goal was at fault, the sentence names the nearest "
        "pose that is allowed.",
    ),
    Entry(
        "E206", "SettingsDiffer", "the controller is set up for another arm",
        "A setting of the controller is not the arm file's, and motion would be wrong by it.",
        NOTHING_SENT,
        "`armdrive doctor --mend` writes the settings; or correct the arm file.",
    ),
)  # fmt: skip

STOPS = (
    Entry(
        "E301", "Stopped", "stopped before the end",
        "Somebody asked for a stop: a key, `armdrive stop`, another thread, or this program had "
        "stood still while the arm moved.",
        "The arm stands, short of its goal, and is held. The position is kept.",
        "Look why, then move on: nothing has to be reset.",
    ),
    Entry(
        "E302", "PendantStop", "stopped at the pendant",
        "The STOP key of the arm's own pendant was pressed.",
        LATCHED + " The position is kept: the registers counted how far it came.",
        "Look at the arm, then call `reset()`.",
    ),
    Entry(
        "E303", "EMERGENCY_STOP", "emergency stop",
        "Somebody asked for an emergency stop.",
        LATCHED + " Whether the motors hold it is said for each controller (docs/torque.md). A "
        "controller that stops dead may have lost steps: then the position is suspect.",
        "Look at the arm, then call `reset()`, which moves nothing.",
    ),
)  # fmt: skip
