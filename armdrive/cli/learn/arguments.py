"""What may be typed after the commands that compute and explain, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from armdrive.cli.options import Arguments, add_json_option, number
from kinematics.presets import PRESETS
from kinematics.spaces import JOINT_NAMES


def _add_model(parser: argparse.ArgumentParser) -> None:
    models = f"one of {', '.join(PRESETS)}, a named system of `armdrive explain --list`"
    parser.add_argument(
        "--model", default="teachmover", help=f"{models}, or a .toml file with a link table"
    )


# --- errors


def _errors(parser: argparse.ArgumentParser) -> None:
    """Declare what `errors` takes.

    The code stands in brackets before the sentence of every error.
    """
    parser.add_argument("code", nargs="?", metavar="CODE", help="the code of one error, E502 say")
    parser.add_argument(
        "--find", metavar="WORDS", help="the errors in which these words stand, in full: lost,wire"
    )
    parser.add_argument("--markdown", action="store_true", help="print the page of the docs")
    add_json_option(parser)


# --- explain


def _explain(parser: argparse.ArgumentParser) -> None:
    """Declare what `explain` takes.

    SYSTEM is a named one (`armdrive explain --list`), a built-in arm, the reader's own link table
    (a .toml file), `efficiency` (what each way of computing the named systems costs), or `accuracy`
    (what steps and errors of the model do to the tip). JOINTS are in degrees and mm, in the order
    of the joints, and so is the goal, in the system's own coordinates.

    examples: armdrive explain two-link-1 30 40
              armdrive explain minimover5 --goal 250 0 120 -90 0
              armdrive explain puma --symbolic
              armdrive explain accuracy teachmover 0 40 -60 -70 0
              armdrive explain alpha2 --urdf > alpha2.urdf
    """
    parser.add_argument("system", nargs="?", metavar="SYSTEM", help="a name, a .toml file")
    parser.add_argument(
        "joints", nargs="*", metavar="JOINT", help="degrees (revolute) and mm (prismatic)"
    )
    parser.add_argument(
        "--goal", nargs="+", type=number, metavar="NUMBER", help="mm and degrees, to solve for"
    )
    parser.add_argument("--list", action="store_true", help="list the named systems")
    parser.add_argument(
        "--symbolic", action="store_true", help="A matrices, product and solutions in C1, S12"
    )
    parser.add_argument("--latex", action="store_true", help="the same as LaTeX")
    parser.add_argument("--urdf", action="store_true", help="the arm as URDF, for other tools")
    add_json_option(parser)


# --- fk


def _fk(parser: argparse.ArgumentParser) -> None:
    """Declare what `fk` takes.

    JOINTS are in degrees (mm for a joint that slides), in the order of the arm's joints.

    examples: armdrive fk 0 40 -60 -70 0
              armdrive fk --model myarm.toml 0 -40 60 -110 0
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
    """Declare what `ik` takes.

    Of a built-in arm every branch is printed, and the one that the arm would take. Any other model
    is solved by numbers, which says what was met; there, pitch and roll not given are left free.

    examples: armdrive ik --x 250 --y 0 --z 120 --pitch -90
              armdrive ik --model myarm.toml --x 300 --y 40 --z 150 --pitch -60
    """
    for axis in ("x", "y", "z"):
        parser.add_argument(f"--{axis}", type=number, required=True, metavar="MM")
    parser.add_argument(
        "--pitch",
        type=number,
        metavar="DEG",
        help="elevation of the hand; -90 points at the table",
    )
    parser.add_argument("--roll", type=number, metavar="DEG", help="about the hand")
    parser.add_argument(
        "--yaw",
        type=number,
        metavar="DEG",
        help="direction of the hand about the vertical, for six joints of a model",
    )
    _add_model(parser)
    add_json_option(parser)


# --- plot


def _plot(parser: argparse.ArgumentParser) -> None:
    """Declare what `plot` takes.

    An arm of the Mini-mover's build is cut by the vertical plane through its base axis, the hand
    held at one pitch: inside the drawn line the finger tips can be put. Of any other arm, places
    are drawn that its tool was brought to, from the side and from above.

    examples: armdrive plot workspace --pitch -90
              armdrive plot workspace --model puma --output puma.svg
    """
    parser.add_argument("what", choices=["workspace"], help="what to draw")
    _add_model(parser)
    parser.add_argument(
        "--pitch", type=number, metavar="DEG", help="of the hand; -90 points at the table"
    )
    parser.add_argument(
        "--azimuth", type=number, metavar="DEG", help="direction of the plane; 0 is straight ahead"
    )
    parser.add_argument("--output", type=Path, metavar="FILE", help="a .png or .svg file")
    parser.add_argument("--ascii", action="store_true", help="draw with plain characters")
    add_json_option(parser)


ARGUMENTS: Mapping[str, Arguments] = MappingProxyType(
    {
        "errors": Arguments(_errors),
        "explain": Arguments(_explain),
        "fk": Arguments(_fk),
        "ik": Arguments(_ik),
        "plot": Arguments(_plot),
    }
)
