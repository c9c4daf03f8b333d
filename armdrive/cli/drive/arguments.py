"""What may be typed after the commands that drive an arm, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from armdrive.cli.arm_options import add_allow_restored, add_arm_options
from armdrive.cli.options import (
    Action,
    Arguments,
    Declare,
    add_actions,
    add_switches,
    count,
    fraction,
    number,
)
from armdrive.moves import BASE_FRAME, GRIPPER_AXIS
from kinematics.spaces import JOINT_NAMES

# --- what several commands with actions take


def _naming(*words: str, more: Declare | None = None) -> Declare:
    """Return what declares the names that an action wants, its own options, and the arm."""

    def declare(action: argparse.ArgumentParser) -> None:
        for word in words:
            action.add_argument(word, metavar=word.upper())
        if more is not None:
            more(action)
        add_arm_options(action)

    return declare


def _again(action: argparse.ArgumentParser) -> None:
    add_switches(action, {"--again": "write over what is there"})


def _force(action: argparse.ArgumentParser) -> None:
    add_switches(action, {"--force": "overwrite another file"})


# --- disable


def _disable(parser: argparse.ArgumentParser) -> None:
    """Declare what `disable` takes.

    armdrive disable              asks whether to park first; on a simulated arm it parks
    armdrive disable --yes        parks, then switches off
    armdrive disable --no-park    switches off where the arm stands: support it
    """
    choice = parser.add_mutually_exclusive_group()
    add_switches(
        choice,
        {
            "--yes": "park first, without asking",
            "--no-park": "switch off where the arm stands, without asking",
        },
    )
    add_allow_restored(parser)
    add_arm_options(parser)


# --- enable


def _enable(parser: argparse.ArgumentParser) -> None:
    """Declare what `enable` takes.

    An arm that has sagged is not lifted: it is held where it is, and its position is suspect.
    """
    add_arm_options(parser)


# --- home


def _home(parser: argparse.ArgumentParser) -> None:
    """Declare what `home` takes.

    An arm without switches is brought there by you, step by step: the posture is drawn, you jog on
    lines such as `shoulder -2` or in the desk, and `done` confirms. An arm with switches MOVES to
    them once you have agreed. A simulated arm has a simulated operator, who jogs it there.

    Examples:
      armdrive home
      armdrive home --declare park                         it stands in its park posture
      armdrive home --declare base=0 shoulder=40 elbow=-60 wrist_pitch=-70 wrist_roll=0

    """
    how = parser.add_mutually_exclusive_group()
    add_switches(
        how,
        {
            "--yes": "the arm stands in its reference posture now: do not ask",
            "--confirm": "instead: the arm stands where an earlier command left it",
        },
    )
    how.add_argument(
        "--declare",
        nargs="+",
        metavar="JOINT=DEG",
        help=f"instead: it stands in these angles ({GRIPPER_AXIS}=MM too), or as parked: `park`",
    )
    add_switches(
        how,
        {
            "--switches": "have an arm with switches seek them WITHOUT ASKING: it moves",
            "--guide": "be guided on a simulated arm too, for practice",
        },
    )
    add_arm_options(parser)


# --- jog


WEB_PORT = 8765
"""Where a browser finds the desk, unless another port is named."""


def _jog(parser: argparse.ArgumentParser) -> None:
    """Declare what `jog` takes.

    Holding a key jogs, releasing it stops; space always stops. The screen shows its keys. A link
    that was lost is looked for by L, or by itself with --reconnect; the arm then stands in
    error-stop. With --model a named system of the lecture notes, or a link table, is jogged with no
    arm at all.
    """
    parser.add_argument("--ascii", action="store_true", help="draw without braille characters")
    parser.add_argument(
        "--reconnect",
        action="store_true",
        default=None,
        help="look for a lost link until it is back, as `reconnect = true` in the arm file does",
    )
    parser.add_argument(
        "--keys",
        metavar="FILE",
        help="a file of keys, or a layout: azerty, qwertz, dvorak, colemak, qwerty",
    )
    parser.add_argument(
        "--show-keys", action="store_true", help="print all keys with their ids, and open nothing"
    )
    parser.add_argument(
        "--model",
        nargs="?",
        const="",
        metavar="NAME",
        help="a named system or a .toml file, with no arm connected; without NAME: list them",
    )
    parser.add_argument(
        "--setup",
        action="store_true",
        help="begin at the set-up screen: find an arm, describe it, check its motors",
    )
    parser.add_argument(
        "--gamepad",
        nargs="?",
        const="",
        metavar="NAME",
        help="jog with a gamepad too (Linux); with several, letters of the name of one",
    )
    parser.add_argument(
        "--web", action="store_true", help="show it in a browser on this computer instead"
    )
    parser.add_argument(
        "--web-port", type=count, default=WEB_PORT, metavar="N", help=f"with --web; else {WEB_PORT}"
    )
    parser.add_argument("--served", action="store_true", help=argparse.SUPPRESS)  # behind a page
    add_arm_options(parser)


# --- move


COORDINATES = (
    ("x", "mm"), ("y", "mm"), ("z", "mm"), ("pitch", "deg"), ("roll", "deg"), ("yaw", "deg"),
)  # fmt: skip
"""What a pose has, and in which units it is typed."""


def _move(parser: argparse.ArgumentParser) -> None:
    """Declare what `move` takes.

    Examples:
      armdrive move --x 250 --z 120 --pitch -90           to a pose, by a joint motion
      armdrive move --y 80 --line                         along a straight line
      armdrive move --y 80 --via 270,0,120                along an arc through that point
      armdrive move --frame tool --z -30 --line           30 mm back, as the hand points
      armdrive move --shoulder 40 --elbow -60 --speed 0.5
      armdrive move --gripper 40
      armdrive move --park
      armdrive move --y 80 --line --preview               moves nothing: what it would be

    """
    goal = parser.add_argument_group("to a pose (what is not named stays)")
    for axis, unit in COORDINATES:
        goal.add_argument(f"--{axis}", type=number, metavar=unit.upper())
    goal.add_argument("--line", action="store_true", help="along a straight line")
    goal.add_argument(
        "--via", type=_point, metavar="X,Y,Z", help="along the arc of a circle through this point"
    )
    goal.add_argument(
        "--frame",
        default=BASE_FRAME,
        metavar="NAME",
        help="the pose is one of a frame of the arm file; of tool: a change from where it is",
    )
    turn = parser.add_argument_group("or to joint angles (what is not named stays)")
    for name in JOINT_NAMES:
        turn.add_argument(f"--{name.replace('_', '-')}", type=number, metavar="DEG")
    turn.add_argument(
        "--joint",
        action="append",
        type=_named_angle,
        default=[],
        metavar="NAME=DEG",
        help="a joint of an arm that is given by a model file; may be repeated",
    )
    parser.add_argument("--gripper", type=number, metavar="MM", help="open or close to a width")
    add_switches(parser, {"--park": "to the park posture"})
    parser.add_argument("--speed", type=fraction, default=1.0, help="fraction of the limits")
    add_switches(
        parser,
        {"--preview": "say what the motion would be, every solution and margin; moves nothing"},
    )
    add_allow_restored(parser)
    add_arm_options(parser)


def _named_angle(word: str) -> tuple[str, float]:
    name, equals, angle = word.partition("=")
    if not (name and equals):
        raise argparse.ArgumentTypeError(f"write it like shoulder=40, not {word!r}")
    return name, number(angle)


def _point(word: str) -> tuple[float, ...]:
    found = tuple(map(number, word.split(",")))
    if len(found) != len("xyz"):
        raise argparse.ArgumentTypeError(f"write it like 250,0,120, not {word!r}")
    return found


# --- pause


def _pause(parser: argparse.ArgumentParser) -> None:
    """Declare what `pause` takes.

    The arm stands, held, until `armdrive resume`; `armdrive stop` ends the motion for good. Without
    a name, every arm that a program of yours holds. The controller's own homing is not paused.
    """
    add_arm_options(parser)


# --- pendant


def _into_file(action: argparse.ArgumentParser) -> None:
    _force(action)
    add_allow_restored(action)


def _into_arm(action: argparse.ArgumentParser) -> None:
    add_switches(
        action,
        {
            "--yes": "do not ask before writing",
            "--leave-others": "let rows stay that the file does not have",
        },
    )
    add_switches(
        action.add_mutually_exclusive_group(),
        {
            "--shift": "so that rows lead where they led",
            "--as-is": "the numbers, wherever they lead now",
        },
    )
    add_allow_restored(action)


PENDANT_ACTIONS: Mapping[str, Action] = MappingProxyType(
    {
        "show": Action(
            "print the program in the arm, row by row",
            "program.pendant:show",
            _naming(more=add_allow_restored),
        ),
        "read": Action(
            "read the program out of the arm into a file",
            "program.pendant:read",
            _naming("file", more=_into_file),
        ),
        "write": Action(
            "write a file's rows into the arm, and read them back",
            "program.pendant:write",
            _naming("file", more=_into_arm),
        ),
        "points": Action(
            "make points and a sequence of a file's rows",
            "program.pendant:make_points",
            _naming("file", "name", more=_again),
        ),
        "make": Action(
            "make a file of rows of a taught sequence",
            "program.pendant:make_rows",
            _naming("name", "file", more=_into_file),
        ),
    }
)
"""Every action of `pendant`."""


def _pendant(parser: argparse.ArgumentParser) -> None:
    """Declare what `pendant` takes.

    Nothing moves. A file can be read, compared and edited; every row comes back word for word.

    Examples:
      armdrive pendant show                              what is in the arm, row by row
      armdrive pendant read monday.pendant               into a file
      armdrive pendant write monday.pendant              back, and read once more to be sure
      armdrive pendant write monday.pendant --shift      after the arm was homed anew
      armdrive pendant points monday.pendant stack       as points and a sequence `stack`
      armdrive pendant make stack stack.pendant          and a sequence as rows for the pendant

    Every action prints JSON with --json.

    """
    add_actions(parser, PENDANT_ACTIONS)


# --- points


def _point_go(action: argparse.ArgumentParser) -> None:
    add_allow_restored(action)
    add_switches(action, {"--line": "along a straight line"})
    action.add_argument("--speed", type=fraction, default=1.0, help="fraction of the limits")
    add_switches(action, {"--preview": "say what it would be; moves nothing"})


def _point_run(action: argparse.ArgumentParser) -> None:
    action.add_argument("--times", type=count, default=1, help="so often (default 1)")
    add_allow_restored(action)


def _point_save(action: argparse.ArgumentParser) -> None:
    action.add_argument("--note", default="", help="what the point is for")
    add_switches(action, {"--again": "move a point that is there"})


def _offset(action: argparse.ArgumentParser) -> None:
    _again(action)
    for axis in ("x", "y", "z"):
        action.add_argument(
            f"--{axis}", type=number, default=0.0, metavar="MM", help=f"along the base's {axis}"
        )
    action.add_argument(
        "--turn", type=number, default=0.0, metavar="DEG", help="about the base axis, first"
    )


POINT_ACTIONS: Mapping[str, Action] = MappingProxyType(
    {
        "list": Action(
            "list the points and sequences, and where their file is",
            "drive.points:list_points",
            _naming(),
        ),
        "show": Action(
            "show a point, or the steps of a sequence", "drive.points:show", _naming("name")
        ),
        "save": Action(
            "name the place where the arm stands; moves nothing",
            "drive.points_driving:save",
            _naming("name", more=_point_save),
        ),
        "go": Action(
            "move the arm to a point",
            "drive.points_driving:go",
            _naming("name", more=_point_go),
        ),
        "run": Action(
            "carry out a sequence",
            "drive.points_driving:run",
            _naming("name", more=_point_run),
        ),
        "rename": Action(
            "give a point another name, in sequences too",
            "drive.points:rename",
            _naming("name", "new"),
        ),
        "delete": Action("take a point or a sequence away", "drive.points:delete", _naming("name")),
        "copy": Action(
            "the same point or sequence once more, over new points",
            "drive.points:shape",
            _naming("name", "new", more=_again),
        ),
        "mirror": Action(
            "a point or a sequence with left and right exchanged",
            "drive.points:shape",
            _naming("name", "new", more=_again),
        ),
        "export": Action(
            "write a sequence as a program file",
            "drive.points:export",
            _naming("name", "file", more=_force),
        ),
        "offset": Action(
            "a point or a sequence in another place",
            "drive.points:shape",
            _naming("name", "new", more=_offset),
        ),
    }
)
"""Every action of `points`."""


def _points(parser: argparse.ArgumentParser) -> None:
    """Declare what `points` takes.

    Points are kept in a file of their own, which may be edited; docs/how-to/points.md lists every
    key.

    Examples:
      armdrive points save pick --note "above the block"
      armdrive points list
      armdrive points go pick --line --speed 0.3          or --preview, which moves nothing
      armdrive points rename pick grip
      armdrive points run stack
      armdrive points mirror stack stack-left             the same on the other side
      armdrive points offset stack stack2 --x 40 --turn 30
      armdrive points export stack stack.arm              as a program: `armdrive run stack.arm`

    Every action prints JSON with --json.

    """
    add_actions(parser, POINT_ACTIONS)


# --- record


def _record(parser: argparse.ArgumentParser) -> None:
    """Declare what `record` takes.

    Without a name, every arm that a program of yours holds. A fault is written without being asked
    for.
    """
    add_arm_options(parser)
    parser.add_argument("--output", type=Path, metavar="FILE", help="copy the recording there")


# --- reset


def _reset(parser: argparse.ArgumentParser) -> None:
    """Declare what `reset` takes.

    A controller that is locked, or in alarm, stays so from one command to the next: this unlocks
    it. A position that is suspect stays suspect, until the arm is homed.
    """
    add_arm_options(parser)


# --- resume


def _resume(parser: argparse.ArgumentParser) -> None:
    """Declare what `resume` takes.

    Nothing goes on that an error, a stop or a lost wire has ended. Without a name, every arm that a
    program of yours holds.
    """
    add_arm_options(parser)


# --- slow


def _slow(parser: argparse.ArgumentParser) -> None:
    """Declare what `slow` takes.

    Holds for what is sent next, bursts, segments and jogs, until it is changed; 100 ends it.
    Without a name, every arm that a program of yours holds.

    Examples:
      armdrive slow 20
      armdrive slow 100 --arm bench

    """
    parser.add_argument("percent", type=_percent, help="1 to 100")
    add_arm_options(parser)


def _percent(word: str) -> float:
    percent = number(word)
    if not 1.0 <= percent <= 100.0:
        raise argparse.ArgumentTypeError(f"give 1 to 100 percent, not {word}")
    return percent


# --- verify


def _verify(parser: argparse.ArgumentParser) -> None:
    """Declare what `verify` takes.

    The arm MOVES to a little above its reference mark. Then you jog the tips onto the mark by small
    steps, on lines such as `shoulder -0.5`, and type `done`. What the registers read beyond the
    reference posture is told by motor, by joint and at the tip, with what it means, and is written
    down with the date in the state folder. A simulated arm has a simulated operator.

    It ends with 1 where the arm is off and the posture was not taken for the new reference.
    """
    add_switches(
        parser,
        {
            "--accept": "take the posture at the mark for the new reference, without asking",
            "--keep": "measure alone: take nothing for the new reference",
        },
    )
    parser.add_argument("--speed", type=fraction, default=0.5, help="fraction of the limits")
    add_allow_restored(parser)
    add_arm_options(parser)


ARGUMENTS: Mapping[str, Arguments] = MappingProxyType(
    {
        "disable": Arguments(_disable),
        "enable": Arguments(_enable),
        "home": Arguments(_home),
        "jog": Arguments(_jog),
        "move": Arguments(_move),
        "pause": Arguments(_pause),
        "pendant": Arguments(_pendant),
        "points": Arguments(_points),
        "record": Arguments(_record),
        "reset": Arguments(_reset),
        "resume": Arguments(_resume),
        "slow": Arguments(_slow),
        "stop": Arguments(add_arm_options),
        "verify": Arguments(_verify),
    }
)
