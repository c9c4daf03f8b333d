"""The page about points shows a file that is true, and every key there is."""

import dataclasses
import re

from pages import page_path

from armdrive.storage.points import POINT_KEYS, Step, parse_points
from kinematics import JOINT_NAMES, preset

PAGE = page_path("points")


def test_the_shown_file_reads_and_its_points_can_be_gone_to():
    text = PAGE.read_text(encoding="utf-8")
    taught = parse_points(re.search(r"```toml\n(.*?)```", text, re.DOTALL)[1], JOINT_NAMES)
    model = preset("teachmover")
    assert list(taught.points) == ["pick", "above"]
    for point in taught.points.values():
        assert model.arm.violations(point.joints) == ()
        assert model.guards.violation(model.arm, point.joints) is None
    pose = model.arm.fk(taught.points["pick"].joints)
    shown = f"x {pose.x_mm:.1f}, y {pose.y_mm:.1f}, z {pose.z_mm:.1f} mm"
    assert shown in text
    assert len(taught.sequences["fetch"].steps) == 6


def test_every_key_has_a_row():
    text = PAGE.read_text(encoding="utf-8")
    for key in (*POINT_KEYS, *(field.name for field in dataclasses.fields(Step))):
        assert f"| `{key}` |" in text
