"""The docs say what is true: the arm file they show is complete and means the preset itself."""

import dataclasses
import math
import re
import tomllib
from pathlib import Path

import pytest

from armdrive.config import arm as armfile
from armdrive.config import sections as armsections
from armdrive.dialects.teachmover.controller import TeachMoverSettings
from armdrive.registry.arm_files import parse_arm
from kinematics import preset
from kinematics.tool import Tool

DOCS = Path(__file__).parent.parent / "docs"
ROOT = DOCS.parent


def shown_arm_file():
    text = (DOCS / "arm-file.md").read_text(encoding="utf-8")
    return tomllib.loads(re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1])


def test_the_shown_arm_file_lists_every_key():
    shown = shown_arm_file()
    assert {*armfile._TOP_KEYS, "teachmover"} - {"homing"} == set(shown)
    for name, section in {
        "connection": armsections.Connection,
        "motion": armsections.MotionSettings,
        "gripper": armsections.GripperSettings,
        "teachmover": TeachMoverSettings,
        "reference": armsections.PostureSettings,
        "park": armsections.PostureSettings,
        "tool": Tool,
    }.items():
        assert set(shown[name]) == {field.name for field in dataclasses.fields(section)}, name


def test_the_shown_frame_has_every_key():
    keys = {field.name for field in dataclasses.fields(armsections.FrameSettings)}
    assert set(shown_arm_file()["frames"]["board"]) == keys


def test_the_shown_arm_file_shows_the_defaults():
    config = parse_arm(shown_arm_file(), name="shown")
    model = preset("teachmover")
    assert config.motion == armsections.MotionSettings()
    assert config.connection == armsections.Connection("teachmover")
    assert config.gripper == armsections.GripperSettings()
    assert config.device == TeachMoverSettings()
    assert config.model.arm == model.arm
    assert config.model.guards == model.guards
    assert config.model.reference == model.reference
    for ours, theirs in zip(config.model.joint_speeds_rad_s, model.joint_speeds_rad_s, strict=True):
        assert math.isclose(ours, theirs, rel_tol=0.01)
    for ours, theirs in zip(
        config.model.transmission.motors, model.transmission.motors, strict=True
    ):
        assert math.isclose(ours.steps_per_unit, theirs.steps_per_unit, rel_tol=1e-4)


@pytest.mark.parametrize(
    "page", sorted([*DOCS.glob("*.md"), ROOT / "README.md"]), ids=lambda p: p.name
)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{page.name} links to {target}"
