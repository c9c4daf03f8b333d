"""The options of the commands that compute and explain, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from armdrive.cli.options import Declare, add_force_option, add_json_option, add_switches
from armdrive.text.numbers import number
from kinematics.presets import PRESETS
from kinematics.spaces import JOINT_NAMES


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

    Every error message begins with its code in brackets.

    Examples:
      armdrive errors                      all errors, a line each
      armdrive errors E502
      armdrive errors --find lost,cable

    """
    parser.add_argument(
        "code", nargs="?", metavar="CODE", help="the code of an error, for example E502"
    )
    parser.add_argument(
        "--find", metavar="WORDS", help="the errors with all these words, separated by commas"
    )
    add_json_option(parser)


# --- explain


EFFICIENCY, ACCURACY = "efficiency", "accuracy"
STUDIES = (EFFICIENCY, ACCURACY)
"""Words in the place of a system: studies of several."""


def _explain(parser: argparse.ArgumentParser) -> None:
    """Compute an arm step by step: link table, A matrices, forward and inverse.

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
    parser.add_argument("system", nargs="?", metavar="SYSTEM", help="a name or a .toml file")
    parser.add_argument(
        "joints", nargs="*", metavar="JOINT", help="degrees (revolute) or mm (prismatic)"
    )
    parser.add_argument(
        "--goal",
        nargs="+",
        type=number,
        metavar="NUMBER",
        help="solve for this goal, in mm and degrees",
    )
    switches = {
        "--list": "list the named systems",
        "--symbolic": "A matrices, their product and the solutions in symbols: C1, S12",
        "--latex": "the same in LaTeX",
        "--urdf": "print the arm as URDF",
        "--axes": "find frames and link table from the joint axes, step by step",
    }
    add_switches(parser.add_mutually_exclusive_group(), switches)
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

    Joint values are in degrees (mm for a sliding joint), in the order of the joints. Those of a
    built-in arm count from the link before, up is positive, as in its arm file; `armdrive explain
    MODEL` shows how those of any model count. Limits and guards that the posture violates are
    printed below the pose.

    Examples:
      armdrive fk 0 40 -60 -70 0
      armdrive fk --model alpha2 0 40 -60 -70 0

    """
    parser.add_argument(
        "joints",
        nargs="+",
        type=number,
        metavar="JOINT",
        help=f"degrees: {', '.join(JOINT_NAMES)}, or the joints of --model",
    )
    _add_model(parser)
    add_json_option(parser)


# --- ik


def _ik(parser: argparse.ArgumentParser) -> None:
    r"""Compute the joint angles that bring the finger tips to a pose.

    Every solution is printed, with the limits that rule it out, and then the one that is used. For
    a link table without a closed form a numerical solver finds one solution. Except for a built-in
    arm, leave out --pitch or --roll to leave that angle free. Angles count as `armdrive fk` takes
    them.

    Examples:
      armdrive ik --x 250 --y 0 --z 120 --pitch -90
      armdrive ik --model puma --x 400 --y 100 --z 200 \
          --pitch -90 --roll 0 --yaw 15

    """
    for axis in ("x", "y", "z"):
        parser.add_argument(
            f"--{axis}", type=number, required=True, metavar="MM", help="of the finger tips"
        )
    parser.add_argument(
        "--pitch",
        type=number,
        metavar="DEG",
        help="elevation of the hand; -90 points at the table",
    )
    parser.add_argument(
        "--roll", type=number, metavar="DEG", help="of the hand (built-in arms: 0 by default)"
    )
    parser.add_argument(
        "--yaw",
        type=number,
        metavar="DEG",
        help="direction of the hand about the vertical, for models with six joints",
    )
    _add_model(parser)
    add_json_option(parser)


# --- plot


def _plot(parser: argparse.ArgumentParser) -> None:
    """Draw what an arm can reach.

    For an arm of the Mini-mover's build, the outline is where the finger tips can go in a vertical
    plane through the base axis, with the hand at a fixed pitch. For any other arm, dots show places
    that its tool reached, from the side and from above, or of a planar arm in its plane.

    Examples:
      armdrive plot --pitch -90
      armdrive plot --model puma --ascii

    """
    _add_model(parser)
    parser.add_argument(
        "--pitch",
        type=number,
        metavar="DEG",
        help="of the hand; -90 points at the table (default -90)",
    )
    parser.add_argument(
        "--azimuth",
        type=number,
        metavar="DEG",
        help="direction of the plane; 0 is straight ahead (default 0)",
    )
    parser.add_argument(
        "--output", type=Path, metavar="FILE", help="draw into this .png or .svg file"
    )
    add_force_option(parser)
    parser.add_argument("--ascii", action="store_true", help="draw with plain characters")
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
