"""Drivers and codecs that send or read something wrong."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="a board that is set up for another arm is driven",
        promise="nothing moves while the controller's settings are not the arm file's",
        path="armdrive/runtime/arm_state.py",
        old="        wrong = [each for each in self.differences if each.must]\n",
        new="        wrong = [each for each in self.differences if not each.must]\n",
        tests=tests_of(
            "tests/armdrive/connect/test_foreign_boards.py",
            "test_a_foreign_setting_is_named_and_nothing_moves_before_it_is_mended",
        ),
    ),
    Mutant(
        name="a board's wrong steps a unit go unnoticed",
        promise="settings that differ from the arm file are reported",
        path="armdrive/dialects/grbl/settings.py",
        old="            if steps is not None and abs(steps - wanted) > SAME:",
        new="            if False:",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller_lines.py",
            "test_each_setting_that_differs_is_told_with_the_line_that_mends_it",
        ),
    ),
    Mutant(
        name="a board whose motors are switched off at rest goes unnoticed",
        promise="settings that differ from the arm file are reported",
        path="armdrive/dialects/grbl/settings.py",
        old=("        if not on:\n            yield"),
        new=("        if False:\n            yield"),
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller_lines.py",
            "test_each_setting_that_differs_is_told_with_the_line_that_mends_it",
        ),
    ),
    Mutant(
        name="a line that jogs a GRBL board passes for a setting",
        promise="writing settings moves nothing",
        path="armdrive/dialects/grbl/controller.py",
        old="            case MendSetting(line) if not re.fullmatch(SETTING, line):\n",
        new='            case MendSetting(line) if not line.startswith("$"):\n',
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_board.py",
            "test_a_line_that_writes_no_setting_is_not_sent[$J=G91X9F99]",
        ),
    ),
    Mutant(
        name="an ok is counted for no line",
        promise="every line's ok is counted",
        path="firmware_protocol/grbl/host.py",
        old=("        sent = self._outstanding.popleft()\n        self._bytes -= sent.size\n"),
        new="        sent = self._outstanding[0]\n",
        tests=tests_of(
            "tests/firmware_protocol/grbl/test_grbl_host.py",
            "test_answers_belong_to_the_lines_in_their_order",
        ),
    ),
    Mutant(
        name="an ok is taken for the end of its line",
        promise="a GRBL motion has ended when the board stands at the goal",
        path="armdrive/dialects/grbl/planner.py",
        old=("        self.unanswered = max(self.unanswered - 1, 0)\n        self.oks += 1\n"),
        new=(
            "        self.unanswered = max(self.unanswered - 1, 0)\n"
            "        self.oks += 1\n"
            "        self._drop(len(self._lines) - self.unanswered)\n"
        ),
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[a joint motion arrives, and its read-back says so-grbl]",
        ),
    ),
    Mutant(
        name="a board's ring is overfilled",
        promise="no more bytes are sent than a board's ring has room for",
        path="firmware_protocol/grbl/host.py",
        old="        if self.outstanding_bytes + line.size >= self.ring_bytes:",
        new="        if False:",
        tests=tests_of(
            "tests/firmware_protocol/grbl/test_grbl_host.py",
            "test_a_line_goes_out_only_where_the_ring_has_room_for_it",
        ),
    ),
    Mutant(
        name="jogs are sent before the line before is answered",
        promise="no more than one line of a jog is unanswered",
        path="armdrive/dialects/grbl/planner.py",
        old="return self.lines.unanswered > 0 and (self.jog or not self.lines.oks)",
        new="return False",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller.py",
            "test_no_more_than_one_line_of_a_jog_is_unanswered",
        ),
    ),
    Mutant(
        name="an arm that leaves its path is not noticed",
        promise="an arm that leaves its path is stopped",
        path="armdrive/dialects/grbl/motion.py",
        old="        return self._end_off_path(trip) if trip.off > 1 else None",
        new="        return None",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller_wire.py",
            "test_an_arm_that_leaves_the_path_is_stopped_on_its_way",
        ),
    ),
    Mutant(
        name="a mute board is not noticed",
        promise="a board that sends no report in a motion ends it",
        path="armdrive/dialects/grbl/exchange.py",
        old="        return self.io.now_s >= self.mute_at_s",
        new="        return False",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_mute.py",
            "test_a_board_that_goes_mute_in_motion_is_lost_within_a_second[0.1-begin_planned]",
        ),
    ),
    Mutant(
        name="a reset after a feed hold is not waited for",
        promise="a feed hold, a wait for its end and then a reset keep the position",
        path="armdrive/dialects/grbl/stops.py",
        old="                (state in HELD and not sub_state)\n",
        new="                state in HELD\n",
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[a joint motion stops within its bound-grbl]",
        ),
    ),
    Mutant(
        name="outputs are not restored behind a stop",
        promise="a stop drops no load",
        path="armdrive/dialects/grbl/stops.py",
        old=("        if kept:\n            yield from self.outputs.restore()\n"),
        new="",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_board.py",
            "test_outputs_and_a_servo_come_back_after_a_stop",
        ),
    ),
    Mutant(
        name="a Robko frame's check bytes are ignored",
        promise="a frame that was changed on the wire is rejected",
        path="firmware_protocol/robko01/frames.py",
        old="        if size and frame[-_CHECK:] == wanted:",
        new="        if size:",
        tests=tests_of(
            "tests/firmware_protocol/robko01/test_robko01_machines.py",
            "test_bytes_that_are_no_answer_are_told_and_change_nothing",
        ),
    ),
    Mutant(
        name="a Robko frame's check bytes are swapped",
        promise="frames are encoded as the firmware encodes them",
        path="firmware_protocol/robko01/frames.py",
        old="    return bytes((even, odd))",
        new="    return bytes((odd, even))",
        tests=tests_of(
            "tests/firmware_protocol/robko01/test_robko01_wire.py",
            "test_a_request_is_these_bytes",
        ),
    ),
    Mutant(
        name="a Robko position has its bytes in the wrong order",
        promise="frames are encoded as the firmware encodes them",
        path="firmware_protocol/robko01/messages.py",
        old='struct.Struct(f"<{2 * AXES}h")',
        new='struct.Struct(f">{2 * AXES}h")',
        tests=tests_of(
            "tests/firmware_protocol/robko01/test_robko01_wire.py",
            "test_a_request_is_these_bytes",
        ),
    ),
    Mutant(
        name="a Robko moves relative to where it is believed to be",
        promise="a request that may be repeated goes to an absolute position",
        path="armdrive/dialects/robko01/motion.py",
        old=("        target = start + steps\n        if not all"),
        new=("        target = steps\n        if not all"),
        tests=tests_of(
            "tests/armdrive/dialects/robko01/test_robko01_controller.py",
            (
                "TestRequests::test_one_move_may_follow_another_at_once_though_t"
                "he_board_says_it_is_busy"
            ),
        ),
    ),
    Mutant(
        name="a Robko that was stopped may have gone anywhere",
        promise="a stopped motion stays on its path",
        path="armdrive/dialects/robko01/motion.py",
        old="OVERSHOOT_STEPS = 3",
        new="OVERSHOOT_STEPS = 300",
        tests=tests_of(
            "tests/armdrive/dialects/robko01/test_robko01_stop.py",
            "test_a_motor_that_a_stop_left_far_beyond_its_target_is_not_believed",
        ),
    ),
    Mutant(
        name="the Robko's watchdog is not fed",
        promise="a standing arm keeps its current",
        path="armdrive/dialects/robko01/controller.py",
        old="        return data + self._exchange.feed()",
        new="        return data",
        tests=tests_of(
            "tests/armdrive/dialects/robko01/test_robko01_controller.py",
            ("TestWatchdog::test_it_is_kept_fed_while_the_program_lives_even_in_error_stop"),
        ),
    ),
    Mutant(
        name="an Armdroid's numbers are not compared before its letter",
        promise="no byte that goes wrong makes a motion of another size",
        path="armdrive/dialects/armdroid/controller.py",
        old="            if understood == drive.steps and self._board.has_speed(rpm):",
        new="            if understood is not None and self._board.has_speed(rpm):",
        tests=tests_of(
            "tests/armdrive/dialects/armdroid/test_armdroid_controller.py",
            (
                "TestConversation::test_numbers_that_were_misunderstood_are_take"
                "n_back_and_said_again"
            ),
        ),
    ),
    Mutant(
        name="an Armdroid's number loses its sign",
        promise="a number survives encoding and decoding",
        path="firmware_protocol/armdroid/endpoints.py",
        old="            self._accumulator = wrapped(-self._accumulator)",
        new="            self._accumulator = wrapped(self._accumulator)",
        tests=tests_of(
            "tests/firmware_protocol/armdroid/test_armdroid_device.py",
            "test_characters_are_read_as_the_sketch_reads_them",
        ),
    ),
    Mutant(
        name="Armdroid motors are taken in the wrong order",
        promise="each motor turns its own joint",
        path="armdrive/dialects/armdroid/controller.py",
        old="    return tuple(by_channel[channel] for channel in sorted(by_channel))",
        new=(
            "    return tuple(by_channel[channel] for channel in sorted(by_channel, reverse=True))"
        ),
        tests=tests_of(
            "tests/armdrive/dialects/armdroid/test_armdroid_controller.py",
            "TestConversation::test_without_the_check_a_motion_is_one_text",
        ),
    ),
    Mutant(
        name="a TeachMover's counts lose their sign",
        promise="a number survives encoding and decoding",
        path="firmware_protocol/teachmover/messages.py",
        old="    return tuple(int(field) for field in fields)",
        new="    return tuple(abs(int(field)) for field in fields)",
        tests=tests_of(
            "tests/firmware_protocol/teachmover/test_teachmover_wire.py",
            "test_the_bytes_of_every_command_both_ways",
        ),
    ),
    Mutant(
        name="a TeachMover's failed command counts as done",
        promise="a motion that the controller refused says so",
        path="armdrive/dialects/teachmover/controller.py",
        old=("        if event.status is Status.FAILED:\n            return RequestRejected()\n"),
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_wire_faults.py",
            "test_a_motion_that_is_answered_by_no_leaves_a_suspect_position",
        ),
    ),
    Mutant(
        name="the pendant's STOP key counts as done",
        promise="the pendant's STOP ends a motion",
        path="armdrive/dialects/teachmover/controller.py",
        old=("        if event.status is Status.STOPPED:\n            return Interrupted()\n"),
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_the_pendants_stop_ends_a_burst_and_the_position_is_still_known",
        ),
    ),
    Mutant(
        name="an impossibly early answer is believed",
        promise="a reply that comes too early is compared with the registers",
        path="armdrive/dialects/speed_table.py",
        old="return expected_s * EARLY - self.early_s <= measured_s <= longest_s",
        new="return True",
        tests=tests_of(
            "tests/armdrive/runtime/test_wire_faults.py",
            "test_an_answer_that_comes_too_early_is_compared_with_the_registers_at_once",
        ),
    ),
    Mutant(
        name="an MKS frame's check byte is ignored",
        promise="a frame that was changed on the wire is rejected",
        path="firmware_protocol/mks/answers.py",
        old="    if data[-1] != wanted:",
        new="    if False:",
        tests=tests_of(
            "tests/firmware_protocol/mks/test_mks_host.py",
            "test_a_bad_check_byte_is_garbled_and_answers_nothing",
        ),
    ),
    Mutant(
        name="an MKS check byte leaves the id out",
        promise="frames are encoded as the firmware encodes them",
        path="firmware_protocol/mks/values.py",
        old="    return (can_id + sum(data)) & 0xFF",
        new="    return sum(data) & 0xFF",
        tests=tests_of(
            "tests/firmware_protocol/mks/test_mks_wire.py",
            "test_a_request_is_these_bytes",
        ),
    ),
    Mutant(
        name="an MKS target has its bytes in the wrong order",
        promise="frames are encoded as the firmware encodes them",
        path="firmware_protocol/mks/values.py",
        old='lambda data: int.from_bytes(data, "big", signed=True)',
        new='lambda data: int.from_bytes(data, "little", signed=True)',
        tests=tests_of(
            "tests/firmware_protocol/mks/test_mks_wire.py",
            "test_a_request_is_these_bytes",
        ),
    ),
    Mutant(
        name="an MKS drive off its way is not noticed",
        promise="a blocked drive is noticed by its encoder",
        path="armdrive/dialects/bus/observer.py",
        old="        if before is not None and not self._progresses(before):\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/bus/test_observer.py",
            "test_a_case[blocked]",
        ),
    ),
    Mutant(
        name="a drive that homed by itself begins its next motion elsewhere",
        promise="a healthy drive is not blamed",
        path="armdrive/dialects/bus/observer.py",
        old="        self._rest_courses_at(self.goal, now_s)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/dialects/bus/test_observer.py",
            "test_a_drive_that_homed_by_itself_begins_its_next_motion_where_it_stands",
        ),
    ),
    Mutant(
        name="a doubted reading waits for the next poll",
        promise="a drive that restarted is found at once",
        path="armdrive/dialects/bus/observer.py",
        old="if each.ledger.asked_s <= each.read_s)",
        new="if each.ledger.asked_s < 0.0)",
        tests=tests_of(
            "tests/armdrive/dialects/bus/test_observer.py",
            "test_a_case[doubted_after_a_lost_question]",
        ),
    ),
    Mutant(
        name="a slow MKS drive that is blocked is steered for ever",
        promise="a blocked drive is noticed by its encoder, also in a pause",
        path="armdrive/dialects/bus/observer.py",
        old="        if self._stands_despite_orders(off):\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_following.py",
            "test_a_slow_drive_that_is_blocked_is_reported_also_in_a_pause[-200-0.3-0.5]",
        ),
    ),
    Mutant(
        name="a slow MKS drive whose orders were lost is called blocked",
        promise="a lost order is no fault of a drive",
        path="armdrive/dialects/bus/observer.py",
        old="confirmed = self.rejections.started_s > first.read_s ",
        new="confirmed = True ",
        tests=tests_of("tests/armdrive/dialects/bus/test_observer.py", "test_a_case"),
    ),
    Mutant(
        name="an MKS bus that is always slow is waited for",
        promise="a motion on a bus that is too slow ends by itself",
        path="armdrive/dialects/bus/observer.py",
        old="        if self._outages >= LATE_OUTAGES:\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_outages.py",
            "test_a_motion_on_a_bus_that_is_always_slow_ends_by_itself_and_blames_no_drive",
        ),
    ),
    Mutant(
        name="a late answer is taken for that to a newer question",
        promise="a late bus blames no drive",
        path="armdrive/dialects/bus/observer.py",
        old="max(ledger.timeout_s, self.outage_s + OUTAGE_S)",
        new="ledger.timeout_s",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_outages.py",
            "test_a_motion_on_a_bus_that_is_always_slow_ends_by_itself_and_blames_no_drive",
        ),
    ),
    Mutant(
        name="an MKS drive that takes no orders is not noticed",
        promise="a drive that rejects its orders ends the motion",
        path="armdrive/dialects/mks/motion.py",
        old="                if drive.rejections.confirm():\n",
        new="                if drive.rejections.confirm() and False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_rejections.py",
            "test_a_wrist_motor_that_rejects_orders_stops_the_other_one_at_once[0.2]",
        ),
    ),
    Mutant(
        name="a drive that obeys late is judged only by the course that its readings move",
        promise="a drive that obeys late within the bound is never blamed",
        path="armdrive/dialects/bus/observer.py",
        old="for each in (self.course, self.ordered))\n\n    def _reaches",
        new="for each in (self.course,))\n\n    def _reaches",
        tests=tests_of("tests/armdrive/dialects/bus/test_observer.py", "test_a_case"),
    ),
    Mutant(
        name="an MKS drive at a limit switch gets the order of its burst again",
        promise="a limit switch ends a motion of all motors",
        path="armdrive/dialects/mks/motion.py",
        old="observer = self._run, self._wire.observer\n        if run.blame(run.reported()):\n",
        new="observer = self._run, self._wire.observer\n        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_controller_motion.py",
            "test_a_limit_switch_that_stops_a_burst_is_not_run_against_again",
        ),
    ),
    Mutant(
        name="a slow CiA 402 drive that is blocked is found by its error alone",
        promise="a blocked drive is noticed by its encoder, at any speed",
        path="armdrive/dialects/cia402/motion.py",
        old="return self._blocked() or (Signal.ALL_SENT",
        new="return (Signal.ALL_SENT",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_blocked.py",
            "test_a_blocked_shaft_is_found_in_the_same_time_at_any_speed[300.0]",
        ),
    ),
    Mutant(
        name="replies on a slow link count as missed",
        promise="a late bus calls no healthy drive restarted",
        path="armdrive/dialects/bus/ledger.py",
        old="return max(RETRY_PERIOD_S, self.longest_wait_s)\n",
        new="return RETRY_PERIOD_S\n",
        tests=tests_of(
            "tests/armdrive/dialects/bus/test_observer.py",
            "test_a_drive_on_a_slow_link_is_not_taken_to_have_been_away",
        ),
    ),
    Mutant(
        name="each reply on a slow link ends an outage",
        promise="a late bus calls no healthy drive restarted",
        path="armdrive/dialects/bus/observer.py",
        old="return silent_s > min(slowest_s, MAX_DELAY_S)",
        new="return True",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_outages.py",
            "test_a_motion_on_a_bus_that_is_always_slow_ends_by_itself_and_blames_no_drive",
        ),
    ),
    Mutant(
        name="a drive that is ahead of its course is called blocked",
        promise="a late order calls no healthy drive blocked",
        path="armdrive/dialects/bus/observer.py",
        old="(nearer or follows)\n",
        new="nearer\n",
        tests=tests_of("tests/armdrive/dialects/bus/test_observer.py", "test_a_case"),
    ),
    Mutant(
        name="a resumed drive is taken to be where it was read a while ago",
        promise="a late computer calls no healthy drive blocked",
        path="armdrive/dialects/bus/observer.py",
        old="course.put(at, speed, self.asked_s)\n",
        new="course.put(at, speed, now_s)\n",
        tests=tests_of("tests/armdrive/dialects/bus/test_observer.py", "test_a_case"),
    ),
    Mutant(
        name="a resumed drive is taken to turn as fast as it was ordered to",
        promise="a late bus calls no healthy drive blocked",
        path="armdrive/dialects/bus/observer.py",
        old="speed = float(self.count or 0), self.measured_speed or 0.0\n",
        new="speed = self.count, math.copysign(self.course.max_speed, self.goal - self.count)\n",
        tests=tests_of("tests/armdrive/dialects/bus/test_observer.py", "test_a_case"),
    ),
    Mutant(
        name="a motion resumes after an outage before the speeds of its drives are known",
        promise="a late bus calls no healthy drive blocked",
        path="armdrive/dialects/mks/motion.py",
        old="return Signal.LOCATED if self._all_measured and not run.trip.held_back() else None\n",
        new="return None if run.trip.held_back() else Signal.LOCATED\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_busy.py",
            "test_repeated_delays_make_no_drive_seem_elsewhere_or_weak[there_and_back-well_s0-late_s0-lates0-186]",
        ),
    ),
    Mutant(
        name="owed replies that a second outage holds up are taken for lost",
        promise="a late bus calls no healthy drive reset",
        path="armdrive/dialects/bus/ledger.py",
        old="        self._suspicion_ends_s = max(self._suspicion_ends_s, until_s)\n",
        new="",
        tests=tests_of("tests/armdrive/dialects/bus/test_observer.py", "test_a_case"),
    ),
    Mutant(
        name="an MKS drive whose orders were lost is taken to be where they had it",
        promise="a dead host leaves no motion beyond the announced bound",
        path="armdrive/dialects/mks/steering.py",
        old="        if self._is_unconfirmed(drive):\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_host_dies.py",
            "test_a_drive_that_lost_orders_and_readings_stops_as_soon_as_announced[9000-dies0-0.2]",
        ),
    ),
    Mutant(
        name="an MKS drive that rejects its relief is reported to push no more",
        promise="the report of a blocked shaft is true",
        path="armdrive/dialects/mks/stops.py",
        old="    if drive.rejections.pending:\n",
        new="    if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_relief.py",
            "test_a_drive_that_pushes_and_rejects_its_relief_is_reported",
        ),
    ),
    Mutant(
        name="an MKS drive that falls silent is not noticed",
        promise="a drive that falls silent ends the motion of all",
        path="armdrive/dialects/bus/observer.py",
        old="if drive.ledger.unanswered_polls <= (MUTE_POLLS if others else SILENT_POLLS):\n",
        new="if drive:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_controller_motion.py",
            "test_a_bus_that_falls_silent_is_silence",
        ),
    ),
    Mutant(
        name="MKS speeds are doubled",
        promise="a motion is no faster than requested",
        path="armdrive/dialects/mks/steering.py",
        old="        rpm = _whole_rpm(round(needed / COUNTS_S_PER_RPM), most)\n        speed",
        new=(
            "        rpm = _whole_rpm(round(2.0 * needed / COUNTS_S_PER_RPM), 2 * most)\n"
            "        speed"
        ),
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_controller_motion.py",
            "test_motors_keep_in_proportion_however_the_motion_ends",
        ),
    ),
    Mutant(
        name="a drive that counts what no shaft can have turned to is believed",
        promise="a restarted drive is detected at once",
        path="armdrive/dialects/bus/observer.py",
        old="            self._outside += 1\n",
        new="            pass\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_restarting.py",
            "test_a_short_restart_is_found_and_the_drive_goes_no_farther_than_sent[start_speed0-0.21-0.0]",
        ),
    ),
    Mutant(
        name="a drive that answers nothing for a moment is taken for having been there",
        promise="a drive that restarts near its zero is detected by missing replies",
        path="armdrive/dialects/bus/ledger.py",
        old="self.away_s, self.suspected_s = min(self.away_s, self.suspected_s), math.inf",
        new="self.suspected_s = math.inf",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_restarting.py",
            "test_a_steered_drive_that_was_gone_for_a_moment_near_zero_ends_the_motion[0.09-0]",
        ),
    ),
    Mutant(
        name="drives get orders while one of them may have restarted",
        promise="a restarted drive does not turn from its new zero",
        path="armdrive/dialects/mks/steering.py",
        old="        if any(drive.may_have_restarted(wire.now_s) for drive in wire.drives):\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_restarting.py",
            "test_a_drive_that_restarts_gets_no_order_from_its_new_zero[-20000-0.52-0.1]",
        ),
    ),
    Mutant(
        name="the order of a drive that may have restarted is repeated",
        promise="a restarted drive does not turn from its new zero",
        path="armdrive/dialects/mks/motion.py",
        old="        if drive.may_have_restarted(self._wire.now_s):\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_restarting.py",
            "test_a_drive_that_restarts_gets_no_order_from_its_new_zero[-20000-0.47-0.1]",
        ),
    ),
    Mutant(
        name="drives that leave their common way are let pass",
        promise="one lagging drive ends the motion before the arm leaves its path",
        path="armdrive/dialects/bus/observer.py",
        old="        self._looks_off_path += 1\n",
        new="        pass\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_following.py",
            "test_a_slow_drive_never_leads_the_arm_far_off_its_path[9000-0.8]",
        ),
    ),
    Mutant(
        name="a weak drive is let pass",
        promise="a drive that is too weak for its speed is reported",
        path="armdrive/dialects/bus/observer.py",
        old="return slowest if max(found[slowest]) < WEAK_SHARE * best else None",
        new="return None",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_following.py",
            "test_a_drive_that_is_too_slow_for_half_a_second_is_reported[-9000-0.5-12]",
        ),
    ),
    Mutant(
        name="drives are sent on while no drive replies",
        promise="an outage of the bus sends no drive on",
        path="armdrive/dialects/mks/motion.py",
        old="math.isfinite(observer.returned_s) or observer.in_outage(now_s)",
        new="math.isfinite(observer.returned_s)",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_outages.py",
            "test_no_target_is_sent_during_an_outage",
        ),
    ),
    Mutant(
        name="a drive that pushes is left pushing",
        promise="no blocked shaft springs when it comes free",
        path="armdrive/dialects/mks/stops.py",
        old="            if abs(off) <= wire.settings.rest_counts:\n",
        new="            if True:\n",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_relief.py",
            "test_a_shaft_that_is_blocked_around_a_stop_does_not_spring_when_it_is_free[1-acts0]",
        ),
    ),
    Mutant(
        name="a PDO has another drive's id",
        promise="each drive gets its own targets",
        path="firmware_protocol/canopen/services.py",
        old='    RPDO1 = "rpdo1", 0x200\n',
        new='    RPDO1 = "rpdo1", 0x280\n',
        tests=tests_of(
            "tests/firmware_protocol/canopen/test_canopen_messages.py",
            "test_an_id_belongs_to_one_service_and_node",
        ),
    ),
    Mutant(
        name="a CANopen number has its bytes in the wrong order",
        promise="values are encoded as CiA 301 requires",
        path="firmware_protocol/canopen/objects.py",
        old='return number.to_bytes(_SIZES[self], "little", signed=self.signed)',
        new='return number.to_bytes(_SIZES[self], "big", signed=self.signed)',
        tests=tests_of(
            "tests/firmware_protocol/canopen/test_canopen_datatypes.py",
            "test_a_value_is_these_bytes",
        ),
    ),
    Mutant(
        name="a PDO has its bytes in the wrong order",
        promise="values are encoded as CiA 301 requires",
        path="firmware_protocol/canopen/pdo.py",
        old='codec = struct.Struct("<" +',
        new='codec = struct.Struct(">" +',
        tests=tests_of(
            "tests/firmware_protocol/canopen/test_canopen_pdo.py",
            "test_a_target_and_its_controlword_are_these_bytes",
        ),
    ),
    Mutant(
        name="a test's arm is looked up only when the test connects",
        promise="an unknown arm in a test's mark is an error, connected or not",
        path="armdrive/testing/arm_world.py",
        old="self._chosen = None if target is None else find(target).config",
        new="self._chosen = None",
        tests=tests_of(
            "tests/armdrive/testing/test_plugin.py",
            "test_an_unknown_arm_is_one_sentence_even_for_a_test_that_never_connects",
        ),
    ),
    Mutant(
        name="a controlword enables nothing",
        promise="controlwords are encoded as CiA 402 requires",
        path="firmware_protocol/canopen/drives.py",
        old="    ENABLE_OPERATION = (0x8F, 0x0F, 0x0F)",
        new="    ENABLE_OPERATION = (0x8F, 0x0F, 0x07)",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_controller.py",
            "test_switching_on_holds_every_drive_where_it_is_and_is_verified",
        ),
    ),
    Mutant(
        name="a fault is read as ready",
        promise="statuswords are decoded as CiA 402 requires",
        path="firmware_protocol/canopen/drives.py",
        old="    FAULT = (0x4F, 0x08)",
        new="    FAULT = (0x4F, 0x48)",
        tests=tests_of(
            "tests/firmware_protocol/canopen/test_canopen_drive.py",
            "test_a_statusword_tells_its_state",
        ),
    ),
    Mutant(
        name="a CiA 402 drive in fault is not noticed",
        promise="a fault in motion stops the others",
        path="armdrive/dialects/cia402/wire.py",
        old=("        if state in FAULTS:\n            return Alert"),
        new=("        if state in ():\n            return Alert"),
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_controller.py",
            "test_a_drive_in_fault_stops_the_others_which_hold",
        ),
    ),
    Mutant(
        name="CiA 402 drives leap to where a late program should be",
        promise="a late host slows down and does not jump ahead",
        path="armdrive/dialects/cia402/motion.py",
        old="        self.time_s += 0.0 if stand else self._rate * period_s\n",
        new="        self.time_s += 0.0 if stand else 3.0 * self._rate * period_s\n",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_motion.py",
            "test_a_motion_slows_down_for_a_moment_of_silence_and_does_not_jump_ahead[be_late]",
        ),
    ),
    Mutant(
        name="CiA 402 drives that miss their targets are sent on",
        promise="a drive that missed targets does not jump to the latest one",
        path="armdrive/dialects/cia402/motion.py",
        old="self.lead.stands_short(drive) and self.lead.still_s(drive) < SETTLE_S\n",
        new="False\n",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_motion.py",
            "test_a_drive_that_misses_its_targets_is_sent_no_farther_and_makes_up_for_few"
            "[0.08-one drive's targets]",
        ),
    ),
    Mutant(
        name="a CiA 402 drive that blocks a jog is waited for after the release",
        promise="a blocked shaft does not jump to its target after a stop",
        path="armdrive/dialects/cia402/leading.py",
        old="            if self.released() and any(",
        new="            if False and any(",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_blocked.py",
            "test_a_shaft_that_blocks_a_jog_is_held_where_it_stands_within_the_announced_time[cyclic-20000.0-0.005]",
        ),
    ),
    Mutant(
        name="CiA 402 drives are enabled on readings of before the watch was set up",
        promise="enabling moves nothing",
        path="armdrive/dialects/cia402/contact.py",
        old="        yield from self.io.require_positions()  # a hand may have turned a shaft\n",
        new="",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_controller.py",
            "test_a_shaft_turned_by_hand_while_the_watch_is_set_up_is_not_turned_back[0.001]",
        ),
    ),
    Mutant(
        name="a stopped CiA 402 drive in profile mode keeps its set-point ahead of a blocked shaft",
        promise="a blocked shaft does not jump to its target after a stop",
        path="armdrive/dialects/cia402/exchange.py",
        old="        yield from self.hold_here(stopped)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_blocked.py",
            "test_a_blocked_shaft_is_held_where_it_stands",
        ),
    ),
    Mutant(
        name="CiA 402 drives are judged by time in which the program did not run",
        promise="a late computer blames no drive",
        path="armdrive/dialects/exchange.py",
        old="max(min(now_s, self._due_s) - self._now_s, 0.0)",
        new="max(now_s - self._now_s, 0.0)",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_busy.py",
            "test_the_time_by_which_a_program_is_called_late_is_not_listened",
        ),
    ),
    Mutant(
        name="a CiA 402 drive that rests off its target is waited for",
        promise="a drive whose reading is off its target is blamed",
        path="armdrive/dialects/cia402/leading.py",
        old="            elif lead.io.listened.s > self._given_up_s:\n",
        new="            elif False:\n",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_busy.py",
            "test_a_drive_that_is_read_off_its_target_is_blamed_however_late_the_report_is[program]",
        ),
    ),
    Mutant(
        name="CiA 402 targets are not smoothed",
        promise="ramps consist of jumps in speed",
        path="armdrive/dialects/bus/paths.py",
        old="        if not window_s:\n",
        new="        if window_s >= 0.0:\n",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_motion.py",
            "test_smoothing_makes_ramps_of_jumps_in_speed",
        ),
    ),
    Mutant(
        name="a rate gets the next faster setting of the speed table",
        promise="no setting is faster than what was asked for",
        path="armdrive/dialects/speed_table.py",
        old="return settings[max(found - 1, 0)]",
        new="return settings[min(found, len(settings) - 1)]",
        tests=tests_of(
            "tests/armdrive/dialects/test_speed_table.py",
            "test_a_rate_gets_the_fastest_setting_that_is_no_faster",
        ),
    ),
    Mutant(
        name="a slow arm is waited for no longer than a quick one",
        promise="the driver learns the speed of an arm that is slower than its table",
        path="armdrive/dialects/speed_table.py",
        old="            self._known = max(factor, known + (factor - known) / 4.0)",
        new="            self._known = 1.0",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_every_burst_fits_its_announced_length_and_once_measured_really_does[0.5]",
        ),
    ),
    Mutant(
        name="a late driver calls an answer missing that stands behind something else",
        promise="received bytes are read before a reply counts as missing",
        path="armdrive/dialects/exchange.py",
        old="""        while not (until_stop and self.stop_asked):
            message = yield until_s
            if message is None:
""",
        new="""        while self.now_s < until_s:
            message = yield until_s
            if message is None:
""",
        tests=tests_of(
            "tests/armdrive/runtime/test_late_program.py",
            "test_a_late_program_reads_all_that_has_come_before_it_calls_an_answer_missing",
        ),
    ),
    Mutant(
        name="a late look makes a Robko 01 seem slow",
        promise="a program that is late learns nothing wrong about the arm",
        path="armdrive/dialects/robko01/motion.py",
        old="        prompt = self._io.now_s <= due_s + PROMPT_S\n",
        new="        prompt = True\n",
        tests=tests_of(
            "tests/armdrive/runtime/test_late_program.py",
            "test_every_motion_ends_as_it_was_asked_to[robko01-0]",
            "test_every_motion_ends_as_it_was_asked_to[robko01-2]",
        ),
    ),
)
