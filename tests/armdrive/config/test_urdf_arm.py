"""An arm file that names a URDF: the arm of the how-to page, checked, driven and recorded."""

import math
import tomllib

import pytest
from pages import blocks, page

from armdrive.arm import Arm
from armdrive.config.arm import remarks_on
from armdrive.config.link_model import read_model
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmFileError
from armdrive.registry.arm_files import arm_problems, load_arm
from armdrive.render.camera import VIEWS
from armdrive.render.scene import ArmDrawing, Moment, Studio
from armdrive.trace.files import Recording, header_of
from armdrive.trace.replay import config_of
from kinematics.spaces import Joints, Pose

NAMES = ("base", "shoulder", "elbow", "forearm_roll", "wrist_pitch", "wrist_roll")


def shown():
    """Return the URDF and the arm file of the page."""
    (urdf,), (arm,) = (blocks(page("urdf"), kind) for kind in ("xml", "toml"))
    return urdf, arm


@pytest.fixture
def write(tmp_path):
    def written(old="", new="", *, urdf=("", "")):
        """Write the page's files, with some text in the place of other text."""
        text, arm = shown()
        assert old in arm
        assert urdf[0] in text
        (tmp_path / "six.urdf").write_text(text.replace(*urdf, 1), encoding="utf-8")
        path = tmp_path / "six.toml"
        path.write_text(arm.replace(old, new, 1), encoding="utf-8")
        return path

    return written


def problems_of(path):
    return arm_problems(tomllib.loads(path.read_text(encoding="utf-8")), path.stem, path.parent)


def test_names_and_limits_come_from_the_urdf_and_the_arm_file_corrects_them(write):
    config = load_arm(write())
    arm = config.model.arm
    assert arm.joint_names == NAMES
    assert (arm.limits[0].low_rad, arm.limits[0].high_rad) == (-2.9, 2.9)
    assert math.degrees(arm.limits[5].high_rad) == pytest.approx(155)
    assert config.model.notes == "six.urdf, from link base_link to link tool0"
    assert config.title == "printed-six"
    zero = arm.fk(Joints((0.0,) * 6, NAMES))
    assert (zero.x_mm, zero.y_mm, zero.z_mm, zero.pitch_rad) == pytest.approx((390, 0, 400, 0))


def test_a_check_names_what_is_not_used(write):
    remarks = list(remarks_on(load_arm(write())))
    for said in ("fingers", "1.5708 as 90°", "collision shapes (1)", "package:// paths"):
        assert any(said in sentence for sentence in remarks)


def test_the_base_link_may_stand_above_the_table(write):
    plain = load_arm(write()).model.arm
    raised = load_arm(write('tip_link = "tool0"', "height_mm = 35.0")).model.arm
    joints = Joints((0.3, 0.2, -0.4, 0.1, 0.5, 0.0), NAMES)
    assert raised.fk(joints).z_mm == pytest.approx(plain.fk(joints).z_mm + 35.0)


def test_the_hand_s_frame_may_stand_elsewhere_in_its_link(write):
    plain = load_arm(write()).model.arm
    turned = load_arm(
        write('tip_link = "tool0"', 'tip_link = "hand"\nz_mm = 80\npsi_deg = 180')
    ).model.arm
    joints = Joints((0.3, 0.2, -0.4, 0.1, 0.5, 0.0), NAMES)
    one, other = plain.fk(joints), turned.fk(joints)
    assert (one.x_mm, one.y_mm, one.z_mm) == pytest.approx((other.x_mm, other.y_mm, other.z_mm))
    assert other.pitch_rad == pytest.approx(-one.pitch_rad)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('tip_link = "tool0"', 'tip_link = "tol0"', "did you mean 'tool0'?"),
        ('tip_link = "tool0"', "tip = 1", "did you mean 'tip_link'?"),
        ('tip_link = "tool0"', "tip_link = 1", "urdf.tip_link must be text"),
        ('tip_link = "tool0"', 'tip_link = "finger"', "joint 'fingers' slides"),
        ('tip_link = "tool0"', 'tip_link = "knuckle"', "'wrist_roll' in [limits_deg]"),
        ('model = "six.urdf"', 'model = "seven.urdf"', "seven.urdf cannot be read"),
        ('model = "six.urdf"', 'model = "six.urdf.xacro"', "six.urdf.xacro cannot be read"),
        ("wrist_roll = [-155, 155]", "", "joint 'wrist_roll' has no limits in its model"),
        ("wrist_roll = 40", "", "[speeds_deg_s] is missing wrist_roll"),
    ],
)
def test_a_wrong_key_is_named(write, old, new, said):
    found = problems_of(write(old, new))
    assert any(said in sentence for sentence in found), found


def test_a_bad_urdf_is_one_problem_beside_those_of_the_arm_file(write):
    path = write("wrist_roll = 40", "wrist_roll = -4", urdf=("</robot>", ""))
    (first, second) = problems_of(path)
    assert "six.urdf: the URDF is not valid XML: no element found" in first
    assert "speeds_deg_s.wrist_roll" in second


def test_a_urdf_s_section_is_unknown_to_other_arms(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text('model = "teachmover"\n[urdf]\ntip_link = "x"\n', encoding="utf-8")
    with pytest.raises(ArmFileError, match="unknown key 'urdf'"):
        load_arm(path)


def test_a_huge_urdf_is_not_read(write):
    path = write(urdf=("</robot>", f"<!-- {'x' * 3_000_000} --></robot>"))
    (problem,) = [each for each in problems_of(path) if "urdf" in each]
    assert "larger than" in problem


def test_the_model_alone_takes_the_same_joint_values(write):
    path = write()
    chain = read_model(path.parent / "six.urdf").chain
    values = (0.3, 0.2, -0.4, 0.1, 0.5, -0.6)
    whole = load_arm(path).model.arm.chain
    for ours, theirs in zip(chain.fk(values), whole.fk(values), strict=True):
        assert ours == pytest.approx(theirs)


def test_a_recording_holds_the_urdf(write, tmp_path):
    config = load_arm(write())
    header = header_of(config, link="bench", why="test", began=(0.0, 0.0))
    (tmp_path / "six.urdf").unlink()
    assert "<robot" in header.model_file
    again = config_of(Recording(header, ()))
    assert again.calibration == config.calibration
    assert again.model.arm == config.model.arm


def test_it_is_homed_and_moved_on_its_simulated_board_and_drawn(write):
    config = load_arm(write())
    with Arm(connect_simulated(config)) as arm:
        arm.home()
        arm.move_j(shoulder_deg=10, elbow_deg=20, wrist_pitch_deg=30)
        arm.move_to(Pose.of(x_mm=300, y_mm=50, z_mm=250, pitch_deg=-30, yaw_deg=10))
        assert math.dist(arm.twin.world.tip, (300.0, 50.0, 250.0)) < 1.0
        scene = ArmDrawing(config.model)
        pictures = [
            Studio(scene.dome, braille=True)
            .draw(scene.space(Moment(joints, 0.0)), VIEWS["side"], 60, 20)
            .rows()
            for joints in (arm.joints, Joints((0.0,) * 6, NAMES))
        ]
        assert pictures[0] != pictures[1]
        assert all(len(set("".join(rows))) > 5 for rows in pictures)
