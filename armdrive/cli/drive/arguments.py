"""The options of the commands that drive an arm, and their help."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.cli.options import (
    EVERY_DRIVEN,
    Action,
    Declare,
    add_actions,
    add_allow_restored,
    add_arm_options,
    add_driven_arm_options,
    add_options,
    named_number,
    naming,
)
from armdrive.errors import BadRequest
from armdrive.runtime.overrides import LEAST_OVERRIDE
from armdrive.text.numbers import number, parse_speed
from tui.keys.layouts import LAYOUTS

# --- options that several actions share


def _again(action: argparse.ArgumentParser) -> None:
    """Add the option of what makes a point.

    Options:
      --again  overwrite a point of that name
    """
    add_options(action, _again)


def _how_it_moves(action: argparse.ArgumentParser) -> None:
    """Add the options of planned motion.

    Options:
      --speed SPEED  a fraction of the limits: 0.5 or 50%
      --preview      show the motion with its solutions and margins; moves nothing
    """
    add_options(action, _how_it_moves)
    action.set_defaults(speed=1.0)
    add_allow_restored(action)


# --- disable


def _disable(parser: argparse.ArgumentParser) -> None:
    """Switch the motors off; the arm can sag, so it is parked first.

    One of:
      --yes      park first, without asking
      --no-park  switch off where the arm stands, without asking: support it

    Without motor current an arm can sag. A real arm asks whether to park first; a simulated arm
    parks.

    Examples:
      armdrive disable
      armdrive disable --yes               park, then switch off, without asking
      armdrive disable --no-park           switch off where the arm stands: support it

    """
    add_options(parser, _disable)
    add_allow_restored(parser)
    add_arm_options(parser)


# --- enable


def _enable(parser: argparse.ArgumentParser) -> None:
    """Switch the motors on, if the controller can.

    The motors hold the arm where it is. An arm that has sagged is not lifted, and its position is
    suspect until `armdrive home`.

    Examples:
      armdrive enable --sim robko01

    """
    add_arm_options(parser)


# --- home


def _home(parser: argparse.ArgumentParser) -> None:
    r"""Set the reference: bring the arm to its reference posture, and confirm it.

    One of:
      --yes                    the arm is in its reference posture now: do not ask
      --declare JOINT=DEG ...  instead: the arm is at these angles (gripper=MM too), or at `park`
      --switches               MOVE an arm with switches to them without asking
      --guide                  practise the steps on a simulated arm

    An arm without switches cannot find its position by itself. `home` draws the reference posture;
    you jog the arm there, with lines such as `shoulder -2`, and confirm with `done`.
    An arm with switches MOVES to them after you agree. On a simulated arm, a simulated operator
    does all this.

    Examples:
      armdrive home
      armdrive home --declare park         the arm stands in its park posture
      armdrive home --declare base=0 shoulder=40 elbow=-60 \
          wrist_pitch=-70 wrist_roll=0

    """
    add_options(parser, _home)
    add_arm_options(parser)


# --- jog


def _jog(parser: argparse.ArgumentParser) -> None:
    """Drive an arm from the keyboard.

    Options:
      --ascii         draw with plain characters
      --show-keys     print all keys with their ids; opens nothing
      --reconnect     reconnect after a lost connection, as `reconnect = true` in the arm file does
      --keys LAYOUT   the keyboard's layout, remembered from then on: %(choices)s
      --model NAME    a named system (`armdrive explain --list`) or the file of a model; no arm

    One of:
      --setup         start on the set-up screen: find an arm, describe it, check its motors
      --program FILE  start on the program screen with this program; nothing runs before you
                      confirm it

    The desk fills the terminal and shows its keys. Hold a key to jog and release it to stop; the
    space bar always stops. After a lost connection, L reconnects, and so does --reconnect by
    itself; the arm is then in error-stop. With --model you jog a named system of the lecture notes
    or a link table, without any arm.

    Examples:
      armdrive jog
      armdrive jog --arm bench --reconnect
      armdrive jog --program stack.arm     rehearse and run a program in the desk
      armdrive jog --keys azerty           the keyboard's layout, from now on
      armdrive jog --model puma
      armdrive jog --show-keys             print the keys; opens nothing

    """
    add_options(parser, _jog, {"LAYOUT": tuple(LAYOUTS)})
    parser.set_defaults(reconnect=None)  # the arm file decides
    add_arm_options(parser)


# --- move


def _move(parser: argparse.ArgumentParser) -> None:
    """Move an arm to a pose or to joint angles.

    To a pose:
      --x MM        forward from the base axis
      --y MM        to the left
      --z MM        up from the table
      --pitch DEG   elevation of the hand; -90 points at the table
      --roll DEG    of the hand
      --yaw DEG     direction of the hand, on an arm with six joints
      --line        along a straight line
      --via X,Y,Z   along an arc through this point
      --frame NAME  the pose is in this frame of the arm file; `tool`: relative to the hand

    Or to joint angles:
      --base DEG
      --shoulder DEG
      --elbow DEG
      --wrist-pitch DEG
      --wrist-roll DEG
      --joint NAME=DEG   a joint of an arm that a model file describes; may be repeated

    Options:
      --gripper MM  open or close the gripper to this width
      --park        go to the park posture

    Coordinates and joints that you leave out keep their values.

    Examples:
      armdrive move --x 250 --z 120 --pitch -90           to a pose, every joint at once
      armdrive move --y 80 --line                         along a straight line
      armdrive move --y 0 --via 270,40,120                along an arc through that point
      armdrive move --frame tool --z -30 --line           30 mm back, along the hand
      armdrive move --shoulder 40 --elbow -60 --speed 50%
      armdrive move --gripper 40                          open to 40 mm
      armdrive move --y 80 --line --preview               only show what would happen
      armdrive move --park

    """
    add_options(parser, _move, {"X,Y,Z": _point, "NAME=DEG": named_number})
    _how_it_moves(parser)
    add_arm_options(parser)


def _point(word: str) -> tuple[float, ...]:
    found = tuple(map(number, word.split(",")))
    if len(found) != len("xyz"):
        raise BadRequest(f"write it like 250,0,120, not {word!r}")
    return found


# --- pause


def _pause(parser: argparse.ArgumentParser) -> None:
    """Pause an arm that another program is driving.

    The arm waits, with its motors on, until `armdrive resume`; `armdrive stop` ends the motion for
    good. If you name no arm, every arm that your programs are driving is paused. A controller that
    homes by itself does not pause.

    Examples:
      armdrive pause
      armdrive pause --sim teachmover

    """
    add_driven_arm_options(parser, EVERY_DRIVEN)


# --- points


def _point_go(action: argparse.ArgumentParser) -> None:
    """Add the options of `points go`.

    Options:
      --line  along a straight line
    """
    add_options(action, _point_go)
    _how_it_moves(action)


def _point_save(action: argparse.ArgumentParser) -> None:
    """Add the options of `points save`.

    Options:
      --note NOTE  what the point is for
    """
    add_options(action, _point_save)
    action.set_defaults(note="")
    _again(action)
    add_allow_restored(action)


def _offset(action: argparse.ArgumentParser) -> None:
    """Add the options of `points offset`.

    Options:
      --x MM      shift along the base's x axis
      --y MM      shift along the base's y axis
      --z MM      shift along the base's z axis
      --turn DEG  turn about the base axis, before the shift
    """
    _again(action)
    add_options(action, _offset)
    action.set_defaults(x=0.0, y=0.0, z=0.0, turn=0.0)


# Every action of `points`.
POINT_ACTIONS: Mapping[str, Action] = MappingProxyType({
    "list": Action("list the points, and the file they are in",
                   "drive.points:list_points", naming()),
    "show": Action("show a point",
                   "drive.points:show", naming("name")),
    "save": Action("save the arm's present place under a name; moves nothing",
                   "drive.move:save_point", naming("name", more=_point_save)),
    "go": Action("move the arm to a point",
                 "drive.move:go_to_point", naming("name", more=_point_go)),
    "rename": Action("rename a point",
                     "drive.points:rename", naming("name", "new")),
    "delete": Action("delete a point",
                     "drive.points:delete", naming("name")),
    "copy": Action("copy a point",
                   "drive.points:derive", naming("name", "new", more=_again)),
    "mirror": Action("copy a point with left and right exchanged",
                     "drive.points:derive", naming("name", "new", more=_again)),
    "offset": Action("copy a point to another place",
                     "drive.points:derive", naming("name", "new", more=_offset)),
})  # fmt: skip


def _points(parser: argparse.ArgumentParser) -> None:
    """Save places by name, and go to them.

    Each arm has a file of points, which you may edit: docs/how-to/points.md describes it.

    Examples:
      armdrive points save pick --note "above the block"
      armdrive points list
      armdrive points show pick
      armdrive points go pick --line --speed 30%
      armdrive points copy pick place
      armdrive points delete place
      armdrive points rename pick grip
      armdrive points mirror grip grip_left               the same on the other side
      armdrive points offset grip grip2 --x 40 --turn 30

    Every action prints JSON with --json.

    """
    add_actions(parser, POINT_ACTIONS)


# --- record


def _record(parser: argparse.ArgumentParser) -> None:
    """Save a recording of an arm that another program is driving.

    A program that drives an arm remembers the last minutes. `record` makes it write them to a file,
    which `armdrive log` reads and `armdrive replay` compares with a simulation. After a fault the
    program writes them by itself. If you name no arm, every arm that your programs are driving is
    recorded.

    Examples:
      armdrive record
      armdrive record --sim teachmover

    """
    add_driven_arm_options(parser, EVERY_DRIVEN)


# --- reset


def _reset(parser: argparse.ArgumentParser) -> None:
    """Clear an error once you have looked at the arm; moves nothing.

    A controller stays locked or in alarm from one command to the next; `reset` unlocks it. The
    position, if suspect, stays suspect until `armdrive home`.

    Examples:
      armdrive reset
      armdrive reset --sim grbl

    """
    add_arm_options(parser)


# --- resume


def _resume(parser: argparse.ArgumentParser) -> None:
    """Continue a paused arm.

    A motion that an error, a stop or a lost connection has ended does not go on. If you name no
    arm, every arm that your programs are driving goes on.

    Examples:
      armdrive resume
      armdrive resume --sim teachmover

    """
    add_driven_arm_options(parser, EVERY_DRIVEN)


# --- slow


def _slow(parser: argparse.ArgumentParser) -> None:
    """Slow down an arm that another program is driving.

    Operands:
      SPEED  0.2 or 20%; at least 1%

    Everything sent from now on is slower, jogs too, until `slow 100%`. If you name no arm, every
    arm that your programs are driving slows down.

    Examples:
      armdrive slow 20%
      armdrive slow 100% --sim teachmover

    """
    add_options(parser, _slow, {"SPEED": _override})
    add_driven_arm_options(parser, EVERY_DRIVEN)


def _override(word: str) -> float:
    speed = parse_speed(word)
    if speed < LEAST_OVERRIDE:
        raise BadRequest(f"a speed is at least {LEAST_OVERRIDE:.0%}, not {word}")
    return speed


# --- stop


def _stop(parser: argparse.ArgumentParser) -> None:
    """Stop an arm that another program is driving.

    The arm stops, keeps its position and needs no reset. If you name no arm, every arm that your
    programs are driving stops. An emergency stop is the switch of the arm's own power supply.

    Examples:
      armdrive stop
      armdrive stop --sim teachmover

    """
    add_driven_arm_options(parser, EVERY_DRIVEN)


# --- verify


def _verify(parser: argparse.ArgumentParser) -> None:
    """Measure at the reference mark how far an arm has drifted.

    One of:
      --accept       accept the posture at the mark as the new reference, without asking
      --keep         only measure: keep the old reference

    Options:
      --speed SPEED  a fraction of the limits: 0.5 or 50%

    The arm MOVES to just above its reference mark. You jog the finger tips onto the mark in small
    steps, with lines such as `shoulder -0.5`, and type `done`. The result is the drift of each
    motor, of each joint and of the tip, with what it means; a log in the state folder keeps it. On
    a simulated arm, a simulated operator does all this.

    The exit code is 1 if the arm has drifted and you did not accept the posture as the new
    reference.

    Examples:
      armdrive verify
      armdrive verify --accept --speed 30%

    """
    add_options(parser, _verify)
    parser.set_defaults(speed=0.5)
    add_allow_restored(parser)
    add_arm_options(parser)


ARGUMENTS: Mapping[str, Declare] = MappingProxyType(
    {
        "disable": _disable,
        "enable": _enable,
        "home": _home,
        "jog": _jog,
        "move": _move,
        "pause": _pause,
        "points": _points,
        "record": _record,
        "reset": _reset,
        "resume": _resume,
        "slow": _slow,
        "stop": _stop,
        "verify": _verify,
    }
)
