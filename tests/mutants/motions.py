"""Motions that end in the wrong place, are too fast, or leave their bounds."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="planned motions do nothing and report success",
        promise="a motion ends at its goal, or an error says why not",
        path="armdrive/motion/execute.py",
        old=("    if not legs or wire.stopping:\n        return\n    if wire.core"),
        new=("    if legs:\n        return\n    if wire.core"),
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_the_physical_tip_stays_on_the_straight_line[0.0-way_mm0]",
        ),
    ),
    Mutant(
        name="a motion ends well in error-stop",
        promise="a motion ends where it was asked to, or an error says why not",
        path="armdrive/motion/execute.py",
        old="        yield\n        wire.require_no_fault()\n",
        new="        yield\n",
        tests=tests_of(
            "tests/armdrive/motion/test_faults_in_motion.py",
            "test_no_motion_ends_well_in_error_stop[teachmover-move-True]",
        ),
    ),
    Mutant(
        name="the last part of a motion is dropped",
        promise="a motion ends at its goal",
        path="armdrive/motion/execute.py",
        old=("    for leg in legs:\n        yield from follow_leg"),
        new=("    for leg in legs[:-1] or legs:\n        yield from follow_leg"),
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_the_physical_tip_stays_on_the_straight_line[0.0-way_mm0]",
        ),
    ),
    Mutant(
        name="motions end wherever, and the goal is reported",
        promise="a call reports what was done",
        path="armdrive/motion/execute.py",
        old=(
            "    joints, _ = core.transmission.to_joints(core.position.acknowledged)\n"
            "    pose, wanted"
        ),
        new=("    joints = goal.joints\n    pose, wanted"),
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_a_motion_reports_where_the_motors_stand_and_not_where_they_were_sent",
        ),
    ),
    Mutant(
        name="a stopped motion reports success",
        promise="a motion that was stopped says so",
        path="armdrive/motion/execute.py",
        old="    if wire.stopping and core.position.coordinates != plan.end:",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_handle_can_be_cancelled_and_tells_that_it_was_stopped",
        ),
    ),
    Mutant(
        name="queued motions lose their last segment",
        promise="a motion ends at its goal",
        path="armdrive/motion/execute.py",
        old=(
            "            done = 1.0 if count == 1 else done + (1.0 - done) / count\n"
            "            yield"
        ),
        new=(
            "            done = 1.0 if count == 1 else done + (1.0 - done) / count\n"
            "            if done >= 1.0 and leg is legs[-1] and len(legs) > 1:\n"
            "                return\n"
            "            yield"
        ),
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller.py",
            "test_forty_ways_in_degrees_come_back_to_the_same_steps",
        ),
    ),
    Mutant(
        name="planned motions are not audited",
        promise="the whole motion is audited before its first byte",
        path="armdrive/motion/plan.py",
        old=(
            "    audit(config, [start.joints, *(corner.joints for way in ways "
            "for corner in way)])\n"
        ),
        new="",
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_limits_and_guards_refuse_before_the_first_byte_and_name_the_bound",
        ),
    ),
    Mutant(
        name="joint limits are not checked",
        promise="no joint passes its limit",
        path="armdrive/motion/plan.py",
        old=(
            "            if violation.excess_rad > excused.get(violation.joint, 0.0) + SLACK_RAD:"
        ),
        new="            if False:",
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_limits_and_guards_refuse_before_the_first_byte_and_name_the_bound",
        ),
    ),
    Mutant(
        name="an arm beyond a limit may go further beyond it",
        promise="a motion that starts beyond a bound may lead out, but not deeper",
        path="armdrive/motion/plan.py",
        old="excused.get(violation.joint, 0.0) + SLACK_RAD",
        new="(math.inf if violation.joint in excused else 0.0) + SLACK_RAD",
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_an_arm_that_stands_beyond_a_limit_may_come_back_but_go_no_further",
        ),
    ),
    Mutant(
        name="only the goal of a motion is audited for limits",
        promise="no corner of a motion passes a limit",
        path="armdrive/motion/plan.py",
        old=("    for corner in corners[1:]:\n        for violation"),
        new=("    for corner in corners[-1:]:\n        for violation"),
        tests=tests_of(
            "tests/armdrive/motion/test_paths_driven.py",
            "test_a_path_is_audited_whole_before_its_first_byte",
        ),
    ),
    Mutant(
        name="guards are not checked",
        promise="no guard is broken on the way",
        path="armdrive/motion/plan.py",
        old=("    if found is not None:\n        raise guard_error(found[1], found[0])"),
        new="",
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_an_arm_that_stands_beyond_a_guard_may_leave_it_but_not_go_deeper",
        ),
    ),
    Mutant(
        name="guards are checked at the goal alone",
        promise="no guard is broken on the way",
        path="kinematics/guards/path.py",
        old="            near = part_mm <= self._step_mm\n",
        new="            near = True\n",
        tests=tests_of(
            "tests/armdrive/motion/test_guards_driven.py",
            "test_a_path_through_a_box_to_a_goal_beyond_it_is_refused",
        ),
    ),
    Mutant(
        name="joint limits are five degrees wide of the arm's",
        promise="no joint passes its limit",
        path="kinematics/five_axis/__init__.py",
        old="        if abs(angle - bounds.clamp(angle)) > LIMIT_TOLERANCE_RAD",
        new="        if abs(angle - bounds.clamp(angle)) > LIMIT_TOLERANCE_RAD + 0.0873",
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_limits_and_guards_refuse_before_the_first_byte_and_name_the_bound",
        ),
    ),
    Mutant(
        name="degrees are taken for radians",
        promise="a name in degrees has a value in degrees",
        path="armdrive/motion/plan.py",
        old="changed[known[word]] = math.radians(finite(word, value))",
        new="changed[known[word]] = finite(word, value)",
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_joints_that_are_not_named_keep_their_angle_to_the_last_digit",
        ),
    ),
    Mutant(
        name="the fingers' range is not checked",
        promise="the gripper opens within its range",
        path="armdrive/motion/plan.py",
        old="    if end_mm != start.opening_mm:",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/motion/test_gripper.py",
            "test_opening_and_closing_end_where_asked_while_the_elbow_turns",
        ),
    ),
    Mutant(
        name="a line's joints pass their limits",
        promise="no joint passes its limit on a line",
        path="kinematics/five_axis/__init__.py",
        old="            if abs(angle - inside) > LIMIT_TOLERANCE_RAD:",
        new="            if False:",
        tests=tests_of(
            "tests/kinematics/paths/test_paths.py",
            "test_a_joint_that_starts_beyond_its_limit_may_only_come_back",
        ),
    ),
    Mutant(
        name="motors that are not coordinated stray as they like",
        promise="a joint motion keeps to its path between bursts",
        path="armdrive/motion/deviation.py",
        old=("    if stray_mm > tolerance_mm:\n        return False\n    if not"),
        new="    if not",
        tests=tests_of(
            "tests/armdrive/motion/test_straying.py",
            "test_the_tip_stays_within_the_announced_distance_of_the_line[2.0-robko01]",
        ),
    ),
    Mutant(
        name="joints pass their limits within a burst",
        promise="no joint passes its limit within a burst",
        path="armdrive/motion/deviation.py",
        old=(
            "            if reach_low < low or reach_high > high:\n                return False\n"
        ),
        new="",
        tests=tests_of(
            "tests/armdrive/motion/test_straying.py",
            "test_no_joint_passes_a_limit_that_it_moves_along[elbow-start0-goal0-armdroid]",
        ),
    ),
    Mutant(
        name="steps are rounded down",
        promise="steps are rounded to the nearest",
        path="kinematics/transmission.py",
        old="steps.append(math.floor(own + 0.5) + motor.followed(steps))",
        new="steps.append(math.floor(own) + motor.followed(steps))",
        tests=tests_of(
            "tests/kinematics/test_transmission.py",
            "test_the_mini_movers_reference_posture_has_the_published_steps",
        ),
    ),
    Mutant(
        name="steps are rounded increment by increment",
        promise="steps are rounded once, on absolute targets",
        path="armdrive/runtime/position.py",
        old=(
            "        self.coordinates = coordinates or "
            "self.coordinates_of(self.acknowledged)\n"
            "        self._fingers"
        ),
        new=(
            "        self.coordinates = self.coordinates_of(self.acknowledged)\n"
            "        self._fingers"
        ),
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_a_motion_is_never_faster_than_asked",
        ),
    ),
    Mutant(
        name="GRBL ways are rounded increment by increment",
        promise="relative distances in degrees add up",
        path="armdrive/dialects/grbl/settings.py",
        old=("                self._rounded(start),\n                self._rounded(end),\n"),
        new=(
            "                self._rounded(start - start),\n"
            "                self._rounded(end - start),\n"
        ),
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller_lines.py",
            "test_a_thousand_like_ways_in_degrees_do_not_drift",
        ),
    ),
    Mutant(
        name="a motion is twice as fast as asked",
        promise="a motion is never faster than requested",
        path="armdrive/motion/plan.py",
        old=("speeds.limits, fraction)\n    places"),
        new=("speeds.limits, min(2.0 * fraction, 1.0))\n    places"),
        tests=tests_of(
            "tests/armdrive/motion/test_motion.py",
            "test_a_motion_is_never_faster_than_asked",
        ),
    ),
    Mutant(
        name="every motion is twice as fast as the limits",
        promise="no joint is faster than its limit",
        path="kinematics/paths/timing.py",
        old="        return max(slowest, busiest / self.motor_hz)",
        new="        return max(slowest, busiest / self.motor_hz) / 2.0",
        tests=tests_of(
            "tests/kinematics/paths/test_timing.py",
            "test_two_corners_are_the_exact_profile_of_the_most_limited_coordinate",
        ),
    ),
    Mutant(
        name="motors turn twice as fast as they are able to",
        promise="no motor is faster than its limit",
        path="kinematics/paths/timing.py",
        old="busiest / self.motor_hz)",
        new="busiest / self.motor_hz / 2.0)",
        tests=tests_of(
            "tests/kinematics/paths/test_timing.py",
            "test_a_motor_that_two_joints_drive_is_held_to_its_rate",
        ),
    ),
    Mutant(
        name="motions begin and end without ramps",
        promise="a motion keeps every joint's acceleration",
        path="armdrive/motion/plan.py",
        old=(
            "usual = [speed / self.ramp_s if self.ramp_s > 0.0 else math.inf for speed in speeds]"
        ),
        new="usual = [math.inf for _ in speeds]",
        tests=tests_of(
            "tests/armdrive/motion/test_paths_driven.py",
            "test_with_ramps_the_speed_grows_and_falls_within_its_limits",
        ),
    ),
    Mutant(
        name="the speed override is ignored",
        promise="an override slows the next burst",
        path="armdrive/runtime/overrides.py",
        old="        return duration_s / self.override",
        new="        return duration_s",
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_an_override_makes_a_motion_last_as_much_longer[teachmover]",
        ),
    ),
    Mutant(
        name="the speed override of a jog is ignored",
        promise="an override slows jogs",
        path="armdrive/motion/jog/__init__.py",
        old="capped(core, hold.speed) * core.speed_override.override",
        new="capped(core, hold.speed)",
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_an_override_holds_in_mid_motion_and_for_held_jogs",
        ),
    ),
    Mutant(
        name="a resumed motion drives its last segment twice",
        promise="pausing again and again loses no step",
        path="armdrive/motion/context.py",
        old="pending = self._pending if unsent else self._pending[1:]",
        new="pending = self._pending",
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_a_pause_ends_the_way_within_the_time_and_way_that_were_announced[mks]",
        ),
    ),
    Mutant(
        name="a burst that was paused is taken for made",
        promise="pausing again and again loses no step",
        path="armdrive/motion/execute.py",
        old=("        if core.position.coordinates == there:\n            done = further"),
        new=(
            "        if core.position.coordinates == there or speed_override.paused:\n"
            "            done = further"
        ),
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_a_pause_ends_the_way_within_the_time_and_way_that_were_announced[armdroid]",
        ),
    ),
    Mutant(
        name="a segment that was not sent counts as commanded",
        promise="pausing again and again loses no step",
        path="armdrive/motion/context.py",
        old=("        if unsent:\n            self._core.position.takes_back(self._before)\n"),
        new="",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_pausing.py",
            "test_backlash_that_was_to_be_taken_up_is_taken_up_after_the_pause[0.08]",
        ),
    ),
    Mutant(
        name="backlash is not taken up",
        promise="a motor that reverses takes up its backlash",
        path="armdrive/runtime/backlash.py",
        old=(
            "        each = zip(self.ahead, self.widths, steps, strict=True)\n"
            "        return Motors(to_turn(*one) for one in each)"
        ),
        new="        return steps",
        tests=tests_of(
            "tests/armdrive/runtime/test_backlash.py",
            "test_a_play_that_is_compensated_moves_by_what_was_wanted_every_time",
        ),
    ),
    Mutant(
        name="the gripper's command is not sent",
        promise="the fingers reach the requested opening",
        path="armdrive/motion/gripper.py",
        old="        reply = yield from wire.request(SetGripper(share))\n",
        new=("        reply = Done()\n        yield SleepUntil(wire.now_s)\n"),
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_board.py",
            "test_a_gripper_on_a_valve_opens_and_closes",
        ),
    ),
    Mutant(
        name="a grasp does not press",
        promise="a grasp presses as requested",
        path="armdrive/motion/gripper.py",
        old="        yield from _slide(wire, speeds, -round(extra_n * steps_per_n))\n",
        new="",
        tests=tests_of(
            "tests/armdrive/motion/test_gripper.py",
            "test_a_grasp_measures_the_block_and_presses_as_asked[4.0-3.0]",
        ),
    ),
    Mutant(
        name="axes are homed in the wrong order",
        promise="homing goes group by group in the arm file's order",
        path="armdrive/motion/reference.py",
        old="for group in homing.groups)\n",
        new="for group in reversed(homing.groups))\n",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_board.py",
            "test_homing_ends_where_the_arm_file_says",
        ),
    ),
    Mutant(
        name="homing by switches counts from nowhere",
        promise="homing gives the posture of the arm file",
        path="armdrive/motion/reference.py",
        old=(
            "    core.position.refer(registers.positions, "
            "ArmCoordinates(homing.joints, homing.opening_mm))\n"
        ),
        new="",
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[homing seeks the switches in the arm file's order-mks]",
        ),
    ),
    Mutant(
        name="a line takes another elbow than the one it starts with",
        promise="a line keeps one posture",
        path="kinematics/five_axis/__init__.py",
        old="            _elbow_sign(wrap(start[2]), self.limits[2]),\n",
        new="            -1.0,\n",
        tests=tests_of(
            "tests/kinematics/paths/test_paths.py",
            "test_a_line_keeps_the_elbow_that_it_starts_with",
        ),
    ),
    Mutant(
        name="a line of an arm that faces away turns its base",
        promise="a line keeps one posture",
        path="kinematics/five_axis/__init__.py",
        old="        r < -AXIS_MM,\n",
        new="        False,\n",
        tests=tests_of(
            "tests/kinematics/paths/test_paths.py",
            "test_a_line_behind_the_base_axis_stays_behind",
        ),
    ),
    Mutant(
        name="a pause is ignored",
        promise="a paused arm stands",
        path="armdrive/runtime/overrides.py",
        old="        self.paused = True\n",
        new="        self.paused = False\n",
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_a_paused_motion_stands_and_goes_on_to_the_same_step",
        ),
    ),
)
