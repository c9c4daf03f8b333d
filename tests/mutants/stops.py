"""Stops without effect, and motion that does not expire."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="a stop reports success though the arm did not answer it",
        promise="a motion ends where it was asked to, or an error says why not",
        path="armdrive/arm/__init__.py",
        old="            raise stopped.error\n",
        new="            pass\n",
        tests=tests_of(
            "tests/armdrive/motion/test_faults_in_motion.py",
            "test_a_stop_says_that_the_arm_did_not_answer_it",
        ),
    ),
    Mutant(
        name="a stop is not asked for",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/connect/parts.py",
        old=("        self.engine.stop_asked = True\n        self.pace.wake()"),
        new="        self.pace.wake()",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_stopped_arm_stands_within_the_stated_time_and_way[0.0-begin_planned-0.02-0.15]",
        ),
    ),
    Mutant(
        name="a stop does not end a motion between its bursts",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/motion/execute.py",
        old="while done < 1.0 and not (wire.stopping or is_released()):",
        new="while done < 1.0 and not is_released():",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_stopped_arm_stands_within_the_stated_time_and_way[0.0-begin_planned-0.02-0.15]",
        ),
    ),
    Mutant(
        name="a stop is not passed on to the device",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/runtime/engine.py",
        old=("            self._stopping()\n            self.controller.stop(hard=self.stop_hard)"),
        new="            self._stopping()",
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[leaving an emergency stop moves nothing-grbl]",
        ),
    ),
    Mutant(
        name="a stop does not end a queued motion's drawing",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/grbl/motion.py",
        old=(
            "            if self.io.stop_asked or request.released():\n"
            "                return (yield from self._halt(trip))"
        ),
        new=(
            "            if request.released():\n"
            "                return (yield from self._halt(trip))"
        ),
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[leaving an emergency stop moves nothing-grbl]",
        ),
    ),
    Mutant(
        name="a GRBL stop sends no feed hold",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/grbl/stops.py",
        old=("                self.exchange.press(Realtime.FEED_HOLD)\n            seen = yield"),
        new=("                pass\n            seen = yield"),
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller.py",
            "test_a_stop_brakes_and_does_not_only_send_no_more",
        ),
    ),
    Mutant(
        name="a GRBL jog is not cancelled",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/grbl/stops.py",
        old="        self.exchange.press(Realtime.JOG_CANCEL)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller.py",
            "test_a_jog_that_is_let_go_ends_soon_and_only_cancels",
        ),
    ),
    Mutant(
        name="a Robko is not sent its stop",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/robko01/motion.py",
        old='if (yield from self._exchange.ask(Stop(), text="STOP")) is None:',
        new="if (yield from self._exchange.mask()) is None:",
        tests=tests_of(
            "tests/armdrive/dialects/robko01/test_robko01_stop.py",
            "test_a_stop_during_a_look_goes_out_as_soon_as_the_look_is_answered",
        ),
    ),
    Mutant(
        name="MKS drives are not sent their stop",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/mks/stops.py",
        old='wire.put(drive, Stop(Code.ABSOLUTE_AXIS, ramp), "STOP")',
        new="pass",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_stops.py",
            "test_drives_that_brake_get_the_stop_once",
        ),
    ),
    Mutant(
        name="CiA 402 drives are not sent their quick stop",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/cia402/leading.py",
        old="lead.io.command(drive, STOP, lead.states.mode_of(drive))",
        new="lead.io.command(drive, ENABLE, lead.states.mode_of(drive), drive.shaft.goal)",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_motion.py",
            "test_drives_that_were_cut_off_for_a_moment_do_not_jump_far[0.15-alone]",
        ),
    ),
    Mutant(
        name="a stop waits for the states of CiA 402 drives after an outage",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/cia402/leading.py",
        old="given_up=lambda: self.io.stop_asked)",
        new="given_up=never)",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_controller.py",
            "test_a_stop_goes_before_the_states_that_are_asked_for_after_an_outage",
        ),
    ),
    Mutant(
        name="an Armdroid's burst that was stopped before its letter continues",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/armdroid/controller.py",
        old=(
            "            if self._io.stop_asked or released():\n"
            "                self._board.give_up()"
        ),
        new=("            if released():\n                self._board.give_up()"),
        tests=tests_of(
            "tests/armdrive/dialects/armdroid/test_armdroid_controller.py",
            "TestConversation::test_a_stop_before_the_letter_lets_nothing_begin",
        ),
    ),
    Mutant(
        name="a stop of an arm that stands ends the next motion",
        promise="a stop ends the running task, and nothing else",
        path="armdrive/runtime/engine.py",
        old=(
            "                self.stop_asked = self.stop_hard = False  # nothing is left to stop\n"
        ),
        new="",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_second_emergency_stop_during_the_reset_is_not_lost",
        ),
    ),
    Mutant(
        name="an emergency stop is a soft one",
        promise="an emergency stop stops a device without a ramp if it can",
        path="armdrive/connect/parts.py",
        old="        self.engine.stop_hard = self.engine.stop_hard or hard\n",
        new="",
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[leaving an emergency stop moves nothing-grbl]",
        ),
    ),
    Mutant(
        name="an emergency stop does not latch",
        promise="an emergency stop latches; only reset leaves it",
        path="armdrive/arm/__init__.py",
        old='self.core.fault("emergency stop: look',
        new='self.core.diagnostics.notify("emergency stop: look',
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_second_emergency_stop_during_the_reset_is_not_lost",
        ),
    ),
    Mutant(
        name="enabling leaves error-stop",
        promise="only reset leaves error-stop",
        path="armdrive/runtime/states.py",
        old="        (s.ERROR_STOP, e.RESET): s.STANDBY,\n",
        new=(
            "        (s.ERROR_STOP, e.RESET): s.STANDBY,\n"
            "        (s.ERROR_STOP, e.ENABLE): s.STANDBY,\n"
        ),
        tests=tests_of(
            "tests/armdrive/runtime/test_states.py",
            "test_only_reset_and_a_lost_wire_leave_error_stop",
        ),
    ),
    Mutant(
        name="motion begins while the motors are off",
        promise="motion begins only in standby",
        path="armdrive/runtime/states.py",
        old="        (s.STANDBY, e.MOVE): s.MOVING,\n",
        new=("        (s.STANDBY, e.MOVE): s.MOVING,\n        (s.DISABLED, e.MOVE): s.MOVING,\n"),
        tests=tests_of(
            "tests/armdrive/runtime/test_states.py",
            "test_motion_begins_in_standby_alone",
        ),
    ),
    Mutant(
        name="a reset moves the arm",
        promise="leaving an error moves nothing",
        path="armdrive/motion/standing.py",
        old="    weigh_difference(wire, core.position.compare(registers))\n    yield from comp",
        new=(
            "    at = core.position.acknowledged\n"
            "    yield from wire.move(at + type(at)([40] * len(at)), 100.0, None)\n"
            "    weigh_difference(wire, core.position.compare(registers))\n"
            "    yield from comp"
        ),
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_reset_right_behind_the_emergency_stop_waits_for_the_burst",
        ),
    ),
    Mutant(
        name="a reset takes no notice of what the device reports meanwhile",
        promise="error-stop latches what a device reports",
        path="armdrive/motion/standing.py",
        old="    if core.diagnostics.error:  # reported after",
        new="    if False:  # reported after",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_what_the_device_reports_during_the_reset_stays_latched",
        ),
    ),
    Mutant(
        name="connecting moves the arm",
        promise="connecting moves nothing",
        path="armdrive/motion/standing.py",
        old="    core.memory.taken_up()  # only now",
        new=(
            "    if not switched:\n"
            "        at = core.position.acknowledged\n"
            "        yield from wire.move(at + type(at)([40] * len(at)), 100.0, None)\n"
            "    core.memory.taken_up()  # only now"
        ),
        tests=tests_of(
            "tests/armdrive/runtime/test_trust.py",
            "test_no_planned_motion_without_a_reference_and_no_byte_of_one",
        ),
    ),
    Mutant(
        name="closing an arm does not stop it",
        promise="an arm that is closed stands",
        path="armdrive/arm/connected.py",
        old=("                await parts.runner.stop()\n                with parts.pace.lock:"),
        new="                with parts.pace.lock:",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_closing_ends_a_motion_under_way_and_the_arm_stands",
        ),
    ),
    Mutant(
        name="a suspended program continues its motion",
        promise="a jog that the user no longer expects does not move",
        path="armdrive/runtime/engine.py",
        old=('            self.stop_asked = True\n            self.stop_why = f": this'),
        new='            self.stop_why = f": this',
        tests=tests_of(
            "tests/armdrive/runtime/test_suspended.py",
            "test_a_motion_does_not_go_on_when_its_program_wakes_and_the_arm_is_no_slower[teachmover]",
        ),
    ),
    Mutant(
        name="orders that are late are sent all the same",
        promise="a jog that the user no longer expects does not move",
        path="armdrive/runtime/engine.py",
        old=("return not self.stop_asked and self.round_s() > self.controller.abilities.order_s"),
        new="return False",
        tests=tests_of(
            "tests/armdrive/runtime/test_suspended.py",
            "test_bytes_prepared_before_the_drives_stopped_are_not_sent",
        ),
    ),
    Mutant(
        name="a motion begins while another one runs",
        promise="the second of two motions at once is refused",
        path="armdrive/runtime/engine.py",
        old="busy = self._task is not None and not self._task.routine and alone",
        new="busy = False",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_motion_does_not_wait_behind_work_that_moves_nothing",
        ),
    ),
    Mutant(
        name="a motion that a stop overtook while it was planned begins",
        promise="nothing that was decided before a stop begins after it",
        path="armdrive/arm/moving.py",
        old=(
            "            made = prepare(move, self.ground())\n            if runner.stops != asked:"
        ),
        new=("            made = prepare(move, self.ground())\n            if False:"),
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_stop_between_a_call_and_its_plan_lets_nothing_begin",
        ),
    ),
    Mutant(
        name="a stop that came since a move was decided on is forgotten",
        promise="nothing that was decided before a stop begins after it",
        path="armdrive/arm/moving.py",
        old="        asked = runner.stops if stops is None else stops",
        new="        asked = runner.stops",
        tests=tests_of(
            "tests/armdrive/test_moves.py",
            "test_a_stop_that_came_since_a_move_was_decided_on_keeps_it_from_beginning",
        ),
    ),
    Mutant(
        name="every move of a sequence is planned from where the arm stands",
        promise="a sequence is audited as a whole, each move from where the one before ends",
        path="armdrive/motion/resolve.py",
        old="                ground = ground.at(made.plans[-1].end if made.plans else ground.here)",
        new="                ground = ground.at(ground.here)",
        tests=tests_of(
            "tests/armdrive/test_moves.py",
            "test_a_sequence_does_what_its_moves_do_one_after_another",
        ),
    ),
    Mutant(
        name="a change in the tool's frame stays one when it is resolved",
        promise="a relative move is never made twice",
        path="armdrive/motion/resolve.py",
        old="            return LineMove(ground.in_base(pose, move.frame), move.speed)",
        new="            return move",
        tests=tests_of(
            "tests/armdrive/test_moves.py",
            "test_a_change_that_is_resolved_is_made_once_however_often_it_is_run",
        ),
    ),
    Mutant(
        name="an interrupted sequence is done again from its beginning",
        promise="an interrupted program continues with the rest of its move",
        path="armdrive/programs/journal.py",
        old="MoveSequence(moves[last:])",
        new="MoveSequence(moves)",
        tests=tests_of(
            "tests/armdrive/programs/test_resuming.py",
            "test_what_is_left_of_a_sequence_is_what_was_not_yet_done",
        ),
    ),
    Mutant(
        name="a rehearsal allows motion that the controller's settings forbid",
        promise="a rehearsal is refused what the run would be refused",
        path="armdrive/programs/rehearsal.py",
        old="        made.core.differences = seen.differences\n",
        new="",
        tests=tests_of(
            "tests/armdrive/programs/test_rehearsal.py",
            "test_a_rehearsal_is_refused_while_the_controllers_settings_differ",
        ),
    ),
    Mutant(
        name="a rehearsal allows Cartesian goals of an arm that was not measured",
        promise="a rehearsal is refused what the run would be refused",
        path="armdrive/programs/rehearsal.py",
        old="    made.core.geometry_known = seen.geometry_known",
        new="    made.core.geometry_known = True",
        tests=tests_of(
            "tests/armdrive/programs/test_rehearsal.py",
            "test_an_arm_whose_lengths_are_not_measured_is_refused_cartesian_goals_in_the_rehearsal",
        ),
    ),
    Mutant(
        name="raw steps turn the motors for hours",
        promise="a motion that must be a slip is refused before its first byte",
        path="armdrive/arm/moving.py",
        old="        if takes_s > LONGEST_BENCH_S:",
        new="        if False:",
        tests=tests_of(
            "tests/armdrive/arm/test_arguments.py", "test_the_sentence_says_what_was_expected"
        ),
    ),
    Mutant(
        name="a burst is as long as its whole leg",
        promise="motion expires: nothing is sent further ahead than announced",
        path="armdrive/motion/execute.py",
        old="        share = next_share(wire, slowed, burst_s, done)\n",
        new="        share = 1.0 - done\n",
        tests=tests_of(
            "tests/armdrive/runtime/test_stopping.py",
            "test_a_stopped_arm_stands_within_the_stated_time_and_way[0.0-begin_planned-0.02-0.15]",
        ),
    ),
    Mutant(
        name="MKS segments are drawn as soon as there are any",
        promise="motion expires: nothing is sent further ahead than announced",
        path="armdrive/dialects/mks/steering.py",
        old="return left_s <= 0.0 or left_s + self._feed.latest_s <= self.ahead_s + 1e-6",
        new="return True",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_controller_motion.py",
            "test_the_next_segment_is_drawn_no_earlier_than_announced",
        ),
    ),
    Mutant(
        name="CiA 402 drives do not mind the program's heartbeat",
        promise="a dead program's arm stops in the announced time",
        path="armdrive/dialects/cia402/contact.py",
        old="wanted.value if on else 0",
        new="0",
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_controller.py",
            "test_switching_on_holds_every_drive_where_it_is_and_is_verified",
        ),
    ),
    Mutant(
        name="a CiA 402 drive's missing heartbeat is not noticed",
        promise="a drive that falls silent is noticed",
        path="armdrive/dialects/cia402/exchange.py",
        old="            if drive.missed > POLLS_LOST and not drive.reported:",
        new="            if False:",
        tests=tests_of(
            "tests/conformance/test_conformance.py",
            "test_on_simulated_time[a drive goes mute, standing-cia402]",
        ),
    ),
    Mutant(
        name="a stop is not repeated to MKS drives that missed it",
        promise="a stop goes first, in every state, and ends what moves",
        path="armdrive/dialects/mks/stops.py",
        old="            if self._unconfirmed and now_s > self._began_s:",
        new="            if False:",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_stops.py",
            "test_a_stop_is_repeated_until_the_drive_answers",
        ),
    ),
    Mutant(
        name="queued motions are sent ten seconds ahead",
        promise="motion expires: nothing is sent further ahead than announced",
        path="armdrive/motion/execute.py",
        old="MoveAlong(segments, ahead_s, jog,",
        new="MoveAlong(segments, 10.0, jog,",
        tests=tests_of(
            "tests/armdrive/dialects/grbl/test_grbl_controller.py",
            "test_a_board_whose_driver_dies_stops_in_the_announced_time_and_way[begin_planned-0.1]",
        ),
    ),
    Mutant(
        name="the MKS drives' watchdog is not set",
        promise="a dead program's arm stops in the announced time",
        path="armdrive/dialects/mks/contact.py",
        old='found = yield from wire.ask(dict.fromkeys(wire.drives, timeout), text="WATCHDOG")',
        new="return True",
        tests=tests_of(
            "tests/armdrive/dialects/mks/test_mks_controller.py",
            "test_switching_on_sets_the_watchdog_and_reads_it_back",
        ),
    ),
    Mutant(
        name="the program sends no heartbeat",
        promise="drives that need a heartbeat get it",
        path="armdrive/dialects/cia402/wire.py",
        old="        return self._data",
        new='        return b""',
        tests=tests_of(
            "tests/armdrive/dialects/cia402/test_cia402_controller.py",
            (
                "test_a_program_that_falls_silent_has_the_drives_hold_and_nothin"
                "g_moves_when_it_wakes"
            ),
        ),
    ),
)
