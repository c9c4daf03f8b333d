"""Positions that are trusted against the evidence."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="evidence lowers no trust",
        promise="a position is not trusted after evidence against it",
        path="armdrive/runtime/states.py",
        old="        result = RESULTS[evidence]\n",
        new=(
            "        result = RESULTS[evidence]\n"
            "        if result is Trust.SUSPECT:\n"
            "            return self\n"
        ),
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_every_kind_of_evidence_has_a_row_and_words",
        ),
    ),
    Mutant(
        name="trust is kept after a motion without an answer",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="            self.core.learn(silence, self.now_s)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_a_power_cut_in_mid_motion_is_an_error_stop_with_a_suspect_position",
        ),
    ),
    Mutant(
        name="trust is kept where registers differ behind a motion",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old=(
            '        core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, f"by '
            '{tuple(difference)} steps")\n'
        ),
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_a_brown_out_between_bursts_is_found_while_the_motion_goes_on",
        ),
    ),
    Mutant(
        name="trust is kept where a stop left the motors off their way",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old=(
            "        elif core.position.read_back is None or not passes(core.position.read_back):\n"
            "            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s)\n"
        ),
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_motors_that_a_stop_left_off_their_way_are_not_believed",
        ),
    ),
    Mutant(
        name="trust is kept of an arm that others have moved",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old=(
            "    core.learn(evidence, wire.now_s)\n"
            "    core.diagnostics.notify(core.belief.reason, evidence)"
        ),
        new="    core.diagnostics.notify(core.belief.reason, evidence)",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_the_pendant_makes_a_standing_arm_suspect_within_seconds",
        ),
    ),
    Mutant(
        name="trust is kept of counts that fell to zero in motion",
        promise="a position is not trusted after evidence against it",
        path="armdrive/runtime/position.py",
        old=("            self.fell |= any(not min(a, c) <= b <= max(a, c) for a, b, c in ways)"),
        new="            self.fell |= False",
        tests=tests_of(
            "tests/armdrive/motion/test_faults_in_motion.py",
            ("test_counts_that_return_to_their_start_are_those_of_a_restarted_device"),
        ),
    ),
    Mutant(
        name="counts of zero after a silence are believed",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="if mute and not reply.positions.largest:",
        new="if False:",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            ("test_counts_of_zero_after_a_silence_may_mean_a_restart"),
        ),
    ),
    Mutant(
        name="a record of an arm in motion is believed",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old="            core.learn(Evidence.ENDED_IN_MOTION, wire.now_s)",
        new="            pass",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_counts_that_agree_by_chance_do_not_hide_an_end_in_mid_motion",
        ),
    ),
    Mutant(
        name="a record is believed although the counts differ",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old="            core.learn(Evidence.RECORD_DIFFERS, wire.now_s)",
        new="            pass",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_an_arm_that_was_touched_between_programs_is_suspect[power_cut]",
        ),
    ),
    Mutant(
        name="a suspect record is restored",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old="        if record.trust == Trust.SUSPECT.value:",
        new="        if False:",
        tests=tests_of(
            "tests/armdrive/storage/test_power_cuts.py",
            "test_an_arm_whose_motors_were_off_is_never_restored",
        ),
    ),
    Mutant(
        name="messages received while connecting are not compared with the record",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old="    if core.early_evidence is not None:",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/dialects/armdroid/test_armdroid_controller.py",
            ("test_motors_that_are_told_to_be_off_while_connecting_leave_no_record_to_be_believed"),
        ),
    ),
    Mutant(
        name="trust is kept where the wire was lost in motion",
        promise="a position is not trusted after evidence against it",
        path="armdrive/runtime/arm_state.py",
        old="        self.learn(Evidence.LOST_IN_MOTION, now_s)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/connect/test_reconnecting.py",
            "test_a_call_waiting_for_a_motion_raises_the_loss_and_the_motion_does_not_continue",
        ),
    ),
    Mutant(
        name="a position is referenced still when a lost wire is back",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old="        core.learn(Evidence.LINK_BACK, now_s)",
        new="        pass",
        tests=tests_of(
            "tests/armdrive/connect/test_reconnecting.py",
            "test_a_wire_that_comes_back_ends_in_error_stop_and_moves_nothing",
        ),
    ),
    Mutant(
        name="a position is restored although the counts changed while the wire was lost",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old="        core.learn(Evidence.RECORD_DIFFERS, now_s)",
        new="        core.learn(Evidence.LINK_BACK, now_s)",
        tests=tests_of(
            "tests/armdrive/connect/test_reconnecting.py",
            "test_a_board_that_lost_its_power_meanwhile_is_suspect",
        ),
    ),
    Mutant(
        name="trust is kept of motors that were stopped dead",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old=(
            "        if isinstance(reply, Halted) and not reply.kept:\n"
            "            core.learn(Evidence.STOPPED_DEAD, self.now_s)\n"
            "        elif core.position.fell:"
        ),
        new="        if core.position.fell:",
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[leaving an emergency stop moves nothing-grbl]",
        ),
    ),
    Mutant(
        name="trust is kept after an alarm that loses the position",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="AlertKind.ALARM_LOST: Evidence.ALARM,",
        new="AlertKind.ALARM_LOST: None,",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_board.py",
            "test_a_limit_alarm_of_an_arm_that_stands_makes_its_position_suspect",
        ),
    ),
    Mutant(
        name="trust is kept of an arm off its path",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="AlertKind.OFF_PATH: Evidence.OFF_THE_PATH,",
        new="AlertKind.OFF_PATH: None,",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller_wire.py",
            "test_an_arm_that_leaves_the_path_is_stopped_on_its_way",
        ),
    ),
    Mutant(
        name="trust is kept of a controller that was restarted",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="AlertKind.RESTARTED: Evidence.RESTARTED,",
        new="AlertKind.RESTARTED: None,",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_resets.py",
            "test_nor_is_a_second_one",
        ),
    ),
    Mutant(
        name="trust is kept of motors that the device switched off",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="AlertKind.SWITCHED_OFF: Evidence.SWITCHED_OFF,",
        new="AlertKind.SWITCHED_OFF: None,",
        tests=tests_of(
            "tests/armdrive/dialects/armdroid/test_armdroid_controller.py",
            "test_an_arm_that_sagged_as_it_was_switched_on_is_not_believed",
        ),
    ),
    Mutant(
        name="trust is kept when the current is dropped",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/standing.py",
        old=(
            "    core.learn(Evidence.CURRENT_DROPPED, wire.now_s)  # whatever the answer will be\n"
        ),
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_dropping_the_current_says_suspect_and_only_disable_sends_it",
        ),
    ),
    Mutant(
        name="trust is kept where homing failed",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/reference.py",
        old="    core.learn(Evidence.HOMING_FAILED, wire.now_s)\n    if wire.stopping:\n",
        new="    if wire.stopping:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_arm.py",
            "test_a_referenced_arm_whose_homing_was_stopped_is_suspect",
        ),
    ),
    Mutant(
        name="homing that ends in error-stop references the arm",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/reference.py",
        old="    registers = yield from wire.ask_registers()\n    _require_no_fault(wire)\n",
        new="    registers = yield from wire.ask_registers()\n",
        tests=tests_of(
            "tests/armdrive/motion/test_faults_in_motion.py",
            "test_an_alarm_after_the_last_homing_group_leaves_nothing_referenced",
        ),
    ),
    Mutant(
        name="homing goes on in error-stop",
        promise="nothing moves in error-stop",
        path="armdrive/motion/reference.py",
        old="        _require_no_fault(wire)\n        return\n",
        new="        return\n",
        tests=tests_of(
            "tests/armdrive/motion/test_faults_in_motion.py",
            "test_an_alarm_in_a_homing_group_ends_the_homing",
        ),
    ),
    Mutant(
        name="a stopped jog ends well though its position was lost",
        promise="a motion ends where it was asked to, or an error says why not",
        path="armdrive/motion/execute.py",
        old="        if wire.stopping and core.belief is not believed:\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/motion/test_faults_in_motion.py",
            "test_a_stop_does_not_hide_a_power_failure",
        ),
    ),
    Mutant(
        name="trust is kept after a motion that was broken off",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/context.py",
        old="        core.learn(evidence, self.now_s, reply.reason)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_wire_faults.py",
            "test_a_motion_that_is_answered_by_no_leaves_a_suspect_position",
        ),
    ),
    Mutant(
        name="trust is kept of an arm that was found off its mark",
        promise="a position is not trusted after evidence against it",
        path="armdrive/motion/reference.py",
        old="    core.learn(Evidence.OFF_ITS_MARK, wire.now_s, detail)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/motion/test_verifying.py",
            ("test_an_unaccepted_drift_makes_the_position_suspect_and_gives_its_size"),
        ),
    ),
    Mutant(
        name="a restored position is used unconfirmed",
        promise=(
            "planned motion needs a reference, or a restored position that somebody has confirmed"
        ),
        path="armdrive/runtime/states.py",
        old="if belief.trust is Trust.RESTORED and allow_restored:",
        new="if belief.trust is Trust.RESTORED:",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_a_refusal_gives_the_reason_and_the_remedy",
        ),
    ),
    Mutant(
        name="any position can be confirmed",
        promise="only a restored position can be confirmed",
        path="armdrive/motion/reference.py",
        old="    if core.belief.trust is not Trust.RESTORED:",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_an_arm_that_was_moved_before_it_was_confirmed_is_not_confirmed",
        ),
    ),
    Mutant(
        name="a posture is accepted although the arm moved since it was seen",
        promise="a posture is refused if the arm may have moved since it was seen",
        path="armdrive/motion/reference.py",
        old="    if doubted or (changed and (late or not registers.largest)):",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            ("test_a_posture_is_not_taken_of_an_arm_that_moved_while_the_wire_was_disturbed"),
        ),
    ),
    Mutant(
        name="a standing arm is not looked at",
        promise="an arm that the pendant moved is suspect within seconds",
        path="armdrive/motion/standing.py",
        old="return now_s + every_s, self._wire.look()",
        new="return now_s + every_s, None",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            ("test_counts_of_zero_after_a_silence_may_mean_a_restart"),
        ),
    ),
    Mutant(
        name="nothing is read back behind a motion",
        promise="a motion is compared with the registers",
        path="armdrive/motion/execute.py",
        old=(
            "        yield from drive_legs(wire, plan.legs, "
            "core.config.motion.planned_burst_s)\n"
            "        yield from wire.verify()\n"
        ),
        new=(
            "        yield from drive_legs(wire, plan.legs, core.config.motion.planned_burst_s)\n"
        ),
        tests=tests_of(
            "tests/armdrive/runtime/test_wire_faults.py",
            "test_a_burst_of_other_steps_is_found_out_before_its_call_returns",
        ),
    ),
    Mutant(
        name="a motion resumes after a pause whatever happened meanwhile",
        promise="a paused motion does not resume if something has changed",
        path="armdrive/motion/execute.py",
        old="    if core.position.acknowledged != stood or core.belief is not believed:",
        new="    if False:",
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_an_arm_that_the_pendant_moved_in_a_pause_does_not_go_on",
        ),
    ),
    Mutant(
        name="a paused arm is not checked before it resumes",
        promise="a paused motion does not resume if something has changed",
        path="armdrive/motion/execute.py",
        old="    yield from wire.look()  # however fresh",
        new="    yield from ()  # however fresh",
        tests=tests_of(
            "tests/armdrive/motion/test_pausing.py",
            "test_an_arm_that_the_pendant_moved_in_a_pause_does_not_go_on",
        ),
    ),
    Mutant(
        name="a lost wire moves the arm when it is back",
        promise="a wire that comes back moves nothing",
        path="armdrive/motion/standing.py",
        old="    _weigh(core, registers, wire.now_s)\n",
        new=(
            "    _weigh(core, registers, wire.now_s)\n"
            "    at = core.position.acknowledged\n"
            "    yield from wire.move(at + type(at)([40] * len(at)), 100.0, None)\n"
        ),
        tests=tests_of(
            "tests/armdrive/connect/test_reconnecting.py",
            "test_a_wire_that_comes_back_ends_in_error_stop_and_moves_nothing",
        ),
    ),
    Mutant(
        name="an arm is ready as soon as its wire is back",
        promise="a lost wire ends in error-stop",
        path="armdrive/motion/standing.py",
        old="        core.fault(back, RECONNECTED)",
        new="        core.diagnostics.notify(back)",
        tests=tests_of(
            "tests/armdrive/connect/test_reconnecting.py",
            "test_a_wire_that_comes_back_ends_in_error_stop_and_moves_nothing",
        ),
    ),
    Mutant(
        name="what was asked for before a fault is done after it",
        promise="no waiting request survives a fault",
        path="armdrive/runtime/arm_state.py",
        old=(
            "        self.hold = None\n        self.nudges.clear()\n"
            "        self.speed_override.end_pause()"
        ),
        new="        self.speed_override.end_pause()",
        tests=tests_of(
            "tests/armdrive/connect/test_reconnecting.py",
            "test_what_waits_never_survives_a_fault",
        ),
    ),
    Mutant(
        name="a look of some seconds ago is fresh enough for a motion",
        promise="a pendant's move just before a motion is seen before the motion",
        path="armdrive/motion/context.py",
        old="FRESH_S = 0.05",
        new="FRESH_S = 5.0",
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_a_pendant_move_just_before_a_motion_is_seen_before_the_motion",
        ),
    ),
    Mutant(
        name="an unreferenced arm makes planned motions",
        promise="planned motion needs a reference",
        path="armdrive/runtime/states.py",
        old=("    if belief.trust is Trust.REFERENCED:\n        return\n"),
        new=("    if belief.trust is not Trust.RESTORED:\n        return\n"),
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_a_refusal_gives_the_reason_and_the_remedy",
        ),
    ),
)
