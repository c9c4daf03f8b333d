"""What a type checker says of the calls of a program: nothing of right ones, and what is wrong."""

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest
from pages import page_path

from armdrive import arm as arm_module

PROGRAM = """\
from armdrive import (
    Arm, AsyncArm, GraspMove, Grasped, Handle, Jog, Jogged, JointMove, LineMove, Moved, Pose,
    SimulatedClock,
)
from armdrive import Armm  # wrong
from armdrive.moves import ContinuousJog
from armdrive.testing import ArmWorl  # wrong
from kinematics import nonsense  # wrong

clock = SimulatedClock()
goal = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)
arm: Arm = Arm.connect("bench", dialect="grbl", baud=115200, pace="real", reconnect=True)
Arm.connect(pace=clock, allow_restored=True, operator=lambda request: True)
Arm.connect("bench", baud="9600")  # wrong
Arm.connect("bench", dialct="grbl")  # wrong
Arm.connect(5)  # wrong
AsyncArm.connect("bench", pace=clock)
AsyncArm.connect("bench", pase=clock)  # wrong

moved: Moved = arm.move_j(base_deg=1, shoulder_deg=2, elbow_deg=3.5, speed=0.5)
handle: Handle[Moved] = arm.move_j(forearm_roll_deg=1, wrist_pitch_deg=2, wait=False)
arm.move_j(wrist_roll_deg=3, wait=True)
arm.move_j({"turret_deg": 30}, speed=0.5)
arm.move_j(elbw_deg=1)  # wrong
arm.move_j(elbow=1)  # wrong
arm.move_j(elbow_deg="1")  # wrong
arm.move_j(30)  # wrong
arm.preview(JointMove({"shoulder_deg": 40}))
arm.preview({"turret_deg": 40})  # wrong
arm.preview(LineMove(goal))
there: Moved = arm.run(LineMove(goal, speed=0.5))
held: Grasped = arm.run(GraspMove())
began: Handle[Moved] = arm.start(JointMove({"turret_deg": 30}))
arm.run(LineMove(goal, sped=0.5))  # wrong
arm.run(ContinuousJog(Jog.joint(shoulder=1), 0.5, 1.0))  # wrong
arm.move_to((1, 2, 3))  # wrong
arm.move_to("pick")

jogged: Jogged = arm.jog_j(shoulder_deg=2, gripper_mm=5)
arm.jog_j(shoulder=1, elbow=-0.5, duration_s=1)
arm.jog_j({"turret_deg": 2})
arm.jog_j(sholder=1, duration_s=1)  # wrong
arm.jog_l(x_mm=5, pitch_deg=-2)
arm.jog_l(frame="tool", z=1, duration_s=1)
arm.jog_l(w_mm=5)  # wrong

angle: float = arm.joints.base_deg + arm.joints.wrist_roll_rad
arm.joints.elbw_deg  # wrong
arm.speed_override = 0.5
arm.speed_overide = 0.5  # wrong


async def main() -> None:
    async with AsyncArm.connect("sim:grbl") as left:
        await left.move_j(base_deg=1)
        await left.move_j(bse_deg=1)  # wrong
        await left.jog_l(x_mm=5)
        await left.jog_l(x_m=5)  # wrong
        left.speed_override = 0.5
        left.speed_overide = 0.5  # wrong
"""


@pytest.mark.timeout(600)  # nothing is cached: all that the calls import is read
def test_a_type_checker_finds_what_is_wrong_and_nothing_else(tmp_path):
    file = tmp_path / "program.py"
    file.write_text(PROGRAM, encoding="utf-8")
    shown = tmp_path / "shown.py"
    page = page_path("python").read_text(encoding="utf-8")
    _, _, script = page.partition("## A whole script")
    shown.write_text(re.findall(r"```python\n(.*?)```", script, re.DOTALL)[0], encoding="utf-8")
    settings = tmp_path / "mypy.ini"
    settings.write_text("[mypy]\nstrict = True\nfollow_imports = silent\n", encoding="utf-8")
    ended = subprocess.run(
        [
            *(sys.executable, "-m", "mypy", "--config-file", settings),
            *("--cache-dir", tmp_path, file, shown),
        ],
        capture_output=True, text=True, check=False, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    found = {int(line) for line in re.findall(r"program\.py:(\d+): error", ended.stdout)}
    wrong = {
        number for number, line in enumerate(PROGRAM.splitlines(), 1) if line.endswith("# wrong")
    }
    assert found == wrong, ended.stdout + ended.stderr
    assert "shown.py" not in ended.stdout


def test_the_two_forms_of_a_call_with_wait_are_the_call_itself():
    """With `wait=True`, the default, a call returns what was done; with False, a handle of it."""
    (arm,) = (
        each for each in ast.parse(inspect.getsource(arm_module)).body
        if isinstance(each, ast.ClassDef) and each.name == "Arm"
    )  # fmt: skip
    forms: dict[str, list[ast.FunctionDef | ast.AsyncFunctionDef]] = {}
    for each in arm.body:
        if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef) and "wait" in {
            one.arg for one in each.args.kwonlyargs
        }:
            forms.setdefault(each.name, []).append(each)
    assert set(forms) == {"move_j", "move_to", "move_l", "move_c", "move_path"}
    for waited, begun, call in forms.values():
        at = [one.arg for one in call.args.kwonlyargs].index("wait")
        for form, literal, default, returned in (
            (waited, "Literal[True]", "True", "Moved"),
            (begun, "Literal[False]", None, "Handle[Moved]"),
            (call, "bool", "True", "Moved | Handle[Moved]"),
        ):
            wait, value = form.args.kwonlyargs[at], form.args.kw_defaults[at]
            assert ast.unparse(wait.annotation) == literal
            assert (value and ast.unparse(value)) == default
            assert ast.unparse(form.returns) == returned
            wait.annotation, form.args.kw_defaults[at] = None, None
        assert ast.unparse(waited.args) == ast.unparse(begun.args) == ast.unparse(call.args)
