"""The one catalogue of errors: code, title, cause, effect on the arm, and what to do.

Help, docs/reference/errors.md, `--json` and the status take their codes from it. A row has the
name of a class of errors, of a member of `Evidence`, or of a situation that is neither. Each class
of errors has its own code as well, so that an error can be raised without this table.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.errors import BadRequest
from kinematics.errors import nearest_word


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


_PHRASES = {
    "LATCHED": "The arm stands still, and error-stop is latched: nothing moves before `reset()`.",
    "STANDS": "The arm stops after its last burst; motors that have current hold it there.",
    "NO_PLANNING": (
        "Planned motion is refused until the arm is referenced; jogging is still allowed."
    ),
    "SUSPECT_LATCHED": (
        "The arm stands still, its position is suspect, and error-stop is latched."
    ),
    "LOOK_RESET_HOME": "Look at the arm, call `reset()`, then `home()`.",
    "LOOK_AND_HOME": "Look at the arm, then call `home()`.",
}
"""Sentences of several rows."""

_CATALOGUE = """Anything

E001: something is wrong (ArmError)
  cause   The message says what; no more specific error fits.
  effect  The message says. A motion in progress was stopped.
  remedy  Follow the message; `armdrive status` shows the state of the arm.
E002: this computer refused (OSError)
  cause   A file or folder cannot be read or written, or the disk is full.
  effect  An arm that was connected was stopped and released.
  remedy  Free some space or make the folder writable, then try again.
E003: interrupted from the keyboard (KeyboardInterrupt)
  cause   Ctrl-C was pressed.
  effect  A moving arm was stopped. {STANDS}
  remedy  Nothing to do; the position is kept.
E004: ended by a signal (CommandEnded)
  cause   The terminal was closed, or another program or the system ended this one.
  effect  A moving arm was stopped. {STANDS}
  remedy  Nothing to do; the position is kept.
E005: a fault of armdrive itself (Unexpected)
  cause   armdrive ran into something that it does not handle. The message names the file with the
          details; `ARMDRIVE_TRACEBACK=1` in the environment prints them instead.
  effect  An arm that was connected was stopped and released.
  remedy  Look at the arm, then at `armdrive status`. Please report the fault with the file.

Requests and files

E101: the request itself is wrong (BadRequest)
  cause   A name or a number in the call or the command is wrong.
  effect  Nothing was sent, nothing moved.
  remedy  Correct what the message names; `armdrive COMMAND --help` shows examples.
E102: an answer that does not fit its question (WrongAnswer)
  cause   An answer in the interview for an arm file cannot be read, or is out of bounds.
  effect  None: no arm is involved.
  remedy  Answer again as the message says, or correct the file of answers.
E103: an option that cannot be read (ArgumentTypeError)
  cause   The value of an option is not a number, or is out of bounds.
  effect  Nothing was sent, nothing moved.
  remedy  Correct the option; `armdrive COMMAND --help` lists them all.
E104: an arm file that cannot be used (ArmFileError)
  cause   The file is missing, is not TOML, or has a key or a value that makes no sense.
  effect  Nothing was opened, nothing moved.
  remedy  Correct the key that the message names, then run `armdrive config check`.
E105: a saved state that cannot be used (StateFileError)
  cause   The state saved by an earlier program is damaged or unreadable, or the position cannot be
          saved now because the disk is full or the folder is not writable.
  effect  Nothing moved: a motion begins only if its end can be saved.
  remedy  Free some space or make the folder writable. A damaged file may be deleted; the arm then
          needs a new reference.
E106: the wait timed out (WaitTimeout)
  cause   The motion took longer than the timeout of the call.
  effect  The motion continues.
  remedy  Wait again, or stop the arm.
E107: a recording that cannot be used (RecordingError)
  cause   The file is damaged, has another format, or belongs to another arm.
  effect  None: no arm is involved.
  remedy  Choose another recording. A damaged one is usable up to the line that the message names.
E108: a file of points that cannot be used (PointsFileError)
  cause   The file is not TOML, has a key or a value that makes no sense, belongs to an arm with
          other joints, or has a sequence that uses a missing point.
  effect  Nothing moved, and the file is unchanged.
  remedy  Correct the key that the message names, then run `armdrive points list`.
E109: no point has that name (UnknownPoint)
  cause   The arm's file of points has no point or sequence of that name.
  effect  Nothing was sent, nothing moved.
  remedy  `armdrive points list` shows the names; `armdrive points save NAME` adds one.
E110: a point was changed in the meantime (PointsChanged)
  cause   Another program or an editor changed this point or sequence after it was read.
  effect  Nothing was written: the other change stays.
  remedy  Look at the point as it is now, and make your change again.
E111: a file of keys that cannot be used (KeyFileError)
  cause   The file is missing, is not TOML, names an unknown key or action, or uses a key twice.
  effect  Nothing was opened, nothing moved.
  remedy  Correct the line that the message names; `armdrive jog --show-keys` lists all actions.
E112: a pendant program that cannot be used (PendantFileError)
  cause   A line of the file is not a row of a program, or a number does not fit into the arm's
          memory.
  effect  Nothing was sent, nothing moved; the arm's memory is unchanged.
  remedy  Correct the line that the message names; `armdrive pendant read FILE` shows the format.
E113: a program that cannot be used (ProgramError)
  cause   A line cannot be read, uses an unknown name, or cannot continue: it divides by zero, a
          wait timed out, or the arm is not as the line expects.
  effect  A program that cannot be read moves nothing. A program that ends in the middle leaves the
          arm where the line before left it.
  remedy  Correct the place above the caret, or what the message says about the arm;
          docs/reference/programs.md explains every word.
E114: an input did not change in time (InputTimeout)
  cause   A program waited for an input to become high or low, and its timeout passed.
  effect  None: waiting moves nothing, and the timeout stops nothing.
  remedy  Check the sensor, its cable and the input's number: inputs are counted from 1. `armdrive
          status` shows them.
E115: an argument of the wrong kind (BadArgument)
  cause   A Python call got, for example, text instead of a pose, too many values, or an unknown
          option.
  effect  Nothing was sent, nothing moved.
  remedy  Correct the argument that the message names; docs/reference/python-api.md lists what each
          call takes.

Refusals

E201: refused (Refused)
  cause   This arm cannot do what the call asks for, or not now; the message says why.
  effect  Nothing was sent, nothing moved.
  remedy  Follow the message.
E202: not in this state (WrongState)
  cause   The arm is disconnected, disabled, moving or in error-stop, and the call is not allowed
          then. Or the arm was paused so long that its motion was cancelled.
  effect  Nothing was sent, nothing moved. After a pause, the arm is part of the way along its path,
          and still paused.
  remedy  Wait for the motion to end, call `enable()`, or look at the arm and call `reset()`, as the
          message says.
E203: the position cannot be trusted (NotReferenced)
  cause   Planned motion needs a trusted position, and this one is unknown, suspect, or restored
          from a record without confirmation.
  effect  Nothing was sent, nothing moved.
  remedy  {LOOK_AND_HOME} If it is restored and right, call `confirm_restored()`, or connect with
          `allow_restored=True`. Until then, the joints can be jogged slowly.
E204: a person has to look at the arm (OperatorNeeded)
  cause   The arm has no switches and no encoders, or the question needs a person who can see the
          arm.
  effect  Nothing was sent, nothing moved.
  remedy  Run the command in a terminal, or give the answer in advance with the option that the
          message names.
E205: a limit or a guard is in the way (OutOfBounds)
  cause   The path would violate a joint limit, or hit the table, a keep-out box or the arm itself.
  effect  Nothing was sent, nothing moved. A jog stops at the bound.
  remedy  Choose another goal or path. If the goal is the problem, the message names the nearest
          pose that is allowed.
E206: the controller is set up for another arm (SettingsDiffer)
  cause   A setting of the controller differs from the arm file, so motions would be wrong.
  effect  Nothing was sent, nothing moved.
  remedy  Run `armdrive doctor --mend` to write the settings, or correct the arm file.

Stops

E301: stopped before the end (Stopped)
  cause   A key, `armdrive stop` or another thread stopped the arm, or this program was suspended
          while the arm moved.
  effect  The arm stands short of its goal, and its motors hold it. The position is kept.
  remedy  Find out why, then go on: no reset is needed.
E302: stopped at the pendant (PendantStop)
  cause   The STOP key of the arm's own pendant was pressed.
  effect  {LATCHED} The position is kept: the registers counted how far the arm came.
  remedy  Look at the arm, then call `reset()`.
E303: emergency stop (EMERGENCY_STOP)
  cause   An emergency stop was requested.
  effect  {LATCHED} Whether the motors hold the arm depends on the controller
          (docs/background/stopping.md). A controller that stops without a ramp may have lost steps:
          then the position is suspect.
  remedy  Look at the arm, then call `reset()`, which moves nothing.

Ports and connections

E401: something is wrong with the connection (LinkError)
  cause   The message says what.
  effect  The arm stops after its last burst.
  remedy  Check the cable and the port.
E402: the port cannot be opened (PortUnavailable)
  cause   Its name, its settings or the environment forbid it; the message says which.
  effect  Nothing was opened, nothing moved.
  remedy  Follow the message; `armdrive ports` lists the ports.
E403: there is no such port (NoSuchPort)
  cause   The adapter is not plugged in or has another name, or no port has that USB serial number.
  effect  Nothing was opened, nothing moved.
  remedy  Check the cable; `armdrive ports` lists the ports. With `usb_serial` in the arm file, an
          adapter is found under any name.
E404: another program has the port (PortInUse)
  cause   Only one program at a time can open a port, and another program has this one open.
  effect  Nothing was opened, nothing moved.
  remedy  End the program that the message names.
E405: no permission to open the port (PortForbidden)
  cause   The port belongs to a group, and this user is not a member.
  effect  Nothing was opened, nothing moved.
  remedy  Join the group that the message names, then log in again.
E406: no answer on the network (NoConnection)
  cause   The host is unknown or off, or no program listens at that port.
  effect  Nothing was opened, nothing moved.
  remedy  Check the address, the controller's power, and the network.
E407: the connection was lost (LinkLost)
  cause   The cable was pulled, the adapter or the network went away, or the port was closed.
  effect  The arm finishes what was already sent, within the time and the distance that the status
          shows, then stops. What was still queued here is never sent. If the arm was moving, its
          position is suspect.
  remedy  Plug the cable in and connect again, or let armdrive reconnect (docs/how-to/sharing.md).
          Reconnecting moves nothing and ends in error-stop; only `reset()` leaves that.
E408: another program is driving the arm (ArmInUse)
  cause   Only one program at a time can drive an arm.
  effect  Nothing was opened, nothing moved.
  remedy  End the program that the message names; `armdrive stop` stops the arm.
E409: the connection was lost and is back (RECONNECTED)
  cause   The connection broke, and the controller was found again.
  effect  {LATCHED} The position is restored at best: the arm may have been moved by hand.
  remedy  Look at the arm, call `reset()`, and confirm the drawn posture or call `home()`.

Controllers

E501: the controller reports a fault (DeviceFault)
  cause   The controller refused, or gave an unexpected answer: a garbled byte, another dialect, or
          a fault of its own.
  effect  {LATCHED}
  remedy  Look at the arm and the cable, then call `reset()`. If connecting fails, `armdrive doctor`
          finds out what is on the port.
E502: the controller does not answer (NoAnswer)
  cause   The timeout passed: the controller is off, the baud rate or the cable is wrong, the
          pendant has control, or something else is on the line. A call that moves nothing takes 20
          s at most, and the message quotes what was received.
  effect  If a motion was sent, the arm may have moved or not: it stands still once the motion has
          ended, its position is suspect, and error-stop is latched.
  remedy  Check the power and the cable, look at the arm, then call `reset()` and `home()`.
E503: the registers differ from the goal (PositionMismatch)
  cause   A byte was lost on the line, or the controller lost power during the motion.
  effect  {LATCHED} The position is suspect.
  remedy  {LOOK_RESET_HOME}
E504: the controller raised an alarm and kept its position (ALARM_VOUCHED)
  cause   A limit switch or the controller's own check; the message quotes the controller.
  effect  {LATCHED} The controller guarantees the position.
  remedy  Look at the arm, then call `reset()`.
E505: the program in the arm's memory is incomplete (ProgramHalfWritten)
  cause   Writing the arm's own program was interrupted, or the rows read back differ.
  effect  Nothing moved. The message says which rows are in the arm, and which may be.
  remedy  Write the program again before you run it at the pendant.

Kinematics

E601: the kinematics refused (KinematicsError)
  cause   The message says why.
  effect  Nothing was sent, nothing moved.
  remedy  Correct what the message names.
E602: not a finite number (BadNumber)
  cause   A length or an angle is text, missing, NaN or infinite, or an angle of a pose is beyond
          two turns, as when degrees are given for rad.
  effect  Nothing was sent, nothing moved.
  remedy  Give a number; give degrees where degrees are expected.
E603: a joint beyond its limit (JointLimit)
  cause   An angle is outside the range that the arm file gives for the joint.
  effect  Nothing was sent, nothing moved.
  remedy  Choose an angle within the range; the message says how far off it is.
E604: out of reach (Unreachable)
  cause   No posture within the joint limits brings the tip to that pose.
  effect  Nothing was sent, nothing moved.
  remedy  Use the nearest pose, which the message names, or another pitch.
E605: a path that the arm cannot follow (PathBroken)
  cause   Along the line, arc or route, the arm would leave its reach or have to change its posture.
  effect  Nothing was sent, nothing moved.
  remedy  Use a joint motion, or a path that keeps away from the point that the message names.
E606: joint angles that the motors do not determine (SingularTransmission)
  cause   By the steps per turn and couplings in the arm file, two motors turn the same joints in
          the same proportion, so motor steps do not determine the joint angles.
  effect  None: no arm is involved.
  remedy  Correct the motor that the message names in the arm file.
E607: no such preset arm (UnknownPreset)
  cause   No preset has that key.
  effect  None: no arm is involved.
  remedy  Use the nearest one, which the message names.
E608: no such system in the textbook (UnknownSystem)
  cause   No worked system has that name.
  effect  None: no arm is involved.
  remedy  Use one of those that the message lists.
E609: a textbook goal out of reach (OutOfReach)
  cause   No posture of the named system meets the goal.
  effect  None: no arm is involved.
  remedy  Use the goal that the message names instead.
E610: a vector without direction (ZeroVector)
  cause   A direction is needed, and the vector is zero.
  effect  None: no arm is involved.
  remedy  Give a vector that is not zero.
E611: three axes in one plane (FlatBasis)
  cause   The three vectors do not span space.
  effect  None: no arm is involved.
  remedy  Give three independent vectors.
E612: a matrix that is not a rotation (NotARotation)
  cause   Its columns are not of length 1, not perpendicular, or left-handed.
  effect  None: no arm is involved.
  remedy  Correct the matrix; if only rounding spoiled it, use the nearest rotation.
E613: no nearest rotation (NoNearestRotation)
  cause   The matrix is a mirror image, or flat in two or more directions.
  effect  None: no arm is involved.
  remedy  Correct the matrix.
E614: a quaternion that is not a rotation (NotAUnitQuaternion)
  cause   Its length is not 1.
  effect  None: no arm is involved.
  remedy  Scale it to length 1.
E615: no such frame (UnknownFrame)
  cause   No frame in the graph has that name.
  effect  None: no arm is involved.
  remedy  Use one of those that the message lists.
E616: frames that are not connected (FramesNotConnected)
  cause   No chain of known transforms leads from one frame to the other.
  effect  None: no arm is involved.
  remedy  Add a transform between the two groups.
E617: frames that contradict one another (FramesDisagree)
  cause   Two chains of transforms between the same frames give different results.
  effect  None: no arm is involved.
  remedy  Correct one of them, or widen the tolerances if they were measured.
E618: no arc leads through these points (NoArc)
  cause   Two of the three points coincide, or all three lie on a line.
  effect  Nothing was sent, nothing moved.
  remedy  Use a straight line, or choose a via point farther from the line from start to goal.

Positions

E701: the position is unknown (NO_RECORD)
  cause   No program has referenced this arm yet, or its record was deleted.
  effect  The arm stands still. {NO_PLANNING}
  remedy  Call `home()`.
E702: the position comes from the last session (RECORD_MATCHES)
  cause   The last session saved it, and the registers match. An arm without encoders may still have
          been moved by hand.
  effect  The arm stands still. Planned motion is refused until a person confirms the posture.
  remedy  Compare the arm with the drawn posture, then call `confirm_restored()`, or connect with
          `allow_restored=True`.
E703: the registers differ from the record (RECORD_DIFFERS)
  cause   The arm was moved with its pendant or by another program, or its power was off.
  effect  The arm stands still, and its position is suspect. {NO_PLANNING}
  remedy  {LOOK_AND_HOME}
E704: the last program ended during a motion (ENDED_IN_MOTION)
  cause   The program was killed, or its computer lost power, while the arm was moving.
  effect  The arm stands somewhere on its path, and its position is suspect. {NO_PLANNING}
  remedy  {LOOK_AND_HOME}
E705: the recorded position cannot be used (RECORD_UNUSABLE)
  cause   The file is damaged, or was saved for another arm or another calibration.
  effect  The arm stands still, and its position is unknown. {NO_PLANNING}
  remedy  Call `home()`.
E706: a motion was not acknowledged (ANSWER_LOST)
  cause   A motion was sent, and the controller's answer was lost: the arm may have moved or not.
  effect  The arm stands still once the motion has ended, its position is suspect, and error-stop is
          latched.
  remedy  {LOOK_RESET_HOME}
E707: the controller fell silent (SILENT)
  cause   The controller, or one of its drives, stopped answering, and may have lost power.
  effect  The arm stands still, or has sagged without current; its position is suspect, and
          error-stop is latched.
  remedy  Check power and cable, look at the arm, call `reset()`, then `home()`.
E708: the motion missed its goal (READ_BACK_DIFFERS)
  cause   The registers differ from the goal of the motion: a byte was lost.
  effect  The arm stands off its goal, its position is suspect, and error-stop is latched.
  remedy  {LOOK_RESET_HOME}
E709: the controller refused a motion (MOTION_REFUSED)
  cause   The motion was valid: a byte was probably corrupted on the wire.
  effect  {SUSPECT_LATCHED}
  remedy  {LOOK_RESET_HOME}
E710: homing failed (HOMING_FAILED)
  cause   A switch was not reached, or it closed too early, or homing was stopped.
  effect  The arm stands somewhere on its path, and its position is suspect. {NO_PLANNING}
  remedy  Look at the switches and the arm, call `reset()`, then `home()` again.
E711: stopped without a ramp (STOPPED_DEAD)
  cause   An emergency stop ended the motion without a ramp, so motors may have lost steps.
  effect  {SUSPECT_LATCHED}
  remedy  {LOOK_RESET_HOME}
E712: an alarm during a motion (ALARM)
  cause   A limit switch or a check of the controller ended the motion.
  effect  {SUSPECT_LATCHED}
  remedy  {LOOK_RESET_HOME}
E713: a position off the path (OFF_THE_PATH)
  cause   The controller reported a position that is not on the path of the motion.
  effect  The arm was stopped, its position is suspect, and error-stop is latched.
  remedy  {LOOK_RESET_HOME}
E714: the controller switched the motors off (SWITCHED_OFF)
  cause   Its watchdog, a fault or an idle timeout switched the motor current off.
  effect  **The arm can sag.** Its position is suspect, and error-stop is latched.
  remedy  Support the arm, look at it, call `reset()`, then `enable()` and `home()`.
E715: the motors were switched off (CURRENT_DROPPED)
  cause   The motor current was switched off on request.
  effect  **The arm can sag.** Its position is suspect. {NO_PLANNING}
  remedy  Call `enable()`, then `home()`. To avoid this, park the arm before you switch it off.
E716: the connection was lost during a motion (LOST_IN_MOTION)
  cause   The cable was pulled, or the adapter or the network went away, while the arm moved.
  effect  The arm finishes what was sent, then stops; its position is suspect.
  remedy  Plug the cable in, connect again, look at the arm, then call `home()`.
E717: the arm was moved from elsewhere (MOVED_BY_OTHERS)
  cause   The registers changed although this program sent nothing: a pendant or a hand moved the
          arm.
  effect  The arm stands where it was moved to, and its position is suspect. {NO_PLANNING}
  remedy  {LOOK_AND_HOME}
E718: the controller restarted (RESTARTED)
  cause   It sent its greeting again: it was reset, lost power, or restarts when its port is opened.
  effect  **The arm may have sagged in the meantime.** Its position is suspect, and error-stop is
          latched.
  remedy  Look at the arm, call `reset()`, `enable()` if the motors are off, then `home()`.
E719: the registers fell to zero (CONTROLLER_RESTARTED)
  cause   The controller was reset or lost power.
  effect  **The arm may have sagged in the meantime.** Its position is suspect. {NO_PLANNING}
  remedy  {LOOK_AND_HOME}
E720: the connection was lost and is back (LINK_BACK)
  cause   The registers have not changed, but an arm without encoders may have been moved by hand in
          the meantime.
  effect  The arm stands still, and error-stop is latched. After `reset()`, planned motion is
          refused until a person confirms the posture.
  remedy  Look at the arm, call `reset()`, then call `confirm_restored()`, or connect with
          `allow_restored=True`.
E721: the position was wrong at the mark (OFF_ITS_MARK)
  cause   `verify` found a difference between the counts and the mark, and the posture was not
          accepted as the new reference. Steps were lost, cables are slack, or the arm file has
          wrong numbers.
  effect  The arm stands at its mark, and its position is suspect. {NO_PLANNING}
  remedy  Call `home()` where the arm stands. If the drift comes back, look for what slips.
E722: a motion was cancelled (BROKEN_OFF)
  cause   The motion could not go on; the message gives the reason: a drive in another mode, an open
          door, a motor that does not come to rest.
  effect  The arm stands somewhere on its path, its position is suspect, and error-stop is latched.
  remedy  Fix what the message names, look at the arm, call `reset()`, then `home()`.

Bytes

E801: a message that does not exist in the dialect (ProtocolError)
  cause   armdrive sent or received a message that the controller's language does not have.
  effect  The message had no effect.
  remedy  Please report it: the driver should have caught it.
E802: a request that the dialect does not support (LocalProtocolError)
  cause   The controller's language has no such request, or not at this moment.
  effect  Nothing was sent, nothing moved.
  remedy  Choose another request; the controller's page in docs/ lists what it can do.
E803: a number out of range for the dialect (BadField)
  cause   A number does not fit into its field of the message.
  effect  Nothing was sent, nothing moved.
  remedy  Use a number that the message allows.
E804: unreadable bytes from the controller (RemoteProtocolError)
  cause   The line is noisy, the baud rate is wrong, or the controller speaks another dialect.
  effect  The unreadable bytes changed nothing; if they were an answer, that answer is missing.
  remedy  Check cable, baud rate and dialect; `armdrive doctor` listens and reports.
E805: G-code that a board would refuse (GcodeError)
  cause   A simulated board got a line with an unknown word or number.
  effect  The line changed nothing.
  remedy  Correct the line; the number after `error:` is GRBL's own.
"""
"""Every row by subject, laid out as `armdrive errors CODE` prints it.

A line that begins at the margin is a subject or a row; `{...}` stands for a sentence above.
"""

_ROW = re.compile(r"(E\d{3}): (.+) \((\w+)\)")
_LABEL = len("  remedy  ")


def _read(catalogue: str) -> Mapping[str, tuple[CatalogueEntry, ...]]:
    """Return the rows of the catalogue by subject."""
    groups: dict[str, list[CatalogueEntry]] = {}
    subject = ""
    unfolded = catalogue.replace("\n" + " " * _LABEL, " ")
    lines = iter([line for line in unfolded.splitlines() if line])
    for line in lines:
        row = _ROW.fullmatch(line)
        if row is None:
            subject = line
            continue
        code, title, name = row.groups()
        cause, effect, remedy = (next(lines)[_LABEL:].format(**_PHRASES) for _ in range(3))
        entry = CatalogueEntry(code, name, title, cause, effect, remedy)
        groups.setdefault(subject, []).append(entry)
    return MappingProxyType({subject: tuple(rows) for subject, rows in groups.items()})


GROUPS = _read(_CATALOGUE)
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
