"""How exact an arm is at a posture, and why: `armdrive explain accuracy [ARM] [JOINTS]`.

Source of the question: McKerrow, chapter 4, section 14.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from armdrive.cli.options import number
from armdrive.cli.presenter import emit, say, say_lines
from armdrive.errors import BadRequest, Refused
from kinematics.presets import ArmPreset, preset
from kinematics.spaces import Joints
from kinematics.textbook.accuracy import (
    TipError,
    explain_resolution,
    gearing_errors,
    length_errors,
    rounding_bound_mm,
    rounding_rms_mm,
    step_errors,
    zero_errors,
)
from kinematics.transmission import Transmission

DEFAULT_ARM = "minimover5"
DEFAULT_DEG = (0.0, 40.0, -60.0, -70.0, 0.0)
STATED_MM = 0.28
"""The resolution that the Mini-mover's papers state."""

GROUPS = ("a motor step", "1 mm of a length", "0.1 degrees of a zero", "1 % of a gearing")


def explain_accuracy(words: Sequence[str], *, as_json: bool) -> None:
    """Print what steps, lengths, zeros and gearings do to the tip of an arm in a posture."""
    model = preset(words[0] if words else DEFAULT_ARM)
    transmission = model.transmission
    if transmission is None:
        raise Refused(f"no motor steps are known of the {model.title}")
    joints = _posture(words[1:])
    errors = _errors(model, transmission, joints)
    bound_mm = rounding_bound_mm(model.arm, transmission, joints)
    rms_mm = rounding_rms_mm(model.arm, transmission, joints)
    sentences = explain_resolution(model.arm, transmission, STATED_MM)
    if as_json:
        emit(
            {
                "arm": model.key,
                "joints_deg": list(joints.deg.values()),
                "errors": [
                    {"group": group, **asdict(each), "distance_mm": each.distance_mm}
                    for group, each in errors
                ],
                "rounding_rms_mm": rms_mm,
                "rounding_bound_mm": bound_mm,
                "resolution": list(sentences),
            }
        )
        return
    say(f"{model.title} at {joints}")
    for group in GROUPS:
        say_lines(f"\nwhat {group} does to the tip")
        for each in (error for of, error in errors if of == group):
            say(f"  {each.cause:<16}{each.distance_mm:8.3f} mm")
    say_lines(f"\nrounding to whole steps: {rms_mm:.3f} mm in the mean, {bound_mm:.3f} mm at most")
    say_lines(f"\nthe stated resolution of {STATED_MM} mm")
    for sentence in sentences:
        say(f"  {sentence}")


def _posture(words: Sequence[str]) -> Joints:
    if words and len(words) != len(DEFAULT_DEG):
        raise BadRequest(f"{len(DEFAULT_DEG)} joint angles in degrees are needed, not {len(words)}")
    return Joints.of(*(number(word) for word in words) if words else DEFAULT_DEG)


def _errors(
    model: ArmPreset, transmission: Transmission, joints: Joints
) -> list[tuple[str, TipError]]:
    arm = model.arm
    columns = (
        step_errors(arm, transmission, joints),
        length_errors(arm, joints),
        zero_errors(arm, joints),
        gearing_errors(arm, transmission, joints),
    )
    return [(group, each) for group, column in zip(GROUPS, columns, strict=True) for each in column]
