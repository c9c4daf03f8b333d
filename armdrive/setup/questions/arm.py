"""Questions as rows of a table, and what a row becomes once earlier answers are known."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from armdrive.config.preset import LENGTHS
from armdrive.dialog.conversation import (
    Question,
    Reader,
    WrongAnswer,
    bounds,
    choice,
    number,
    numbers,
    whole,
    yes_or_no,
)
from armdrive.setup.draft import Draft, ratio

Fill = Callable[[Draft, str], str | None]
"""Makes a default, as somebody would type it, from the answers and the row's own `each`."""


def _always(_draft: Draft) -> bool:
    return True


def _once(_draft: Draft) -> Sequence[str]:
    return ("",)


def _no_default(_draft: Draft, _one: str) -> str | None:
    return None


def _no_choices(_draft: Draft) -> tuple[tuple[str, str], ...]:
    return ()


@dataclass(frozen=True, slots=True)
class ArmRow:
    """One row of the table: `{one}` in its key and words stands for each name of `each`.

    `read` makes the check from the answers before; `when` says whether the question is asked.
    """

    key: str
    words: str
    why: str
    read: Callable[[Draft], Reader]
    default: Fill = _no_default
    when: Callable[[Draft], bool] = _always
    each: Callable[[Draft], Sequence[str]] = _once
    choices: Callable[[Draft], tuple[tuple[str, str], ...]] = _no_choices

    def questions(self, draft: Draft) -> Iterator[Question]:
        """Give the questions that this row asks after these answers."""
        if not self.when(draft):
            return
        for one in self.each(draft):
            yield Question(
                self.key.replace("{one}", one),
                self.words.replace("{one}", one.replace("_", " ")),
                self.why,
                self.read(draft),
                self.default(draft, one),
                self.choices(draft),
            )


def fixed(reader: Reader) -> Callable[[Draft], Reader]:
    """Return what makes the same check whatever was answered."""
    return lambda _draft: reader


def plain(text: str) -> Fill:
    """Return what makes the same default whatever was answered."""
    return lambda _draft, _one: text


def gate(opens: str) -> Fill:
    """Return the default of "keep these?": yes, unless an answer behind the gate is given."""
    return lambda draft, _one: (
        "no" if any(k.startswith(opens) for k in draft.around.given) else "yes"
    )


def typed(values: Sequence[float]) -> str:
    """Return numbers as somebody would type them on one line."""
    return " ".join(f"{value:.6g}" for value in values)


# Questions about the arm itself: lengths or links, motors and gears, limits and speeds.

LENGTH = fixed(number(-5000.0, 5000.0, "mm"))
POSITIVE_LENGTH = fixed(number(0.1, 5000.0, "mm"))


def _is_preset(draft: Draft) -> bool:
    return draft.preset is not None and draft.measured


def _corrects(what: str, draft: Draft) -> bool:
    return draft.get(f"{what}.keep") is False


def _lengths(draft: Draft) -> tuple[str, ...]:
    return tuple(each.key for each in draft.template.links.lengths) if draft.template.links else ()


def _length(draft: Draft, one: str) -> str | None:
    links = draft.template.links
    found = next((each.mm for each in links.lengths if each.key == one), None) if links else None
    return None if found is None else f"{found:g}"


def _preset_length(draft: Draft, one: str) -> str:
    return f"{getattr(draft.preset and draft.preset.arm, one):g}"


def _own_links(draft: Draft) -> bool:
    return draft.preset is None and draft.template.links is None


def _types_links(draft: Draft) -> bool:
    return _own_links(draft) and draft.get("links.how") == "type"


def _typed_rows(draft: Draft) -> bool:
    """Tell whether rows of links are given beforehand."""
    return any(k.startswith("links.") for k in draft.around.given - {"links.how", "links.file"})


def _joint_names(line: str) -> tuple[str, ...]:
    names = tuple(line.replace(",", " ").split())
    if len(names) not in (5, 6) or len(set(names)) != len(names):
        raise WrongAnswer(f"five or six different names are needed, not {len(names)}: {line!r}")
    for name in names:
        if not name.isidentifier() or name in ("opening", "gripper"):
            raise WrongAnswer(f"{name!r} cannot name a joint: one word such as wrist_pitch")
    return names


def _link_file(draft: Draft) -> Reader:
    return draft.around.read_links


def _published(draft: Draft) -> bool:
    preset = draft.preset
    return preset is not None and preset.verified and preset.transmission is not None


def _asks_microsteps(draft: Draft) -> bool:
    if draft.by_encoder:
        return False
    return _asks_gears(draft) or (draft.published_motors and draft.template.half_steps)


def _asks_gears(draft: Draft) -> bool:
    return draft.measured and not draft.published_motors


def _gear(draft: Draft, one: str) -> str | None:
    links = draft.template.links
    return None if links is None else links.joints[draft.joints.index(one)].ratio


def _known_limits(draft: Draft) -> bool:
    return all(draft.limits_deg(joint) is not None for joint in draft.joints)


def _limits(draft: Draft, one: str) -> str | None:
    known = draft.limits_deg(one)
    return None if known is None else typed(known)


def _speed(draft: Draft, one: str) -> str:
    return f"{draft.speed_deg_s(one) or 15.0:.4g}"


_MOTORS = (
    ("published", "the arm's own, with the numbers that are published"),
    ("own", "other motors or gears: asked for one by one"),
)

ROWS = (
    ArmRow(
        "measured", "Have you measured this arm's lengths and steps?",
        "Nobody has published them. Without your numbers joints can be jogged, and Cartesian "
        "motion is refused.",
        fixed(yes_or_no), plain("no"),
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
        when=lambda draft: _is_preset(draft) and draft.get("lengths.keep", False) is False,
    ),
    ArmRow(
        "lengths.{one}", "Length {one}, in mm?",
        "Measured on your arm, between axes: docs/config.md shows from where to where.",
        LENGTH, _length, each=_lengths,
    ),
    ArmRow(
        "links.how", "Is there a model file with the link table, or will you type it?",
        "A model file is a TOML file; docs/model-file.md shows one.",
        fixed(choice(("file", "type"))),
        lambda draft, _one: "type" if _typed_rows(draft) else "file",
        when=_own_links,
    ),
    ArmRow(
        "links.file", "Where is the model file?", "Its path; its text is copied.", _link_file,
        when=lambda draft: _own_links(draft) and draft.get("links.how") == "file",
    ),
    ArmRow(
        "links.joints", "The joints' names, from the table to the hand?",
        "Five or six single words; they are used as in `armdrive move --joint shoulder=40`.",
        fixed(_joint_names), plain("base shoulder elbow wrist_pitch wrist_roll"),
        when=_types_links,
    ),
    ArmRow(
        "links.{one}", "Row of {one}: theta/deg d/mm a/mm alpha/deg?",
        "Standard Denavit-Hartenberg: theta is what the table's zero lies beyond the joint's.",
        fixed(numbers(("theta", "d", "a", "alpha"))),
        when=_types_links, each=lambda draft: draft.get("links.joints", ()),
    ),
    ArmRow(
        "motors", "Which motors does it have?",
        "Steps per turn of a joint are what turns angles into motor steps.",
        fixed(choice(("published", "own"))),
        lambda draft, _one: "own" if "full_steps" in draft.around.given else "published",
        when=_published, choices=lambda _draft: _MOTORS,
    ),
    ArmRow(
        "full_steps", "Full steps of a motor for one turn of its shaft?",
        "200 for motors of 1.8 degrees, 400 for 0.9, 48 for 7.5. Of closed-loop drives that count "
        "by their encoder: its counts, 16384 of the MKS drives; of CiA 402 drives the increments "
        "that they are set to (object 608F), 10000 of many.",
        fixed(whole(4, 1 << 20)),
        lambda draft, _one: str(draft.encoder_counts or 200), when=_asks_gears,
    ),
    ArmRow(
        "microsteps", "Microsteps for one full step?",
        "As the drivers' switches or registers are set; 2 for half-steps.",
        fixed(whole(1, 1024)),
        lambda draft, _one: "2" if draft.published_motors else "16", when=_asks_microsteps,
    ),
    ArmRow(
        "gear.{one}", "Gear of the {one} motor, turns of the motor for one of the joint?",
        "20:1 of a gearbox, teeth as 60/16 (joint over motor), or both: 60/16 * 5.18:1.",
        fixed(ratio), _gear, when=_asks_gears, each=lambda draft: draft.motors,
    ),
    ArmRow(
        "limits.keep", "Keep the known limits of the joints?",
        "Where the arm itself stops; nothing is planned beyond.", fixed(yes_or_no),
        gate("limits."), when=lambda draft: bool(draft.joints) and _known_limits(draft),
    ),
    ArmRow(
        "limits.{one}", "Limits of {one}, lowest and highest in degrees?",
        "A few degrees before its mechanical stops.", fixed(bounds), _limits,
        when=lambda draft: not _known_limits(draft) or _corrects("limits", draft),
        each=lambda draft: draft.joints,
    ),
    ArmRow(
        "speeds.keep", "Keep the known speeds of the joints?", "At full load, without lost steps.",
        fixed(yes_or_no), gate("speeds."),
        when=lambda draft: all(draft.speed_deg_s(joint) is not None for joint in draft.joints),
    ),
    ArmRow(
        "speeds.{one}", "Highest speed of {one}, in degrees a second?",
        "Begin low: a stepper that loses steps does not say so.",
        fixed(number(0.01, 3600.0)), _speed,
        when=lambda draft: draft.get("speeds.keep", False) is False,
        each=lambda draft: draft.joints,
    ),
)  # fmt: skip
"""Asked after the wire, in this order."""
