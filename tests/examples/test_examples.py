"""Every file of examples/ runs as it stands, unattended; so does the design's own example."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import LONG_S

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_unattended(path, tmp_path):
    ended = subprocess.run(
        [sys.executable, "-W", "error", str(path)],
        env={**os.environ, "ARMDRIVE_FORCE_SIM": "1"},
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LONG_S,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr == ""
    assert ended.stdout


def test_there_are_examples():
    assert "first_steps" in [path.stem for path in EXAMPLES]


def test_the_example_of_the_documentation_word_for_word(capsys):
    from armdrive import Arm, Pose

    # fmt: off
    # ruff: noqa: E501, T201 - the lines are the documentation's, as it prints them
    with Arm.connect("sim:teachmover") as arm:      # or an arm file's name, or a port with a dialect
        arm.home()                                   # the simulated arm has a simulated operator
        arm.move_j(shoulder_deg=40, elbow_deg=-60, speed=0.5)             # joints not named stay
        arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))   # joint motion to a Cartesian goal
        arm.move_l(Pose.of(x_mm=250, y_mm=80, z_mm=120, pitch_deg=-90))   # straight line
        width_mm = arm.gripper.grasp()
        print(arm.status, arm.joints, arm.pose)
        # fmt: on
        tip = arm.twin.world.pose

    assert width_mm == pytest.approx(0.0, abs=0.1)
    assert (tip.x_mm, tip.y_mm, tip.z_mm) == pytest.approx((250, 80, 120), abs=0.5)
    assert "SIMULATED" in capsys.readouterr().out
