"""The questions that make an arm file, each declared once: words, check, place in the file.

They are asked in the order of the table. A row is asked once for every name of its `each`, if its
`when` holds after the answers so far. For example the row `speeds.{one}` makes the question
"Highest speed of base, in degrees a second?" with the key `speeds.base`, and its answer becomes
`base = 20` under `[speeds_deg_s]`.

The interview takes questions from the rows (`ArmRow.questions`), filing takes the entries of the
arm file from the same rows (`ArmRow.entries`): so a question and its place cannot part.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from types import MappingProxyType
from typing import Any, get_type_hints

from armdrive.config.preset import LENGTHS
from armdrive.config.sections import Connection, FingerModel, wrong_homing_order
from armdrive.config.write import MEANINGS
from armdrive.dialog import (
    Question,
    Reader,
    WrongAnswer,
    bounds,
    choice,
    number,
    numbered,
    numbers,
    plain_number,
    several,
    text,
    whole,
    yes_or_no,
)
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import ENDING, require_name
from armdrive.setup.draft import GRIPPER_MOTOR, Draft, ratio, read_links
from armdrive.setup.templates import COUPLED, GRIPPERS, available
from armdrive.text.toml import TomlEntry, rule_of
from armdrive.transports.address import CanAddress, is_can
from kinematics.spaces import COORDINATES, POSE_FIELDS
from kinematics.text import shown_name

# Returns a default, as the user would type it, from the answers and a name of the row's `each`.
Fill = Callable[[Draft, str], str | None]

Entries = tuple[TomlEntry, ...]

# Stands for the section of the controller in the place of a row.
DIALECT = "{dialect}"


@dataclass(frozen=True, slots=True)
class ArmRow:
    """One row of the table; `{one}` in its key, words and place stands for a name of `each`.

    `read` makes the check from the answers before; without it, the schema of the arm file checks
    the answer, a number, for the key at `place`. `when` says whether the question is asked.
    `{dialect}` in `place` is the section of the controller. `put` makes the section's entries if
    the answer is not the value itself.
    """

    key: str
    words: str
    why: str
    read: Callable[[Draft], Reader] | None = None
    default: Fill | str | None = None
    when: Callable[[Draft], bool] = lambda _draft: True
    each: Callable[[Draft], Sequence[str]] = lambda _draft: ("",)
    choices: Callable[[Draft], tuple[tuple[str, str], ...]] = lambda _draft: ()
    place: str = ""
    put: Callable[[Draft, Any], Entries] | None = None

    def questions(self, draft: Draft) -> Iterator[Question]:
        """Yield the questions of this row after these answers."""
        for one in self.each(draft) if self.when(draft) else ():
            key, default = self.key.replace("{one}", one), self.default
            usual = default(draft, one) if callable(default) else default
            words = self.words.replace("{one}", shown_name(one))
            read = schema_reader(self.place) if self.read is None else self.read(draft)
            yield Question(
                words,
                self.why,
                controllers_reader(draft, self.place, read),
                # the template knows the arm better than the row does
                draft.usual_answers.get(key, usual),
                self.choices(draft),
                key,
            )

    def entries(self, draft: Draft) -> Iterator[tuple[str, Entries]]:
        """Yield the sections, and their entries, that the answers to this row make."""
        for one in self.each(draft) if self.place and self.when(draft) else ():
            answer = draft.get(self.key.replace("{one}", one), ())
            place = self.place.replace("{one}", one).replace(DIALECT, draft.dialect.name)
            section, _, key = place.rpartition(".")
            if answer == ():  # not asked, or answered by none
                continue
            entry = TomlEntry(key, answer, MEANINGS.get(key, ""))
            yield section, (entry,) if self.put is None else self.put(draft, answer)


SECTIONS: Mapping[str, type[Any]] = MappingProxyType(
    {"connection": Connection, "fingers": FingerModel}
)


@cache
def schema_reader(place: str) -> Reader:
    """Return what reads a number as the schema of the arm file allows it at a place."""
    section, _, key = place.rpartition(".")
    kind = SECTIONS[section]
    rule = rule_of(next(each for each in fields(kind) if each.name == key))
    plain = whole(-sys.maxsize, sys.maxsize) if get_type_hints(kind)[key] is int else plain_number

    def read(line: str) -> Any:
        value = plain(line)
        try:
            rule.check(value, place)
        except ArmFileError as error:
            raise WrongAnswer(str(error)) from None
        return value

    return read


def controllers_reader(draft: Draft, place: str, plain: Reader) -> Reader:
    """Return what also refuses an answer that the controller's section does not allow at a place.

    A section checks more than the bounds of its keys. Without this, the finished file is refused,
    and with it all answers are lost.
    """
    name, _, key = place.rpartition(".")
    if name != DIALECT or not key:
        return plain

    def read(line: str) -> Any:
        value = plain(line)
        try:
            draft.dialect.settings()(**{key: value})
        except ArmFileError as error:
            raise WrongAnswer(str(error)) from None
        return value

    return read


def fixed(reader: Reader) -> Callable[[Draft], Reader]:
    """Return a check that does not depend on earlier answers."""
    return lambda _draft: reader


def gate(opens: str) -> Fill:
    """Return the default of "keep these?": yes, unless a value for one of them is given."""
    return lambda draft, _one: (
        "no" if any(k.startswith(opens) for k in draft.around.given) else "yes"
    )


def typed(values: Sequence[float]) -> str:
    """Return numbers as text on one line."""
    return " ".join(f"{value:.6g}" for value in values)


def _names(names: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Return choices without explanations."""
    return tuple((name, "") for name in names)


# Questions about the arm itself: lengths or links, motors and gears, limits and speeds.

LENGTH = fixed(number(-5000.0, 5000.0, "mm"))
POSITIVE_LENGTH = fixed(number(0.1, 5000.0, "mm"))


def _is_preset(draft: Draft) -> bool:
    return draft.preset is not None and draft.measured


def _keeps(what: str, draft: Draft) -> bool:
    """Return whether the known values are kept; where there are none, that is not asked."""
    return bool(draft.get(f"{what}.keep", False))


def _length(draft: Draft, one: str) -> str | None:
    path = draft.template.lengths[one]
    return None if draft.links is None else f"{draft.links.length_mm(path):g}"


def _preset_length(draft: Draft, one: str) -> str:
    return f"{getattr(draft.preset and draft.preset.arm, one):g}"


def _own_links(draft: Draft) -> bool:
    return draft.preset is None and not draft.template.model


def _published(draft: Draft) -> bool:
    preset = draft.preset
    return preset is not None and preset.verified and preset.transmission is not None


def _asks_microsteps(draft: Draft) -> bool:
    if draft.by_encoder:
        return False
    return _asks_gears(draft) or (draft.published_motors and draft.template.half_steps)


def _asks_gears(draft: Draft) -> bool:
    return draft.measured and not draft.published_motors


def _known_limits(draft: Draft) -> bool:
    return all(draft.limits_deg(joint) is not None for joint in draft.joints)


def _limits(draft: Draft, one: str) -> str | None:
    known = draft.limits_deg(one)
    return None if known is None else typed(known)


def _speed(draft: Draft, one: str) -> str:
    return f"{draft.speed_deg_s(one) or 15.0:.4g}"


_MOTORS = (
    ("published", "the original ones, with their published numbers"),
    ("own", "other motors or gears: the numbers are asked one by one"),
)


# The first questions: the name, the template, the wire.


def _name(line: str) -> str:
    if line.endswith(ENDING):
        raise WrongAnswer(f"the name without its ending: {line.removesuffix(ENDING)}")
    try:
        require_name(line)
    except BadRequest as error:
        raise WrongAnswer(str(error)) from None
    return line


def _ports(draft: Draft) -> tuple[str, ...]:
    return draft.around.buses if draft.dialect.can else draft.around.ports


def _port(draft: Draft) -> Reader:
    known = _ports(draft)

    def read(line: str) -> str:
        if line in ("", "none"):
            return ""
        if (listed := numbered(line, known)) is not None:
            return listed
        return _adapter(line) if draft.dialect.can else _serial_port(line)

    return read


def _serial_port(line: str) -> str:
    written = any(mark in line for mark in ("/", "\\", "://")) or line.upper()[:3] == "COM"
    if written or is_can(line):
        return line
    raise WrongAnswer(
        f"{line!r} names no port: write it in full (/dev/ttyUSB0, COM3, socket://HOST:PORT), or "
        "none for now"
    )


def _adapter(line: str) -> str:
    try:
        return str(CanAddress.parse(line))
    except BadRequest:
        raise WrongAnswer(
            f"{line!r} is no CAN adapter, and these drives are on a CAN bus: write it as "
            "can:slcan:/dev/ttyACM0?bitrate=500000 or can:socketcan:can0, or none for now"
        ) from None


def _kept_dtr(_draft: Draft, keep: bool) -> Entries:
    if not keep:
        return ()
    return (
        TomlEntry("raise_dtr", True, "the board resets when DTR rises ..."),
        TomlEntry("keep_dtr_on_close", True, "... so it stays up between programs"),
    )


def _on_bus(draft: Draft) -> bool:
    return draft.dialect.can


def _on_line(draft: Draft) -> bool:
    return not draft.dialect.can


def _has_baud(draft: Draft) -> bool:
    """Return whether the line has a baud rate of its own: a bus has it in its port."""
    return _on_line(draft) or "connection.baud" in draft.around.given


def _resets(draft: Draft) -> bool:
    return draft.dialect.abilities.resets_on_open and bool(draft.get("connection.port"))


# The gripper, homing, postures, guards, and the directions of the motors.

# The default distance from a limit at which a joint stands after homing.
PULLED_OFF_DEG = 2.0

# What a posture's numbers are called.
POSTURE = tuple(POSE_FIELDS)


def _posture(draft: Draft) -> Reader:
    read = numbers(POSTURE if len(draft.joints) == 6 else POSTURE[:-1])

    def posture(line: str) -> tuple[float, ...]:
        return () if line in ("", "none") else tuple(read(line))

    return posture


def _model_arm_steps(draft: Draft) -> bool:
    return draft.preset is None and draft.stepped


def _has_fingers(draft: Draft) -> bool:
    return draft.preset is None and draft.gripper != "none"


def _asks_fingers(draft: Draft) -> bool:
    return draft.stepped and draft.measured and not draft.published_motors


def _homes(draft: Draft) -> bool:
    return draft.dialect.abilities.own_homing and bool(draft.get("homing.own"))


def _homed_at(draft: Draft, one: str) -> str:
    upwards = draft.preset is not None or draft.direction(one) > 0
    low, high = draft.range_of(one)
    return f"{high - PULLED_OFF_DEG if upwards else low + PULLED_OFF_DEG:g}"


def _motor_names(draft: Draft) -> tuple[str, ...]:
    return (*draft.motors, GRIPPER_MOTOR) if draft.stepped else draft.motors


def _count(draft: Draft) -> int:
    """Return the number of motors, with the gripper's."""
    return len(_motor_names(draft))


def homing_order(draft: Draft) -> Reader:
    """Return a reader for motor numbers: "3; 2; 1 4 5" homes 3, then 2, then the others."""
    motors = _count(draft)

    def read(line: str) -> tuple[tuple[int, ...], ...]:
        if line in ("", "own"):
            return ()
        parts = [part.replace(",", " ").split() for part in line.split(";")]
        listed = tuple(tuple(whole(1, motors)(word) for word in part) for part in parts if part)
        if wrong := wrong_homing_order(listed, motors, len(draft.joints)):
            raise WrongAnswer(wrong)
        return listed

    return read


def _homes_itself(draft: Draft, own: bool) -> Entries:
    if not own or "homing" not in draft.device_fields:
        return ()
    return (TomlEntry("homing", True, "the board's own setting is checked against this"),)


def _posture_entries(_draft: Draft, numbers: Sequence[float]) -> Entries:
    return tuple(map(TomlEntry, COORDINATES, numbers))


def _has(key: str) -> Callable[[Draft], bool]:
    """Return whether the controller's own section has a key."""
    return lambda draft: key in draft.device_fields


def _axes(draft: Draft) -> Reader:
    count = _count(draft)

    def read(line: str) -> str:
        letters = line.replace(" ", "").upper()
        if len(letters) != count or len(set(letters)) != count or not letters.isalpha():
            raise WrongAnswer(f"{count} different letters are needed, one for each motor: {line!r}")
        return letters

    return read


def _nodes(draft: Draft) -> Reader:
    count, bus = _count(draft), draft.dialect.bus
    node = whole(1, bus.most if bus is not None else count)

    def read(line: str) -> tuple[int, ...]:
        found = tuple(node(word) for word in line.replace(",", " ").split())
        if len(found) != count or len(set(found)) != count:
            raise WrongAnswer(f"{count} different numbers are needed, one a drive: {line!r}")
        return found

    return read


# All questions, in the order in which they are asked.
ROWS = (
    # the arm and its wire: the template decides most of the defaults below
    ArmRow(
        "name", "What is the arm called?",
        "The arm file gets this name, and every command takes it: armdrive status --arm NAME.",
        fixed(_name),
    ),
    ArmRow(
        "template", "Which template does it begin from?",
        "A template brings a model, a dialect and defaults; every number can be changed below.",
        lambda _draft: choice(tuple(available())),
        choices=lambda _draft: tuple((key, row.title) for key, row in available().items()),
    ),
    ArmRow(
        "title", "A title?", "Shown wherever the arm is named.",
        fixed(text),
        lambda draft, _one: draft.preset.title if draft.preset else draft.name, place="title",
    ),
    ArmRow(
        "dialect", "Which dialect does its controller speak?",
        "The language of the controller's firmware. This interview sends nothing to find out.",
        lambda _draft: choice(tuple(DIALECTS)),
        lambda draft, _one: draft.template.dialect,
        choices=lambda _draft: tuple((row.name, row.title) for row in DIALECTS.values()),
    ),
    ArmRow(
        "connection.port", "Which port leads to it? (none: only simulated for now)",
        "A serial port, or an address such as socket://HOST:PORT. This interview opens no "
        "port. To see which one is the arm's, unplug it and run `armdrive ports` again.",
        _port, "none",
        choices=lambda draft: _names(_ports(draft)), when=_on_line,
        place="connection.port",
    ),
    ArmRow(
        "connection.port", "Which CAN adapter leads to its drives? (none: only simulated for now)",
        "Written can:INTERFACE:CHANNEL, followed by the bit rate if the adapter sets it: "
        "can:slcan:/dev/ttyACM0?bitrate=500000, or can:socketcan:can0. This interview opens none. "
        "`armdrive ports` lists them.",
        _port, "none", choices=lambda draft: _names(_ports(draft)), when=_on_bus,
        place="connection.port",
    ),
    ArmRow(
        "connection.baud", "At how many baud?", "The dialect's own rate, unless you changed it.",
        default=lambda draft, _one: str(draft.dialect.baud),
        when=_has_baud, place="connection.baud",
    ),
    ArmRow(
        "connection.keep_dtr", "Keep the board from resetting when its port is opened again?",
        "Such a board resets when DTR rises; it then loses the position and lets the motors go. If "
        "DTR stays up between programs, only the first opening resets it.",
        fixed(yes_or_no), "yes", when=_resets, place="connection.", put=_kept_dtr,
    ),
    # geometry: the lengths of a preset, or a model file
    ArmRow(
        "measured", "Have you measured this arm's lengths and steps?",
        "They are not published. Without your numbers joints can be jogged, but Cartesian motion "
        "is refused.",
        fixed(yes_or_no), "no",
        when=lambda draft: draft.preset is not None and not draft.preset.verified,
    ),
    ArmRow(
        "lengths.keep", "Keep the published lengths?",
        "Base height, upper arm, forearm, hand. Yours may differ by a millimetre or two.",
        fixed(yes_or_no), gate("lengths."),
        when=lambda draft: _is_preset(draft) and draft.preset.verified,  # type: ignore[union-attr]
    ),
    ArmRow(
        "lengths.{one}", "Length {one}?", "Measured between axes, in mm.", POSITIVE_LENGTH,
        _preset_length, each=lambda _draft: LENGTHS,
        when=lambda draft: _is_preset(draft) and not _keeps("lengths", draft),
        place="lengths.{one}",
    ),
    ArmRow(
        "lengths.{one}", "Length {one}, in mm?",
        "Measured on your arm, between axes; docs/how-to/describing-the-arm.md shows the "
        "end points.",
        LENGTH, _length, each=lambda draft: tuple(draft.template.lengths),
    ),
    ArmRow(
        "links.file", "Where is the model file with its link table?",
        "The path of a TOML file or a URDF; its text is copied. docs/reference/arm-file.md shows "
        "one.",
        fixed(read_links), when=_own_links,
    ),
    # motors: what makes steps of angles; for a preset with its own motors all of it is known
    ArmRow(
        "motors", "Which motors does it have?",
        "Steps per turn of a joint convert angles into motor steps.",
        fixed(choice(("published", "own"))),
        lambda draft, _one: "own" if "full_steps" in draft.around.given else "published",
        when=_published, choices=lambda _draft: _MOTORS,
    ),
    ArmRow(
        "full_steps", "Full steps of a motor for one turn of its shaft?",
        "200 for motors of 1.8 degrees, 400 for 0.9, 48 for 7.5. For drives that count by an "
        "encoder, its counts: 16384 for MKS drives; for CiA 402 drives the increments that they "
        "are set to (object 608F), often 10000.",
        fixed(whole(4, 1 << 20)),
        lambda draft, _one: str(draft.encoder_counts or 200), when=_asks_gears,
    ),
    ArmRow(
        "microsteps", "Microsteps for one full step?",
        "As set by the drivers' switches or registers; 2 for half-steps.",
        fixed(whole(1, 1024)),
        lambda draft, _one: "2" if draft.published_motors else "16", when=_asks_microsteps,
    ),
    ArmRow(
        "gear.{one}", "Gear of the {one} motor, turns of the motor for one of the joint?",
        "A gearbox as 20:1, teeth as 60/16 (joint over motor), or both: 60/16 * 5.18:1.",
        fixed(ratio), when=_asks_gears, each=lambda draft: draft.motors,
    ),
    # a question with `keep` spares those behind it, one for each joint
    ArmRow(
        "limits.keep", "Keep the known limits of the joints?",
        "The mechanical range; no motion is planned beyond it.", fixed(yes_or_no),
        gate("limits."), when=lambda draft: bool(draft.joints) and _known_limits(draft),
    ),
    ArmRow(
        "limits.{one}", "Limits of {one}, lowest and highest in degrees?",
        "A few degrees before its mechanical stops.", fixed(bounds), _limits,
        when=lambda draft: not _keeps("limits", draft),
        each=lambda draft: draft.joints, place="limits_deg.{one}",
    ),
    ArmRow(
        "speeds.keep", "Keep the known speeds of the joints?", "At full load, without lost steps.",
        fixed(yes_or_no), gate("speeds."),
        when=lambda draft: all(draft.speed_deg_s(joint) is not None for joint in draft.joints),
    ),
    ArmRow(
        "speeds.{one}", "Highest speed of {one}, in degrees a second?",
        "Begin low: a stepper that loses steps gives no sign of it.",
        fixed(number(0.01, 3600.0)), _speed,
        when=lambda draft: not _keeps("speeds", draft),
        each=lambda draft: draft.joints, place="speeds_deg_s.{one}",
    ),
    # the gripper: only the kinds that this controller can still move
    ArmRow(
        "gripper.kind", "What moves the gripper?",
        "A coupled stepper is the Mini-mover's: its cable passes over the elbow.",
        lambda draft: choice(draft.grippers),
        lambda draft, _one: draft.grippers[0],
        when=lambda draft: len(draft.grippers) > 1,
        choices=lambda draft: tuple((kind, GRIPPERS[kind]) for kind in draft.grippers),
    ),
    ArmRow(
        "gripper.over", "Which motor does the gripper's cable follow?",
        "Every step of that motor is added to the gripper's, so that the fingers stand still.",
        lambda draft: choice(draft.motors),
        lambda draft, _one: draft.motors[min(2, len(draft.motors) - 1)],
        when=lambda draft: _model_arm_steps(draft) and draft.gripper == COUPLED,
        choices=lambda draft: _names(draft.motors),
    ),
    ArmRow(
        "fingers.mm_per_turn", "How many mm do the fingers open for one turn of their motor?",
        "One turn of the motor's shaft. Turn it ten times and measure.",
        fixed(number(0.01, 1000.0, "mm")), when=_asks_fingers,
    ),
    ArmRow(
        "fingers.range", "Opening of the fingers, closed and widest, in mm?", "Between the tips.",
        fixed(bounds), "0 76", when=_has_fingers, place="fingers.range_mm",
    ),
    ArmRow(
        "fingers.speed", "How fast do the fingers open, in mm a second?", "Begin low.",
        default="10", when=_has_fingers, place="fingers.speed_mm_s",
    ),
    # where the arm finds its position: by switches, or at a posture
    ArmRow(
        "homing.own", "Does the arm home by its own switches?",
        "The controller then drives each motor to its switch when `armdrive home` asks for it.",
        fixed(yes_or_no), "no",
        when=lambda draft: draft.dialect.abilities.own_homing,
        place="{dialect}.", put=_homes_itself,
    ),
    ArmRow(
        "homing.joints.{one}", "Where does {one} stand after homing, in degrees?",
        "Measured on the arm, after the controller has pulled off its switch. Its own setting has "
        "to send each motor to that side: `armdrive doctor` compares it.",
        fixed(number(-3600.0, 3600.0)), _homed_at, when=_homes,
        each=lambda draft: draft.joints, place="homing.joints_deg.{one}",
    ),
    ArmRow(
        "homing.opening", "How far open are the fingers after homing, in mm?",
        "0 where they are closed.", fixed(number(0.0, 1000.0, "mm")), "0",
        when=lambda draft: _homes(draft) and draft.stepped, place="homing.opening_mm",
    ),
    ArmRow(
        "homing.groups", "Which motors home after which? (own: the controller's own order)",
        "By number: 3; 2; 1 4 5 homes motor 3, then 2, then 1, 4 and 5. Lift what could hit "
        "something first, but home a motor whose cable passes over a joint after that joint's.",
        homing_order, "own", when=_homes,
        place="homing.groups",
    ),
    ArmRow(
        "reference", "A posture that you can find again? x y z/mm pitch roll/deg (or none)",
        "An arm without switches counts its steps from there: finger tips on a mark, hand straight "
        "down. A sixth number is the yaw of an arm with six joints.",
        _posture, "none", when=lambda draft: draft.preset is None,
        place="reference.", put=_posture_entries,
    ),
    ArmRow(
        "park", "Where does it park? x y z/mm pitch roll/deg (none: above the reference)",
        "Where `armdrive move --park` goes. A sixth number is the yaw of an arm with six joints.",
        _posture, "none", place="park.", put=_posture_entries,
    ),
    # directions, and which axis or node drives which motor: wiring, so it comes last
    ArmRow(
        "reversed.motors", "Which motors count the other way? (names with commas, or none)",
        "The other way than the template has it. `armdrive config signs NAME` finds them out: each "
        "motor turns a little, and you say what you saw.",
        lambda draft: several(_motor_names(draft)), "none",
        choices=lambda draft: _names(_motor_names(draft)),
    ),
    ArmRow(
        "reversed.joints", "Which joints are reversed as a whole? (names with commas, or none)",
        "The wrist's roll, if its two motors are exchanged.",
        lambda draft: several(draft.joints), "none",
        choices=lambda draft: _names(draft.joints),
    ),
    ArmRow(
        "device.axes", "Which axis of the board drives each motor, in the arm's order?",
        "One letter for each motor. If a plug is in another socket, change the letters' order.",
        _axes,
        lambda draft, _one: str(draft.device_fields["axes"])[: _count(draft)],
        when=_has("axes"),
        place="{dialect}.axes",
    ),
    ArmRow(
        "device.ids", "Which node is the drive of each motor, in the arm's order?",
        "Node numbers, 1 to 127, as the drives' own program or switches set them. `armdrive doctor "
        "--can` lists the nodes on the bus.",
        _nodes,
        lambda draft, _one: " ".join(str(1 + each) for each in range(_count(draft))),
        when=_has("master_id"),
        place="{dialect}.ids",
    ),
)  # fmt: skip
