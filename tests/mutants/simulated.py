"""Simulated devices that are more forgiving than real ones."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="the simulated controller knows where its motors stand",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/teachmover.py",
        old="return Motors(signed(count) for count in self.drive.counts)",
        new="return Motors(signed(count) for count in self.drive.world.motors)",
        tests=tests_of(
            "tests/armdrive/sim/teachmover/test_sim_teachmover.py",
            "TestSteps::test_on_the_way_all_motors_are_in_proportion",
        ),
    ),
    Mutant(
        name="simulated motors lose no steps",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/world/__init__.py",
        old="        lost = min(abs(count), self._to_lose.get(motor, 0))\n",
        new="        lost = 0\n",
        tests=tests_of(
            "tests/armdrive/sim/faults/test_sim_faults.py",
            "TestOnTheArm::test_lost_steps_are_counted_and_not_made",
        ),
    ),
    Mutant(
        name="a simulated motor that stalled turns on",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/world/__init__.py",
        old=("        if motor in self.stalled:\n            return 0\n"),
        new="",
        tests=tests_of(
            "tests/armdrive/sim/faults/test_sim_faults.py",
            "TestOnTheArm::test_a_stalled_motor_does_not_follow_until_it_is_freed",
        ),
    ),
    Mutant(
        name="simulated joints have no mechanical stops",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/world/__init__.py",
        old=("            if self._blocked or not stop.low_rad <= angle_rad <= stop.high_rad:"),
        new="            if False:",
        tests=tests_of(
            "tests/armdrive/sim/world/test_sim_world.py",
            "TestMotorsAndStops::test_a_joint_at_its_stop_loses_steps_once_reported",
        ),
    ),
    Mutant(
        name="a simulated arm does not sag",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/world/__init__.py",
        old=("        self.force(there - self._motors, time_s)\n\n    def _followed"),
        new=("\n    def _followed"),
        tests=tests_of(
            "tests/armdrive/sim/world/test_sim_world.py",
            "TestSag::test_without_current_the_arm_comes_down_and_keeps_base_and_roll",
        ),
    ),
    Mutant(
        name="simulated motors have no play",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/world/body.py",
        old="            pin = min(max(0, slot - width), slot)\n",
        new="            pin = step\n",
        tests=tests_of(
            "tests/armdrive/motion/test_backlash_driven.py",
            "test_without_compensation_the_arm_is_off_by_its_play_and_with_it_by_nothing"
            "[teachmover]",
        ),
    ),
    Mutant(
        name="a simulated TeachMover receives commands while it moves",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/teachmover.py",
        old="            if self.busy and not self.settings.keeps_input_while_moving:",
        new="            if False:",
        tests=tests_of(
            "tests/armdrive/sim/teachmover/test_sim_teachmover.py",
            ("TestSteps::test_what_is_sent_during_a_motion_is_lost_unless_the_arm_keeps_it"),
        ),
    ),
    Mutant(
        name="a simulated motor is at once where it was sent",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/mechanics/motors.py",
        old=("        if now_s >= self.done_s:\n            return self.deltas\n"),
        new=("        if now_s >= self.start_s:\n            return self.deltas\n"),
        tests=tests_of(
            "tests/armdrive/sim/mechanics/test_sim_motors.py",
            "test_a_stopped_motion_stays_where_it_was",
        ),
    ),
    Mutant(
        name="a CAN adapter whose frames nobody acknowledges goes on sending",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/faults/table.py",
        old="    adapter.alone = True\n",
        new="",
        tests=tests_of(
            "tests/armdrive/sim/bus/test_drives_served.py",
            "test_its_adapter_leaves_the_bus_until_it_is_opened_anew",
        ),
    ),
    Mutant(
        name="a frame that is cut off blocks a simulated bus",
        promise="a simulated device behaves like the real one, so that tests mean something",
        path="armdrive/sim/bus/line.py",
        old="            if self._of_host or self._of_nodes:\n                self._begin(now_s)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/sim/bus/test_can_wire.py",
            "TestWire::test_a_frame_that_is_cut_off_leaves_the_bus_to_those_that_wait",
        ),
    ),
)
