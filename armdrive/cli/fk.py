"""Forward kinematics on the command line.

example: armdrive fk 0 40 -60 -70 0
"""

from __future__ import annotations

import argparse

from armdrive.cli.choosing import add_json_option
from armdrive.cli.numbers import number
from armdrive.cli.output import emit, say
from armdrive.view import joints_view, pose_view, violation_text
from kinematics import JOINT_NAMES, PRESETS, Joints, preset


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    for name in JOINT_NAMES:
        parser.add_argument(name, type=number, metavar=name, help="degrees")
    parser.add_argument("--model", default="teachmover", help=f"one of {', '.join(PRESETS)}")
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Print the pose, and the limits and guards that the posture would pass."""
    model = preset(options.model)
    joints = Joints.of(*(getattr(options, name) for name in JOINT_NAMES))
    pose = model.arm.fk(joints)
    broken = [violation_text(each) for each in model.arm.violations(joints)]
    broken += [each.sentence for each in model.guards.violations(model.arm, joints)]
    if options.json:
        emit(
            {
                "model": model.key,
                "joints": joints_view(joints),
                "pose": pose_view(pose),
                "violations": broken,
            }
        )
        return 0
    say(f"{model.title}: {joints}")
    say(f"tip {pose}")
    for sentence in broken:
        say(f"but: {sentence}")
    return 0
