"""What a wire has carried is counted where the bytes go over it."""

from armdrive import Arm


def test_a_motion_is_counted_and_the_rate_is_the_wires_own():
    with Arm.connect("sim:teachmover") as arm:
        before = arm.status.link_stats
        assert before.baud == 9600
        arm.jog_j(shoulder_deg=2, speed=0.5)
        after = arm.status.link_stats
        assert after.sent > before.sent
        assert after.heard > before.heard
        share = after.load(before, 1.0)
        assert share == 10 * max(after.sent - before.sent, after.heard - before.heard) / 9600
