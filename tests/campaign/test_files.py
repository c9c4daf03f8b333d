"""Damaged files: each is refused with a typed error, or it works.

An arm file that is accepted must also drive an arm: no accepted number may break a motion.
"""

import contextlib
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pages import page

from armdrive.arm import Arm
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, ArmFileError, RecordingError, StateFileError
from armdrive.registry import simulate
from armdrive.registry.arm_files import load_arm, parse_arm
from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.status import State, Trust
from armdrive.storage.record import RecordFile
from armdrive.trace.files import parse_recording
from armdrive.trace.recorder import FlightRecorder
from armdrive.trace.replay import replay
from kinematics import KinematicsError
from tests.scenarios.disk import Disk

ROOT = Path(__file__).parent.parent.parent
WHOLE = re.search(r"```toml\n(.*?)```", page("arm-file"), re.DOTALL)[1]
DIALECTS = ("teachmover", "armdroid", "robko01", "grbl", "mks", "cia402")
STATE = Path("/state/arm.json")
WORDS = st.sampled_from(
    [b"9", b"-1", b"0", b"1e308", b"1e-308", b"nan", b"inf", b"[]", b'""', b"[[", b"\n", b"\xff"]
)
NUMBERS = st.sampled_from([0.0, -1.0, 1e-9, 1e9, -1e308, 0, 1, -7, 10**9]) | st.floats(
    allow_nan=True
)
QUICK = settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])


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
    arm = Arm(connect_simulated(config))
    if arm.status.state is State.DISABLED:
        arm.enable()
    arm.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    first = arm.model.arm.joint_names[0]
    with contextlib.suppress(ArmError, KinematicsError):
        arm.move_j(wait=False, **{f"{first}_deg": arm.joints.deg[first] + 1.0})
        arm.sleep(0.5)
        arm.stop()
    with contextlib.suppress(ArmError, KinematicsError):
        arm.jog_j(**{f"{first}_deg": -0.5})
    str(arm.status)
    arm.close()


@QUICK
@given(text=spoilt(WHOLE.encode()))
def test_a_spoilt_arm_file_is_refused_or_drives_an_arm(tmp_path_factory, text):
    path = tmp_path_factory.getbasetemp() / "spoilt.toml"
    path.write_bytes(text)
    try:
        config = load_arm(path)
    except ArmFileError:
        return
    with contextlib.suppress(ArmError, KinematicsError):
        drive(config)


PLACES = [
    (section, key)
    for section, table in tomllib.loads(WHOLE).items()
    if isinstance(table, dict)
    for key, value in table.items()
    if isinstance(value, int | float) and not isinstance(value, bool)
]


@QUICK
@given(places=st.lists(st.tuples(st.sampled_from(PLACES), NUMBERS), min_size=1, max_size=2))
def test_an_arm_file_with_odd_numbers_is_refused_or_drives_an_arm(places):
    table = tomllib.loads(WHOLE)
    for (section, key), number in places:
        table[section][key] = number
    with contextlib.suppress(ArmError, KinematicsError):
        drive(parse_arm(table, name="odd"))


@pytest.mark.parametrize(
    ("section", "key", "number"),
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
    """Return what a program leaves behind: its arm, and the state file."""
    config, disk = simulated_config("teachmover"), Disk()
    twin = simulate(config)
    arm = Arm(
        assemble(
            config, twin.link, SimulatedPace(), simulated=True, record_store=RecordFile(STATE, disk)
        )
    )
    arm.reference.declare(twin.world.joints, opening_mm=twin.world.opening_mm)
    arm.move_j(base_deg=3.0)
    arm.close()
    return config, twin, disk.texts[STATE]


@QUICK
@given(data=st.data())
def test_a_spoilt_state_file_is_refused_or_true(left, data):
    config, twin, text = left
    disk = Disk()
    disk.texts[STATE] = data.draw(spoilt(text))
    recorder = RecordFile(STATE, disk)
    with contextlib.suppress(StateFileError):
        recorder.load()
    twin.link.reopen()
    pace = SimulatedPace(SimulatedClock(twin.device.now_s))
    arm = Arm(
        assemble(config, twin.link, pace, simulated=True, record_store=RecordFile(STATE, disk))
    )
    status = arm.status
    assert status.trust in (Trust.UNKNOWN, Trust.RESTORED)
    if status.trust is Trust.RESTORED:
        assert status.acknowledged == twin.world.motors
    arm.close()


@pytest.fixture(scope="module", params=DIALECTS)
def recording(request, tmp_path_factory):
    """Return the text of a short recording."""
    arm = Arm(connect_simulated(simulated_config(request.param), tracer=FlightRecorder()))
    arm.jog_j(base_deg=0.2) if arm.status.state is State.STANDBY else arm.enable()
    path = arm.recorder.save(tmp_path_factory.mktemp("recording") / "it.jsonl")
    arm.close()
    return path.read_bytes()


@settings(QUICK, max_examples=20)
@given(data=st.data())
def test_a_spoilt_recording_is_refused_or_replayed(recording, data):
    with contextlib.suppress(RecordingError):
        replay(parse_recording(data.draw(spoilt(recording))))
