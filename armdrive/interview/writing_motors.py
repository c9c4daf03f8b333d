"""The motors of an arm file: steps per turn as a sum, and which joints a motor sees which way."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.interview.draft import GRIPPER_MOTOR, HALF_STEP, Draft
from armdrive.interview.templates import COUPLED
from armdrive.interview.toml_text import Entry, Section


def steps_section(draft: Draft) -> Section:
    """Return [steps_per_turn] of a Mini-mover's build, empty where it is the preset's."""
    if not draft.measured or (draft.published_motors and not draft.template.half_steps):
        return Section("steps_per_turn", ())
    return Section("steps_per_turn", tuple(_turning(draft, motor) for motor in draft.motors))


def gripper_entry(draft: Draft) -> list[Entry]:
    """Return `steps_per_mm` of the gripper's motor, nothing where it is the preset's."""
    if draft.published_motors:
        if not draft.template.half_steps:
            return []
        published = draft.published_steps(GRIPPER_MOTOR)
        return [Entry("steps_per_mm", _short(published), _microstepped(draft))]
    return [Entry("steps_per_mm", _short(draft.gripper_steps_per_mm), _pulled(draft))]


def array_of_motors(draft: Draft) -> Iterator[Section]:
    """Give [[motors]] of an arm of a link table, each with the joint that it sees."""
    reversed_motors = draft.get("reversed.motors", ())
    reversed_joints = draft.get("reversed.joints", ())
    for motor in draft.motors:
        turned = (motor in reversed_motors) != (motor in reversed_joints)
        sign = draft.direction(motor) * (-1 if turned else 1)
        entries = (
            Entry("name", motor),
            _named(_turning(draft, motor), "steps_per_turn"),
            Entry("sees", {motor: sign}, "-1: it counts up as the joint goes down" * (sign < 0)),
        )
        yield Section("motors", entries, array=True)
    if draft.stepped:
        yield _gripper_motor(draft, set(reversed_motors))


def _gripper_motor(draft: Draft, reversed_motors: set[str]) -> Section:
    sign = -1 if GRIPPER_MOTOR in reversed_motors else 1
    entries = [
        Entry("name", GRIPPER_MOTOR),
        Entry("steps_per_mm", _short(draft.gripper_steps_per_mm), _pulled(draft)),
        Entry("sees", {"opening": sign}),
    ]
    if draft.gripper == COUPLED:
        over = draft.answers["gripper.over"]
        ratio = sign * (-1 if over in reversed_motors else 1)
        entries.append(Entry("follows", {over: ratio}, "steps added for each step of that motor"))
    return Section("motors", tuple(entries), array=True)


def _turning(draft: Draft, motor: str) -> Entry:
    if draft.published_motors:
        return Entry(motor, _short(draft.published_steps(motor)), _microstepped(draft))
    gearing = draft.gearing(motor)
    return Entry(motor, _short(gearing.steps_per_turn), str(gearing))


def _named(entry: Entry, key: str) -> Entry:
    return Entry(key, entry.value, entry.comment)


def _microstepped(draft: Draft) -> str:
    return f"the published half-steps at {draft.get('microsteps', HALF_STEP)} microsteps"


def _pulled(draft: Draft) -> str:
    answers = draft.answers
    return (
        f"{answers['full_steps']} full steps x {answers.get('microsteps', 1)} microsteps "
        f"/ {answers['fingers.mm_per_turn']:g} mm a turn"
    )


def _short(steps: float) -> float:
    """Return the number without digits that no arm has."""
    return float(f"{steps:.9g}")
