"""The options of the commands that compute and explain, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.options import Declare, add_force_option, add_json_option, add_options
from armdrive.text.numbers import number
from kinematics.presets import PRESETS


def _add_model(parser: argparse.ArgumentParser) -> None:
    models = f"one of {', '.join(PRESETS)}, a named system of `armdrive explain --list`"
    parser.add_argument(
        "--model",
        default="teachmover",
        help=f"{models}, or a file: a link table or an arm file (.toml), or a .urdf",
    )


# --- errors


def _errors(parser: argparse.ArgumentParser) -> None:
    """Look up an error by its code: its cause, its effect on the arm and what to do.

    Operands:
      [CODE]  the code of an error, for example E502

    Every error message begins with its code in brackets.

    Examples:
      armdrive errors                      all errors, a line each
      armdrive errors E502

    """
    add_options(parser, _errors)
    add_json_option(parser)


# --- explain


EFFICIENCY, ACCURACY = "efficiency", "accuracy"
# Words in the place of a system: studies of several.
STUDIES = (EFFICIENCY, ACCURACY)


def _explain(parser: argparse.ArgumentParser) -> None:
    """Compute an arm step by step: link table, A matrices, forward and inverse.

    Operands:
      [SYSTEM]           a name or a .toml file
      [JOINT ...]        degrees (revolute) or mm (prismatic)

    Options:
      --goal NUMBER ...  solve for this goal, in mm and degrees

    One of:
      --list             list the named systems
      --symbolic         A matrices, their product and the solutions in symbols: C1, S12
      --latex            the same in LaTeX
      --urdf             print the arm as URDF
      --axes             find frames and link table from the joint axes, step by step

    SYSTEM is a named system (`armdrive explain --list`), a built-in arm, or your own: a link table
    or an arm file (.toml), or a .urdf. `efficiency` counts the operations of each way to compute a
    system. `accuracy` shows how motor steps and errors of the model displace the tip. Joint values
    are in degrees and mm, in the order of the joints; a line below the title says how angles
    count, which is the same in every command that takes the model. A goal is in the system's own
    coordinates. --axes finds frames and link table from the joint axes, in thirteen drawn steps; a
    .toml file may give axes instead of links (`[[axes]]`).

    Examples:
      armdrive explain --list
      armdrive explain two-link-1 30 40
      armdrive explain minimover5 --goal 250 0 120 -90 0
      armdrive explain puma --symbolic
      armdrive explain accuracy teachmover 0 40 -60 -70 0
      armdrive explain alpha2 --urdf
      armdrive explain --axes alpha2-lecture --convention craig

    """
    add_options(parser, _explain, {"NUMBER": number})
    parser.add_argument(
        "--convention",
        choices=["standard", "craig"],
        help="with --axes: frames at the far joint of a link (standard), or at the near one "
        "(craig); by default the arm's own",
    )
    add_json_option(parser)


# --- fk


def _fk(parser: argparse.ArgumentParser) -> None:
    """Compute the pose of the finger tips from joint angles.

    Operands:
      JOINT ...  degrees: base, shoulder, elbow, wrist_pitch, wrist_roll, or the joints of --model

    Joint values are in degrees (mm for a sliding joint), in the order of the joints. Those of a
    built-in arm count from the link before, up is positive, as in its arm file; `armdrive explain
    MODEL` shows how those of any model count. Limits and guards that the posture violates are
    printed below the pose.

    Examples:
      armdrive fk 0 40 -60 -70 0
      armdrive fk --model alpha2 0 40 -60 -70 0

    """
    add_options(parser, _fk, {"JOINT": number})
    _add_model(parser)
    add_json_option(parser)


# --- ik


def _ik(parser: argparse.ArgumentParser) -> None:
    r"""Compute the joint angles that bring the finger tips to a pose.

    Required:
      --x MM       of the finger tips
      --y MM       of the finger tips
      --z MM       of the finger tips

    Options:
      --pitch DEG  elevation of the hand; -90 points at the table
      --roll DEG   of the hand (built-in arms: 0 by default)
      --yaw DEG    direction of the hand about the vertical, for models with six joints

    Every solution is printed, with the limits that rule it out, and then the one that is used. For
    a link table without a closed form a numerical solver finds one solution. Except for a built-in
    arm, leave out --pitch or --roll to leave that angle free. Angles count as `armdrive fk` takes
    them.

    Examples:
      armdrive ik --x 250 --y 0 --z 120 --pitch -90
      armdrive ik --model puma --x 400 --y 100 --z 200 \
          --pitch -90 --roll 0 --yaw 15

    """
    add_options(parser, _ik)
    _add_model(parser)
    add_json_option(parser)


# --- plot


def _plot(parser: argparse.ArgumentParser) -> None:
    """Draw what an arm can reach.

    Options:
      --pitch DEG    of the hand; -90 points at the table (default -90)
      --azimuth DEG  direction of the plane; 0 is straight ahead (default 0)
      --output FILE  draw into this .png or .svg file
      --ascii        draw with plain characters

    For an arm of the Mini-mover's build, the outline is where the finger tips can go in a vertical
    plane through the base axis, with the hand at a fixed pitch. For any other arm, dots show places
    that its tool reached, from the side and from above, or of a planar arm in its plane.

    Examples:
      armdrive plot --pitch -90
      armdrive plot --model puma --ascii

    """
    _add_model(parser)
    add_options(parser, _plot)
    add_force_option(parser)
    add_json_option(parser)


ARGUMENTS: Mapping[str, Declare] = MappingProxyType(
    {
        "errors": _errors,
        "explain": _explain,
        "fk": _fk,
        "ik": _ik,
        "plot": _plot,
    }
)
