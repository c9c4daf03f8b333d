"""Damaged files: each is refused with a typed error, or it works.

An arm file that is accepted must also drive an arm: no accepted number may break a motion.
"""

import contextlib
import re
import tomllib

import pytest
from amounts import every_row
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pages import page

from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, ArmFileError, StateFileError
from armdrive.registry.arm_files import parse_arm
from armdrive.status import Trust
from armdrive.storage.record import RecordFile
from kinematics import KinematicsError
from tests.scenarios.stage import STATE, Stage

WHOLE = re.search(r"```toml\n(.*?)```", page("arm-file"), re.DOTALL)[1]
WORDS = st.sampled_from(
    [b"9", b"-1", b"0", b"1e308", b"1e-308", b"nan", b"inf", b"[]", b'""', b"[[", b"\n", b"\xff"]
)
NUMBERS = st.sampled_from([0.0, -1.0, 1e-9, 1e9, 0, 1, -7, 10**9]) | st.floats(allow_nan=True)
QUICK = settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
PLACES = [
    (section, key)
    for section, table in tomllib.loads(WHOLE).items()
    if isinstance(table, dict)
    for key, value in table.items()
    if isinstance(value, int | float) and not isinstance(value, bool)
]


@st.composite
def spoilt(draw, text):
    """Return a text with a part replaced, or its end cut off."""
    at = draw(st.integers(0, len(text) - 1))
    if draw(st.booleans()):
        return text[:at]
    length = draw(st.integers(0, 6))
    return text[:at] + draw(WORDS | st.binary(max_size=4)) + text[at + length :]


def drive(config):
    """Connect, reference and move a simulated arm; only typed errors are allowed."""
    with contextlib.suppress(ArmError, KinematicsError):
        arm = Stage(config).ready()
        first = arm.model.arm.joint_names[0]
        arm.move_j(wait=False, **{f"{first}_deg": arm.joints.deg[first] + 1.0})
        arm.sleep(0.5)
        arm.stop()
        arm.jog_j(**{f"{first}_deg": -0.5})
        assert str(arm.status)


@QUICK
@given(places=st.lists(st.tuples(st.sampled_from(PLACES), NUMBERS), min_size=1, max_size=2))
def test_an_arm_file_with_odd_numbers_is_refused_or_drives_an_arm(places):
    table = tomllib.loads(WHOLE)
    for (section, key), number in places:
        table[section][key] = number
    with contextlib.suppress(ArmFileError):
        drive(parse_arm(table, name="odd"))


@every_row(
    "section, key, number",
    [
        ("speeds_deg_s", "wrist_roll", 5e-324),
        ("lengths", "forearm_mm", 1e9),
        ("motion", "idle_poll_s", 1e-300),
    ],
)
def test_a_number_that_no_arm_can_be_driven_with_is_refused_by_name(section, key, number):
    table = tomllib.loads(WHOLE)
    table[section][key] = number
    with pytest.raises(ArmFileError, match=f"{section}.{key}"):
        parse_arm(table, name="odd")


@pytest.fixture(scope="module")
def left():
    """Return an arm that a program has moved and left."""
    stage = Stage(simulated_config("teachmover"))
    stage.ready().move_j(base_deg=3.0)
    stage.arm.close()
    return stage, stage.disk.texts[STATE]


@QUICK
@given(data=st.data())
def test_a_spoilt_state_file_is_refused_or_true(left, data):
    stage, text = left
    stage.disk.texts[STATE] = data.draw(spoilt(text))
    with contextlib.suppress(StateFileError):
        RecordFile(STATE, stage.disk).load()
    status = stage.connect().status
    assert status.trust in (Trust.UNKNOWN, Trust.RESTORED)
    if status.trust is Trust.RESTORED:
        assert stage.is_true()
    stage.arm.close()
