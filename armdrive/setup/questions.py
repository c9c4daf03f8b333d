"""The questions that make an arm file, each declared once: words, check, place in the file.

They are asked in the order of the table. A row is asked once for every name of its `each`, if its
`when` holds after the answers so far. For example the row `speeds.{one}` makes the question
"Highest speed of base, in degrees a second?" with the key `speeds.base`, and its answer becomes
`base = 20` under `[speeds_deg_s]`. What the template knows is not asked, but may be given.

The interview takes questions from the rows (`ArmRow.questions`), filing takes the entries of the
arm file from the same rows (`ArmRow.entries`): so a question and its place cannot part.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.config.preset import LENGTHS
from armdrive.config.sections import wrong_homing_order
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
    text,
    whole,
    yes_or_no,
)
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import require_name
from armdrive.setup.draft import Draft, ratio, read_links
from armdrive.setup.templates import GRIPPERS, TEMPLATES
from armdrive.text.toml import TomlEntry
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

    `read` makes the check from the answers before. `when` says whether the question is asked.
    `{dialect}` in `place` is the section of the controller. `put` makes the section's entries if
    the answer is not the value itself.
    """

    key: str
    words: str
    why: str
    read: Callable[[Draft], Reader]
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
            yield Question(
                self.words.replace("{one}", shown_name(one)),
                self.why,
                controllers_reader(draft, self.place, self.read(draft)),
                # the template knows the arm better than the row does
                draft.usual_answers.get(key, usual),
                self.choices(draft),
                key,
            )

    def entries(self, draft: Draft) -> Iterator[tuple[str, Entries]]:
        """Yield the sections, and their entries, that the answers to this row make."""
        for one in self.each(draft) if self.place and self.when(draft) else ():
            answer = draft.answers[self.key.replace("{one}", one)]
            place = self.place.replace("{one}", one).replace(DIALECT, draft.dialect.name)
            section, _, key = place.rpartition(".")
            entry = TomlEntry(key, answer, MEANINGS.get(key, ""))
            yield section, (entry,) if self.put is None else self.put(draft, answer)


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


def unknown(
    key: str, known: Callable[[Draft, str], object], names: Callable[[Draft], Sequence[str]]
) -> Callable[[Draft], Sequence[str]]:
    """Return the names to ask about: those without a known value, and those that are given."""

    def asked(draft: Draft) -> Sequence[str]:
        given = draft.around.given
        return [one for one in names(draft) if known(draft, one) is None or f"{key}.{one}" in given]

    return asked


def typed(values: Sequence[float]) -> str:
    """Return numbers as text on one line."""
    return " ".join(f"{value:.6g}" for value in values)


def _names(names: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Return choices without explanations."""
    return tuple((name, "") for name in names)


# What the rows look up in the answers, in the order of the rows.


def _name(line: str) -> str:
    try:
        require_name(line)
    except BadRequest as error:
        raise WrongAnswer(str(error)) from None
    return line


def _ports(draft: Draft) -> tuple[str, ...]:
    return draft.around.buses if draft.dialect.can else draft.around.ports


def _port(draft: Draft) -> Reader:
    known, on_bus = _ports(draft), draft.dialect.can

    def read(line: str) -> str:
        if line in ("", "none"):
            return ""
        if (listed := numbered(line, known)) is not None:
            return listed
        if on_bus:
            with contextlib.suppress(BadRequest):
                return str(CanAddress.parse(line))
        marks = any(mark in line for mark in ("/", "\\")) or line.upper()[:3] == "COM"
        if not on_bus and (marks or is_can(line)):
            return line
        example = "can:slcan:/dev/ttyACM0?bitrate=500000" if on_bus else "/dev/ttyUSB0, COM3"
        raise WrongAnswer(
            f"{line!r} names no port of a {draft.dialect.name} controller: write it as {example}, "
            "or none for now"
        )

    return read


def _kept_dtr(_draft: Draft, keep: bool) -> Entries:
    if not keep:
        return ()
    return (
        TomlEntry("raise_dtr", True, "the board resets when DTR rises ..."),
        TomlEntry("keep_dtr_on_close", True, "... so it stays up between programs"),
    )


def _presets_length(draft: Draft, one: str) -> str:
    return f"{getattr(draft.preset and draft.preset.arm, one):g}"


def _known_length(draft: Draft, one: str) -> str | None:
    known = draft.preset is not None and draft.preset.verified
    return _presets_length(draft, one) if known else None


def _models_length(draft: Draft, one: str) -> str | None:
    path = draft.template.lengths[one]
    return None if draft.links is None else f"{draft.links.length_mm(path):g}"


def _asks_gears(draft: Draft) -> bool:
    return draft.measured and not draft.published_motors


def _asks_microsteps(draft: Draft) -> bool:
    if draft.encoder_counts is not None:
        return False
    return _asks_gears(draft) or (draft.published_motors and draft.template.half_steps)


def _fingers(_draft: Draft, range_mm: tuple[float, float]) -> Entries:
    return TomlEntry("range_mm", range_mm), TomlEntry("speed_mm_s", 10, "low, to begin with")


def _homes(draft: Draft) -> bool:
    return bool(draft.get("homing.own"))


# The default distance from a limit at which a joint stands after homing.
PULLED_OFF_DEG = 2.0


def _homed_at(draft: Draft, one: str) -> str:
    upwards = draft.preset is not None or draft.direction(one) > 0
    low, high = draft.get(f"limits.{one}") or draft.limits_deg(one) or (-180.0, 180.0)
    return f"{high - PULLED_OFF_DEG if upwards else low + PULLED_OFF_DEG:g}"


def homing_order(draft: Draft) -> Reader:
    """Return a reader for motor numbers: "3; 2; 1 4 5" homes 3, then 2, then the others."""
    motors = len(draft.all_motors)

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


def _posture(draft: Draft) -> Reader:
    names = tuple(POSE_FIELDS)
    read = numbers(names if len(draft.joints) == 6 else names[:-1])
    return lambda line: () if line in ("", "none") else tuple(read(line))


def _posture_entries(_draft: Draft, numbers: Sequence[float]) -> Entries:
    return tuple(map(TomlEntry, COORDINATES, numbers))


def _has(key: str) -> Callable[[Draft], bool]:
    """Return whether the controller's own section has a key."""
    return lambda draft: key in draft.device_fields


def _all_different(draft: Draft, what: str, read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Return a reader for as many different values as the arm has motors."""
    count = len(draft.all_motors)

    def different(line: str) -> Any:
        found = read(line)
        if len(found) != count or len(set(found)) != count:
            raise WrongAnswer(f"{count} different {what} are needed, not {line!r}")
        return found

    return different


def _nodes(draft: Draft) -> Reader:
    node = whole(1, 127)
    return _all_different(
        draft, "numbers", lambda line: tuple(map(node, line.replace(",", " ").split()))
    )


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
        lambda _draft: choice(tuple(TEMPLATES)),
        choices=lambda _draft: tuple((key, row.title) for key, row in TEMPLATES.items()),
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
        "A serial port, or an address such as socket://HOST:PORT. Of drives on a CAN bus, the "
        "adapter: can:slcan:/dev/ttyACM0?bitrate=500000, or can:socketcan:can0. This interview "
        "opens no port. `armdrive ports` lists them: unplug the arm's to see which one it is.",
        _port, "none", choices=lambda draft: _names(_ports(draft)), place="connection.port",
    ),
    ArmRow(
        "connection.baud", "At how many baud?", "The dialect's own rate, unless you changed it.",
        fixed(whole(50, 4_000_000)), lambda draft, _one: str(draft.dialect.baud),
        # a bus has its rate in its port
        when=lambda draft: not draft.dialect.can or "connection.baud" in draft.around.given,
        place="connection.baud",
    ),
    ArmRow(
        "connection.keep_dtr", "Keep the board from resetting when its port is opened again?",
        "Such a board resets when DTR rises; it then loses the position and lets the motors go. If "
        "DTR stays up between programs, only the first opening resets it.",
        fixed(yes_or_no), "yes", place="connection.", put=_kept_dtr,
        when=lambda draft: (
            draft.dialect.abilities.resets_on_open and bool(draft.get("connection.port"))
        ),
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
        "lengths.{one}", "Length {one}?", "Measured between axes, in mm.",
        fixed(number(0.1, 5000.0, "mm")), _presets_length,
        each=unknown("lengths", _known_length, lambda _draft: LENGTHS),
        when=lambda draft: draft.preset is not None and draft.measured, place="lengths.{one}",
    ),
    ArmRow(
        "lengths.{one}", "Length {one}, in mm?",
        "Measured on your arm, between axes; docs/how-to/describing-the-arm.md shows the "
        "end points.",
        fixed(number(-5000.0, 5000.0, "mm")), _models_length,
        each=lambda draft: tuple(draft.template.lengths),
    ),
    ArmRow(
        "links.file", "Where is the model file with its link table?",
        "The path of a TOML file or a URDF; its text is copied. docs/reference/arm-file.md shows "
        "one.",
        fixed(read_links), when=lambda draft: draft.preset is None and not draft.template.model,
    ),
    # motors: what makes steps of angles; for a preset with its own motors all of it is known
    ArmRow(
        "motors", "Which motors does it have?",
        "Steps per turn of a joint convert angles into motor steps.",
        fixed(choice(("published", "own"))),
        lambda draft, _one: "own" if "full_steps" in draft.around.given else "published",
        when=lambda draft: (
            draft.preset is not None and draft.preset.verified and bool(draft.preset.transmission)
        ),
        choices=lambda _draft: (
            ("published", "the original ones, with their published numbers"),
            ("own", "other motors or gears: the numbers are asked one by one"),
        ),
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
    ArmRow(
        "limits.{one}", "Limits of {one}, lowest and highest in degrees?",
        "A few degrees before its mechanical stops: no motion is planned beyond them.",
        fixed(bounds), lambda draft, one: typed(draft.limits_deg(one) or ()) or None,
        each=unknown("limits", Draft.limits_deg, lambda draft: draft.joints),
        place="limits_deg.{one}",
    ),
    ArmRow(
        "speeds.{one}", "Highest speed of {one}, in degrees a second?",
        "Begin low: a stepper that loses steps gives no sign of it.",
        fixed(number(0.01, 3600.0)), lambda draft, one: f"{draft.speed_deg_s(one) or 15.0:.4g}",
        each=unknown("speeds", Draft.speed_deg_s, lambda draft: draft.joints),
        place="speeds_deg_s.{one}",
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
        "fingers.mm_per_turn", "How many mm do the fingers open for one turn of their motor?",
        "One turn of the motor's shaft. Turn it ten times and measure.",
        fixed(number(0.01, 1000.0, "mm")),
        when=lambda draft: draft.stepped and _asks_gears(draft),
    ),
    ArmRow(
        "fingers.range", "Opening of the fingers, closed and widest, in mm?", "Between the tips.",
        fixed(bounds), "0 76", when=lambda draft: draft.preset is None and draft.gripper != "none",
        place="fingers.", put=_fingers,
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
    # which axis or node drives which motor: wiring, so it comes last
    ArmRow(
        "device.axes", "Which axis of the board drives each motor, in the arm's order?",
        "One letter for each motor. If a plug is in another socket, change the letters' order.",
        lambda draft: _all_different(
            draft, "letters", lambda line: line.replace(" ", "").upper()
        ),
        lambda draft, _one: str(draft.device_fields["axes"])[: len(draft.all_motors)],
        when=_has("axes"),
        place="{dialect}.axes",
    ),
    ArmRow(
        "device.ids", "Which node is the drive of each motor, in the arm's order?",
        "Node numbers, 1 to 127, as the drives' own program or switches set them. `armdrive doctor "
        "--can` lists the nodes on the bus.",
        _nodes,
        lambda draft, _one: " ".join(str(1 + each) for each in range(len(draft.all_motors))),
        when=_has("master_id"),
        place="{dialect}.ids",
    ),
)  # fmt: skip
