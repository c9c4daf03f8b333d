"""Jogs that do not end, or go too far, and keys that count as held for too long."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="releasing a jog does nothing",
        promise="a jog moves only while it is held",
        path="armdrive/arm/moving.py",
        old=(
            "        self._parts.core.hold = None\n        self._parts.pace.wake()\n\n    def _req"
        ),
        new=("        self._parts.pace.wake()\n\n    def _req"),
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_a_renewed_hold_goes_on_and_a_release_ends_it_after_one_burst",
        ),
    ),
    Mutant(
        name="a hold never expires",
        promise="a jog moves only while it is held",
        path="armdrive/motion/jog/__init__.py",
        old="hold.until_s > wire.now_s and not",
        new="not",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_a_hold_that_is_not_renewed_ends_by_itself[0.05-0.0]",
        ),
    ),
    Mutant(
        name="a hold expires half a second late",
        promise="a jog moves only while it is held",
        path="armdrive/motion/jog/__init__.py",
        old="hold.until_s > wire.now_s and",
        new="hold.until_s + 0.5 > wire.now_s and",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_a_hold_that_is_not_renewed_ends_by_itself[0.05-0.0]",
        ),
    ),
    Mutant(
        name="a hold is as long as anybody asks",
        promise="a jog moves only while it is held",
        path="armdrive/arm/moving.py",
        old="min(for_s, LONGEST_HOLD_S)",
        new="for_s",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_a_hold_is_never_longer_than_a_second_however_long_was_asked",
        ),
    ),
    Mutant(
        name="an increment that waited too long is made",
        promise="an increment that the user no longer expects is dropped",
        path="armdrive/motion/jog/__init__.py",
        old="    if wire.now_s > nudge.until_s:",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_bounds.py",
            "test_an_increment_that_had_to_wait_too_long_is_dropped",
        ),
    ),
    Mutant(
        name="an unreferenced arm jogs at full speed",
        promise="an arm whose position is not known is jogged slowly",
        path="armdrive/motion/jog/__init__.py",
        old=(
            "return speed if core.position_known else min(speed, "
            "core.config.motion.unreferenced_speed)"
        ),
        new="return speed",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_joints_of_an_unknown_posture_are_jogged_slowly_and_without_limits",
        ),
    ),
    Mutant(
        name="the answer to a jog stays",
        promise="the notice is about the present motion or the latest one",
        path="armdrive/motion/execute.py",
        old='    core.diagnostics.notice = ""\n    try:',
        new="    try:",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_bounds.py",
            "test_what_a_jog_was_answered_is_gone_when_the_next_motion_begins",
        ),
    ),
    Mutant(
        name="an unreferenced arm jogs by any amount",
        promise="a jog that no limit ends is never longer than the whole range",
        path="armdrive/motion/jog/__init__.py",
        old="        if abs(amount) <= high - low + LIMIT_TOLERANCE_RAD:",
        new="        if True:",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_bounds.py",
            "test_no_jog_without_limits_is_longer_than_the_whole_range",
        ),
    ),
    Mutant(
        name="an unknown posture is jogged along a line",
        promise="Cartesian jogging needs a known position",
        path="armdrive/motion/jog/__init__.py",
        old="if jog.space is Space.CARTESIAN and not core.position_known:",
        new="if False:",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_cartesian_jogging_of_an_unknown_posture_is_refused_in_a_sentence",
        ),
    ),
    Mutant(
        name="jogs are not audited",
        promise="no leg of a jog passes a limit or a guard",
        path="armdrive/motion/jog/__init__.py",
        old="    if core.position_known and legs:\n",
        new="    if False:\n",
        tests=tests_of(
            "tests/armdrive/motion/test_guards_driven.py",
            "test_a_jog_is_audited_although_it_keeps_to_its_bounds_by_itself",
        ),
    ),
    Mutant(
        name="a jog passes its limits",
        promise="a jog stops at its bounds",
        path="armdrive/motion/jog/course.py",
        old=("        paced = paced.slowed(shares)\n        if stopped"),
        new="        if stopped",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jog_course.py",
            "test_a_joint_slides_up_to_its_limit_and_stops_on_it",
        ),
    ),
    Mutant(
        name="a jog passes guards",
        promise="a jog stops at its bounds",
        path="armdrive/motion/jog/bounds.py",
        old="return there is not None and self.holds(here, there.joints)",
        new="return there is not None",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jog_course.py",
            "test_a_line_ends_on_the_table_and_the_arm_could_always_stop_before_it",
        ),
    ),
    Mutant(
        name="a jog does not reckon with the arm running on",
        promise="a jog could always stop before a guard",
        path="armdrive/motion/jog/__init__.py",
        old=("    return core.controller.stopping(core.config.motion.jog_burst_s).asked_motion_s"),
        new="    return 0.0",
        tests=tests_of(
            "tests/armdrive/motion/test_guards_driven.py",
            ("test_an_arm_that_drives_on_from_leg_to_leg_could_stop_before_a_guard_at_any_moment"),
        ),
    ),
    Mutant(
        name="a jog starts at full speed",
        promise="a jog reaches its speed by a ramp",
        path="armdrive/motion/jog/rates.py",
        old="return share / ramp_s if ramp_s > 0.0 else math.inf",
        new="return math.inf",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jog_course.py",
            "test_after_standing_still_the_ramp_starts_from_zero",
        ),
    ),
    Mutant(
        name="a jog is twice as fast as asked",
        promise="a jog is no faster than requested",
        path="armdrive/motion/jog/__init__.py",
        old="speed = capped(core, hold.speed) * core.speed_override.override",
        new="speed = min(2.0 * capped(core, hold.speed), 1.0) * core.speed_override.override",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_a_slow_hold_is_as_slow_as_asked_even_below_a_step_a_burst",
        ),
    ),
    Mutant(
        name="the dead-man holds ten times longer",
        promise="a released key ends its jog within a quarter of a second",
        path="armdrive/motion/dead_man.py",
        old="HOLD_LONGEST_S = 0.25",
        new="HOLD_LONGEST_S = 2.5",
        tests=tests_of(
            "tests/armdrive/motion/test_deadman.py",
            "test_nothing_is_in_force_a_quarter_second_after_the_last_event",
        ),
    ),
    Mutant(
        name="the dead-man does not release a key",
        promise="a released key ends its jog",
        path="armdrive/motion/dead_man.py",
        old="return () if held is None else (Release(held),)",
        new="return ()",
        tests=tests_of(
            "tests/armdrive/motion/test_deadman.py",
            "test_a_repeat_soon_after_means_held",
        ),
    ),
    Mutant(
        name="the dead-man takes a backlog of keys for a held one",
        promise="keys that a stalled link kept back move nothing",
        path="armdrive/motion/dead_man.py",
        old="        if burst or gate.events >= GATE_EVENTS:\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/motion/test_deadman.py",
            "test_a_stall_of_a_second_moves_nothing_and_disarms",
        ),
    ),
    Mutant(
        name="jog keys are armed from the start",
        promise="jog keys have no effect until they are armed",
        path="armdrive/motion/dead_man.py",
        old=('        self._armed = False\n        self._key = ""\n        self._pressed_s'),
        new=('        self._armed = True\n        self._key = ""\n        self._pressed_s'),
        tests=tests_of(
            "tests/armdrive/motion/test_deadman.py",
            "test_keys_have_no_effect_until_armed",
        ),
    ),
    Mutant(
        name="the arm is jogged by keys while keys pour in",
        promise="jog keys are not armed by a backlog",
        path="armdrive/motion/dead_man.py",
        old="now_s - self._event_s >= ARM_AFTER_QUIET_S",
        new="True",
        tests=tests_of(
            "tests/armdrive/motion/test_deadman.py",
            "test_arming_waits_until_the_keys_are_quiet",
        ),
    ),
)
