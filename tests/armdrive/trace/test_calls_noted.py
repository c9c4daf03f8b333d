"""Every call that moves an arm is noted, and waited before by `armdrive run --step`."""

import pytest

from armdrive import Arm, LinePart, Pose
from armdrive.cli.program.run import MOVING
from armdrive.trace.calls import CALLS

PREFIXES = ("move_", "jog_")
CALLS_THAT_MOVE = sorted(name for name in dir(Arm) if name.startswith(PREFIXES))


@pytest.mark.parametrize("name", CALLS_THAT_MOVE)
def test_a_call_that_moves_is_noted_and_waited_before(name):
    assert name in CALLS
    assert name in MOVING


def test_arcs_and_routes_are_in_the_recording(tmp_path):
    path = tmp_path / "flight.jsonl"
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        arm.park()
        at = [Pose.of(x_mm=x, y_mm=y, z_mm=60, pitch_deg=-90) for x, y in ((200, 0), (220, 20))]
        arm.move_path([LinePart(at[0])])
        arm.move_c(via=Pose.of(x_mm=206, y_mm=14, z_mm=60, pitch_deg=-90), goal=at[1])
        arm.save_recording(path)
    text = path.read_bytes()
    assert b"move_path" in text
    assert b"move_c" in text
