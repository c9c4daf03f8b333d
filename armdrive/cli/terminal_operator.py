"""The operator at a terminal, who looks at the arm, confirms its posture, and jogs it to one."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
from collections.abc import Iterator

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import enable_if_settled, opened_arm
from armdrive.cli.presenter import agreed, confirmation, say, say_lines, typed
from armdrive.dialog import JoggedArm, PostureRequest
from armdrive.errors import ArmError, BadRequest, OperatorNeeded
from armdrive.moves import BASE_FRAME, GRIPPER_AXIS
from armdrive.render.canvas import draws_braille
from armdrive.render.scene import Moment, PostureDrawing
from armdrive.status import BELIEVED, State, Trust
from armdrive.text.numbers import number
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints

PICTURE_WIDTH, PICTURE_HEIGHT = 39, 14  # two of them fit on a line of 80 columns


def posture_pictures(arm: JoggedArm, joints: Joints, opening_mm: float) -> list[str]:
    """Draw a posture from the side and, to the right of that or else below it, from above."""
    columns = shutil.get_terminal_size().columns
    width = min(PICTURE_WIDTH, columns)
    moment = Moment(joints, opening_mm)
    drawing = PostureDrawing(arm.model, braille=draws_braille())
    side = drawing.side(moment, width, PICTURE_HEIGHT)
    top = drawing.top(moment, width, PICTURE_HEIGHT)
    if columns < 2 * PICTURE_WIDTH + 1:
        return [line.rstrip() for line in (*side, *top)]
    return [f"{a:<{width}} {b}".rstrip() for a, b in zip(side, top, strict=True)]


def show_posture(request: PostureRequest) -> None:
    """Draw the posture asked for, and say what is asked."""
    for line in posture_pictures(request.arm, request.joints, request.opening_mm):
        say(line)
    say(str(request))


def ask_operator(request: PostureRequest) -> bool:
    """Ask the person at the terminal whether the arm stands in the posture."""
    show_posture(request)
    return agreed("Does the arm stand exactly like this? Type yes: ")


def settle_trust(arm: Arm) -> None:
    """Ask the simulated operator, or the person here, to confirm a restored position."""
    status = arm.status
    if status.joints is None or not arm.reference.unconfirmed:
        return
    if arm.simulated:
        confirm_simulated(arm)
        return
    if not sys.stdin.isatty():
        return  # the motion is refused, with the ways to confirm
    for line in posture_pictures(arm, status.joints, status.gripper_mm or 0.0):
        say(line)
    say(f"An earlier program left the arm at {status.joints}.")
    if not agreed("Does the arm stand like this? Type yes: "):
        raise OperatorNeeded("not confirmed: call `home()`")
    arm.reference.confirm_restored()


@contextlib.contextmanager
def settled_arm(options: argparse.Namespace) -> Iterator[Arm]:
    """Open the arm, and settle whether its position can be trusted, which switches nothing on."""
    with opened_arm(options) as arm:
        settle_trust(arm)
        yield arm


@contextlib.contextmanager
def ready_arm(options: argparse.Namespace) -> Iterator[Arm]:
    """Open the arm, and switch its motors on if it is settled where it stands."""
    with settled_arm(options) as arm:
        enable_if_settled(arm)
        yield arm


def confirm_simulated(arm: Arm) -> None:
    """Let the simulated operator look at the simulated arm, and confirm what he sees."""
    joints = arm.status.joints
    if arm.twin is None or joints is None or arm.status.trust is not Trust.RESTORED:
        return
    if arm.twin.operator.stands_at(joints):
        arm.reference.confirm_restored()


# Jogging an arm to a posture, line by line: a picture, small jogs, and `done`. Lines come from the
# terminal or a pipe; the end of input confirms nothing.

# Degrees or mm of one jog. A slip of the finger, `shoulder -200`, is no small jog.
MOST_AMOUNT = 20.0

SPEED = 0.25  # the usual speed of a jog, as that of `Arm.jog_j`
TIP_AXES = ("x", "y", "z")

HELP = """\
  shoulder -2 gripper 3   turn a joint by degrees, open the fingers by mm
  z -5                    move the tip by mm, once the position is known (x, y, z)
  show                    draw the posture again
  done                    confirm: the arm stands in the posture
  quit                    leave without confirming"""
CLEAR, MOTORS_ON = "ok", "on"
LEAVE = ("no", "n", "quit", "q")


class TerminalOperator:
    """Leads through the steps. As an operator it returns True when the person has confirmed."""

    def __init__(self) -> None:
        self._began = State.DISCONNECTED

    def prepare(self, arm: Arm, *, off: bool) -> bool:
        """Go through what comes before the first jog; False where the person wants no more."""
        say("Step 1 of 3. Clear the arm's way, and keep a hand on the power switch.")
        if not _types(CLEAR, "Is the way clear"):
            return False
        if off:
            say("Step 2 of 3. The motors are off, or may be. Hold the arm by hand until they are")
            say("on: they then hold it where it is.")
            if not _types(MOTORS_ON, "Switch them on"):
                return False
            arm.enable()
        else:
            say("Step 2 of 3. The motors are on, or the first jog switches them on.")
        return True

    def __call__(self, request: PostureRequest) -> bool:
        """Let the person jog the arm to the posture until they say that it is there.

        A stop from elsewhere, an error or a lost link ends the request, and with it the jogging.
        """
        say("Step 3 of 3. Bring the arm to this posture (from the side and from above):")
        self._show(request)
        say_lines(HELP)
        self._began = request.arm.status.state
        while (line := typed("> ")) is not None and self._lasts(request):
            words = line.lower().split()
            if words == ["done"]:
                return True
            if words == ["quit"]:
                return False
            self._obey(request, words)
        return False

    def _lasts(self, request: PostureRequest) -> bool:
        """Return whether the arm is still as it was when the request came: nothing has ended it."""
        return request.arm.status.state is self._began

    def _obey(self, request: PostureRequest, words: list[str]) -> None:
        if not words:
            return
        if words == ["show"]:
            self._show(request)
            return
        try:
            for name, amount in parse_jogs(words, axes_of(request.arm)):
                if self._lasts(request):  # a stop ends the line that was being obeyed, too
                    say(jogged(request.arm, name, amount))
        except (ArmError, KinematicsError) as error:
            say(str(error))
            if isinstance(error, BadRequest):
                say("Type one of these lines:")
                say_lines(HELP)
        self._say_rest(request)

    def _show(self, request: PostureRequest) -> None:
        show_posture(request)
        self._say_rest(request)

    def _say_rest(self, request: PostureRequest) -> None:
        if rest := difference(request):
            say(rest)


def _types(word: str, question: str) -> bool:
    """Ask until the person types the word (True) or leaves (False)."""
    while (answer := confirmation(f"{question}? Type {word}: ")) is not None:
        if answer.lower() == word:
            return True
        if answer.lower() in LEAVE:
            return False
        say(f"Type {word} to go on, or no to leave.")
    return False


def difference(request: PostureRequest) -> str:
    """Say how far it is still to go; nothing where the position is not even roughly known."""
    status = request.arm.status
    if status.trust is Trust.UNKNOWN or status.joints is None:
        return ""
    left = {name: wanted - status.joints.deg[name] for name, wanted in request.joints.deg.items()}
    parts = [f"{name} {angle:+.1f}" for name, angle in left.items() if abs(angle) >= 0.05]
    if status.gripper_mm is not None and abs(request.opening_mm - status.gripper_mm) >= 0.05:
        parts.append(f"{GRIPPER_AXIS} {request.opening_mm - status.gripper_mm:+.1f}")
    sure = "" if status.trust is Trust.REFERENCED else f" (position {status.trust.value})"
    return f"still to go, according to the registers{sure}: {', '.join(parts) or 'nothing'}"


def axes_of(arm: JoggedArm) -> tuple[str, ...]:
    """Return what a line may jog; the arm itself refuses the tip where it trusts no position."""
    tip = TIP_AXES if arm.status.trust in BELIEVED else ()
    return (*arm.model.arm.joint_names, GRIPPER_AXIS, *tip)


def parse_jogs(words: list[str], axes: tuple[str, ...]) -> list[tuple[str, float]]:
    """Read `shoulder -2 gripper 3`; names may be cut short where that is unambiguous."""
    if len(words) % 2:
        raise BadRequest("write a name and an amount, for example shoulder -2")
    return [
        (_axis(name, axes), _amount(amount))
        for name, amount in zip(words[::2], words[1::2], strict=True)
    ]


def _axis(word: str, axes: tuple[str, ...]) -> str:
    plain = word.replace("-", "_")
    found = [axis for axis in axes if axis == plain] or [a for a in axes if a.startswith(plain)]
    if len(found) > 1:
        raise BadRequest(f"{word!r} may be {' or '.join(found)}: write more of the name")
    if not found:
        raise BadRequest(f"{word!r} is none of {', '.join(axes)}")
    return found[0]


def _amount(word: str) -> float:
    amount = number(word)
    if abs(amount) > MOST_AMOUNT:
        raise BadRequest(f"jog by at most {MOST_AMOUNT:g} degrees or mm at a time, not {word}")
    return amount


def jogged(arm: JoggedArm, name: str, amount: float) -> str:
    """Jog, and say what came of it."""
    if name in TIP_AXES:
        done = arm.jog_l({f"{name}_mm": amount}, speed=SPEED, frame=BASE_FRAME)
    else:
        unit = "mm" if name == GRIPPER_AXIS else "deg"
        done = arm.jog_j({f"{name}_{unit}": amount}, speed=SPEED)
    return done.note or f"{name} {amount:+g}: done"
