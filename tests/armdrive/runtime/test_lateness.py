"""What is counted of a connection: how late deadlines are met, and what a wire has carried."""

from faults import sim_arm
from hypothesis import given
from hypothesis import strategies as st
from waiting import until

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialog.conversation import Grade
from armdrive.setup.survey import measured_jitter, of_jitter
from armdrive.status import Lateness, SchedulingJitter, status_view


@given(st.lists(st.floats(0.0, 3.0), min_size=1))
def test_no_figure_is_below_what_it_bounds_and_none_above_the_worst(late_s):
    lateness = Lateness()
    for each in late_s:
        lateness.add(each)
    found, ordered = lateness.view(), sorted(late_s)
    assert found.count == len(late_s) == sum(found.classes)
    assert found.worst_s == ordered[-1]
    for share, bound_s in ((0.5, found.median_s), (0.99, found.p99_s)):
        inside = sum(each <= bound_s for each in ordered)
        assert inside >= share * len(ordered)
        assert bound_s <= found.worst_s


def test_early_is_not_late():
    lateness = Lateness()
    lateness.add(-0.5)
    assert lateness.view().worst_s == 0.0


def test_on_simulated_time_nothing_is_late():
    with sim_arm() as arm:
        arm.sleep(1.0)
        assert arm.status.scheduling_jitter.count == 0
        assert "scheduling: " not in str(arm.status)


def test_a_thread_that_drives_an_arm_counts_its_deadlines():
    config = simulated_config("teachmover")
    with Arm(connect_simulated(config, pace="real")) as arm:
        until(lambda: arm.status.scheduling_jitter.count)
        status = arm.status
    assert status.scheduling_jitter.count > 0
    assert "scheduling: " in str(status)
    assert status_view(status)["scheduling_jitter"]["deadlines"] == status.scheduling_jitter.count


def test_the_doctor_measures_this_computer_and_judges_it():
    assert measured_jitter(deadlines=5, period_s=1e-3).count == 5
    assert of_jitter(SchedulingJitter(100, 1e-4, 2e-4, 3e-4)).grade is Grade.OK
    late = of_jitter(SchedulingJitter(100, 1e-3, 2e-2, 5e-2))
    assert late.grade is Grade.NOTE
    assert "50 ms late" in late.what


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
