"""The desk, the command line, and other programs."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="two programs may hold one arm",
        promise="one program holds an arm at a time",
        path="armdrive/storage/lock_client.py",
        old="        lock.acquire(timeout=0)\n",
        new="        pass\n",
        tests=tests_of(
            "tests/armdrive/storage/test_holder.py",
            "test_a_refused_holder_leaves_none_of_the_names_locked",
        ),
    ),
    Mutant(
        name="a locked arm without a socket is reported as free",
        promise="no arm that another program may move is reported to stand",
        path="armdrive/storage/lock_client.py",
        old="    if lock is None:\n        return True\n",
        new="    if lock is None:\n        return False\n",
        tests=tests_of(
            "tests/armdrive/storage/test_holder.py",
            "test_an_arm_that_is_locked_without_a_socket_is_not_said_to_be_free",
        ),
    ),
    Mutant(
        name="another program cannot stop the setting up of drives",
        promise="stop goes first, from any process",
        path="armdrive/connect/control_socket.py",
        old="        _interrupt_main_thread()\n",
        new="",
        tests=tests_of(
            "tests/armdrive/storage/test_holder.py",
            "test_a_program_without_a_connected_arm_is_stopped_as_by_ctrl_c",
        ),
    ),
    Mutant(
        name="a watchdog's trial that is cut short leaves its short time",
        promise="a trial leaves a drive as it found it, or the user is told",
        path="armdrive/setup/commissioning.py",
        old="                restored = at_hand.set_watchdog(at_hand.watchdog_s)\n",
        new="                restored = True\n",
        tests=tests_of(
            "tests/armdrive/setup/test_can_setup.py",
            "test_a_watchdog_trial_that_is_cut_short_sets_it_back_or_tells_the_user[interrupt]",
        ),
    ),
    Mutant(
        name="another program's stop is ignored",
        promise="a stop comes in over the control socket",
        path="armdrive/connect/control_socket.py",
        old="    arm.request_stop()\n",
        new="",
        tests=tests_of(
            "tests/armdrive/storage/test_holder.py",
            "test_a_stop_comes_in",
        ),
    ),
    Mutant(
        name="another program's pause is ignored",
        promise="a pause comes in over the control socket",
        path="armdrive/connect/control_socket.py",
        old="    arm.pause()\n",
        new="",
        tests=tests_of(
            "tests/armdrive/storage/test_holder.py",
            "test_a_pause_a_resume_and_a_slower_speed_come_in",
        ),
    ),
    Mutant(
        name="real ports are opened although simulation is forced",
        promise="ARMDRIVE_FORCE_SIM keeps every port closed",
        path="armdrive/connect/target.py",
        old='    return os.environ.get("ARMDRIVE_FORCE_SIM", "") not in ("", "0")',
        new="    return False",
        tests=tests_of(
            "tests/armdrive/connect/test_connecting.py",
            "TestForcedSimulation::test_a_port_becomes_the_twin_of_its_arm",
        ),
    ),
    Mutant(
        name="a forced twin shares its arm's record",
        promise="a simulated arm does not touch the real arm's record",
        path="armdrive/connect/target.py",
        old='replace(config, name=f"{SIM}{config.name}"), simulated=True)',
        new="config, simulated=True)",
        tests=tests_of(
            "tests/armdrive/connect/test_connecting.py",
            ("TestForcedSimulation::test_the_twin_never_touches_the_record_of_the_real_arm"),
        ),
    ),
    Mutant(
        name="a command that failed ends with 0",
        promise="the exit code tells what went wrong",
        path="armdrive/cli/runner.py",
        old="        return _say(options, error, error.exit_code)\n",
        new="        return _say(options, error, 0)\n",
        tests=tests_of(
            "tests/armdrive/cli/test_cli_simulated.py",
            "test_planned_motion_without_a_reference_is_refused_with_the_way_to_one",
        ),
    ),
    Mutant(
        name="a file that a person names is overwritten unasked",
        promise="no command and no call loses a file that it was not told to overwrite",
        path="armdrive/storage/files.py",
        old="    if path.exists() and not overwrite:\n",
        new="    if False:\n",
        tests=tests_of(
            "tests/armdrive/cli/test_named_files.py",
            "test_a_file_goes_into_a_folder_that_exists_and_over_another_only_with_force",
        ),
    ),
    Mutant(
        name="a stop ends only one jog of a line",
        promise="after a stop nothing moves until a person asks again",
        path="armdrive/cli/terminal_operator.py",
        old="                if self._lasts(request):",
        new="                if True:",
        tests=tests_of(
            "tests/armdrive/cli/test_guiding.py",
            "test_a_stop_in_the_middle_of_a_line_ends_the_line",
        ),
    ),
    Mutant(
        name="a place is taught from a position that nobody confirmed",
        promise="a position is trusted only on evidence",
        path="armdrive/cli/drive/move.py",
        old="allow_restored=options.allow_restored) as arm:\n",
        new="allow_restored=True) as arm:\n",
        tests=tests_of(
            "tests/armdrive/cli/test_cli_simulated.py",
            "test_a_place_is_taught_only_once_the_arm_is_known_to_stand_there",
        ),
    ),
    Mutant(
        name="a refused preview ends well",
        promise="a preview ends as the motion would",
        path="armdrive/cli/drive/move.py",
        old="    if refusal is not None:\n        raise refusal\n",
        new="",
        tests=tests_of(
            "tests/armdrive/cli/test_cli_simulated.py",
            "test_a_goal_beyond_a_bound_is_refused_and_nothing_moves",
        ),
    ),
    Mutant(
        name="a refusal has the exit code of a fault",
        promise="the exit code tells what went wrong",
        path="armdrive/errors/__init__.py",
        old=(
            '    """The call was refused before anything was sent: nothing '
            'moved."""\n'
            "\n"
            "    exit_code = 3"
        ),
        new=(
            '    """The call was refused before anything was sent: nothing '
            'moved."""\n'
            "\n"
            "    exit_code = 1"
        ),
        tests=tests_of(
            "tests/armdrive/cli/test_cli_simulated.py",
            "test_planned_motion_without_a_reference_is_refused_with_the_way_to_one",
        ),
    ),
    Mutant(
        name="letting go of the mouse does not end a jog",
        promise="a released input ends its jog",
        path="tui/jog/jogging.py",
        old=(
            '            self.held_button, self._renew_s = "", math.inf\n'
            "            self._tell(self._arm.release)\n"
        ),
        new='            self.held_button, self._renew_s = "", math.inf\n',
        tests=tests_of(
            "tests/tui/jog/test_jogging.py",
            "test_it_is_renewed_before_it_ends_and_let_go_when_the_button_is",
        ),
    ),
    Mutant(
        name="a released key does not release the arm",
        promise="a released key ends its jog",
        path="tui/jog/jogging.py",
        old=("        else:\n            self._arm.release()\n            if"),
        new=("        else:\n            if"),
        tests=tests_of(
            "tests/tui/test_desk.py",
            "test_holding_a_key_jogs_and_letting_go_stops",
        ),
    ),
    Mutant(
        name="the keys stay armed when the desk loses its focus",
        promise="a desk that loses the focus releases its jog",
        path="tui/desk.py",
        old='        self.disarm("the terminal lost the keyboard focus")\n',
        new="",
        tests=tests_of(
            "tests/tui/test_desk.py",
            "test_what_ends_a_hold_at_once",
        ),
    ),
    Mutant(
        name="the keys stay armed in error-stop",
        promise="the first key after a reset moves nothing",
        path="tui/desk.py",
        old="            hand.disarm(why)  # the first key",
        new="            pass  # the first key",
        tests=tests_of(
            "tests/tui/test_desk_link.py",
            "test_a_state_in_which_nothing_can_move_disarms_and_says_how_to_leave_it",
        ),
    ),
    Mutant(
        name="the desk's stop key only disarms",
        promise="the stop key stops the arm",
        path="tui/desk.py",
        old=('        self.arm.request_stop()\n        self.disarm("stopped")'),
        new='        self.disarm("stopped")',
        tests=tests_of(
            "tests/tui/test_desk.py",
            "test_stop_keys_stop_disarm_and_close_whatever_is_open",
        ),
    ),
    Mutant(
        name="the desk's emergency stop is none",
        promise="the emergency stop key latches",
        path="tui/desk.py",
        old="        self._arm.estop()\n",
        new="",
        tests=tests_of(
            "tests/tui/test_desk.py",
            "test_every_other_key_of_the_table_does_what_it_says",
        ),
    ),
    Mutant(
        name="limits are shown as if they held before the arm is referenced",
        promise="a position is trusted only as far as the evidence goes",
        path="tui/jog/panels.py",
        old="    return status.trust is Trust.REFERENCED\n",
        new="    return status.joints is not None\n",
        tests=tests_of(
            "tests/tui/jog/test_jogging.py",
            "test_limits_are_shown_only_where_they_end_a_jog",
        ),
    ),
    Mutant(
        name="a refused jog is refused in words when it could start again",
        promise="a refusal lasts no longer than its reason",
        path="armdrive/runtime/arm_state.py",
        old="            self.diagnostics.change_state()\n",
        new="            pass\n",
        tests=tests_of(
            "tests/armdrive/motion/jog/test_jogging_flow.py",
            "test_a_jog_that_is_refused_in_a_motion_is_refused_no_longer_than_the_motion_lasts",
        ),
    ),
    Mutant(
        name="a point is taught where the arm only passes",
        promise="a position is trusted only as far as the evidence goes",
        path="tui/points/edit.py",
        old="        if link.moves and not link.status.paused:\n",
        new="        if False:\n",
        tests=tests_of(
            "tests/tui/points/test_points_screen.py",
            "test_no_point_is_taught_while_the_arm_moves",
        ),
    ),
    Mutant(
        name="two pasted line ends confirm a motion",
        promise="nothing moves by surprise",
        path="tui/app.py",
        old="            if self._hasty:  #",
        new="            if False:  #",
        tests=tests_of(
            "tests/tui/test_desk_suspended.py",
            "test_two_pasted_line_ends_confirm_no_motion",
        ),
    ),
    Mutant(
        name="the first letter of a paste turns a motor",
        promise="nothing moves by surprise",
        path="tui/keys/presses.py",
        old="        if quiet_s < QUIET_S or (count",
        new="        if (quiet_s < QUIET_S and self._needed == 2) or (count",
        tests=tests_of(
            "tests/tui/keys/test_presses.py",
            "test_enough_presses_of_one_key_are_done_once[a step, too early]",
        ),
    ),
    Mutant(
        name="a pasted word answers the question that it asks",
        promise="nothing moves by surprise",
        path="tui/dialogs.py",
        old="        if not (answer and self._hasty()):\n            self.dismiss",
        new="        if True:\n            self.dismiss",
        tests=tests_of(
            "tests/tui/test_desk_suspended.py",
            "test_a_pasted_word_answers_no_question_that_it_asks",
        ),
    ),
    Mutant(
        name="keys that were typed before a stop act behind it",
        promise="keys typed before a stop begin nothing",
        path="tui/keys/presses.py",
        old="            return bool(self._acted)\n",
        new="            return False\n",
        tests=tests_of(
            "tests/tui/keys/test_presses.py",
            "test_a_stop_that_never_came_is_forgotten_with_the_next",
        ),
    ),
    Mutant(
        name="a mouse that stops reporting keeps its jog",
        promise="an input that stops reporting ends its jog",
        path="tui/jog/jogging.py",
        old="        left_s = self._last_event_s + MOUSE_HOLDS_S - now_s\n",
        new="        left_s = MOUSE_HOLDS_S\n",
        tests=tests_of(
            "tests/tui/jog/test_jogging.py",
            "test_a_mouse_that_is_heard_of_no_more_holds_nothing_after_its_time",
        ),
    ),
    Mutant(
        name="a signal between two steps leaves another one deaf",
        promise="Ctrl-C and SIGTERM end a program whenever they come",
        path="armdrive/runtime/clock.py",
        old="        if self._deferring:\n",
        new="        if True:\n",
        tests=tests_of(
            "tests/armdrive/runtime/test_signals_between_steps.py",
            "test_a_handler_that_raises_in_between_leaves_the_other_signals_working",
        ),
    ),
    Mutant(
        name="the terminal of a shell is opened as a port",
        promise="no byte for an arm is typed into another program's terminal",
        path="armdrive/transports/ports.py",
        old="    if user is None:\n        return\n",
        new="    return\n",
        tests=tests_of(
            "tests/armdrive/transports/test_serial_port.py",
            "test_the_terminal_of_another_program_is_not_opened",
        ),
    ),
    Mutant(
        name="callers of other users are answered",
        promise="the control socket is only for this user",
        path="armdrive/storage/files.py",
        old="    return user is None or user in (0, os.getuid())",
        new="    return True",
        tests=tests_of(
            "tests/armdrive/test_security.py",
            "test_a_caller_who_is_somebody_else_is_hung_up_on",
        ),
    ),
    Mutant(
        name="a misspelt attribute of an arm is accepted",
        promise="a program that slows an arm slows it, or is told that it does not",
        path="armdrive/errors/arguments.py",
        old="            _require_known(self, name, value)\n",
        new="            pass\n",
        tests=tests_of(
            "tests/armdrive/arm/test_arguments.py",
            "test_a_misspelt_attribute_changes_nothing_and_the_nearest_one_is_named",
        ),
    ),
    Mutant(
        name="the log shows what a call was given as Python has it",
        promise="the log tells in words what was asked of the arm",
        path="armdrive/trace/recorder.py",
        old="    said = (*map(valued, arguments),",
        new="    said = (*map(repr, arguments),",
        tests=tests_of(
            "tests/armdrive/trace/test_wording.py",
            "test_a_call_is_told_in_words",
        ),
    ),
    Mutant(
        name="a time below zero is accepted",
        promise="no call takes a time that is none",
        path="armdrive/errors/arguments.py",
        old="    if time_s < 0.0:\n",
        new="    if time_s < -1e9:\n",
        tests=tests_of(
            "tests/armdrive/arm/test_arguments.py",
            "test_a_time_below_zero_is_refused_and_nothing_happens",
        ),
    ),
    Mutant(
        name="a program may wait for longer than any computer runs",
        promise="every wait that a program asks for has an end",
        path="armdrive/errors/arguments.py",
        old="    if _time_s(name, value) > LONGEST_TIME_S:\n",
        new="    if _time_s(name, value) > 1e308:\n",
        tests=tests_of(
            "tests/armdrive/runtime/test_pace.py",
            "test_a_time_that_no_simulation_reaches_the_end_of_is_refused",
        ),
    ),
    Mutant(
        name="watching an arm that nobody drives is said to have stopped it",
        promise="an error says what it did to the arm",
        path="armdrive/cli/drive/control_requests.py",
        old='        raise HolderError("no program of yours is driving an arm")\n',
        new='        raise ArmError("no program of yours is driving an arm")\n',
        tests=tests_of(
            "tests/armdrive/cli/look/test_cli_holding.py",
            "test_an_arm_without_a_holder_is_neither_watched_nor_recorded_and_nothing_was_stopped",
        ),
    ),
    Mutant(
        name="the desk promises a stop while the link is lost",
        promise="a person who cannot stop the arm by a key is told so",
        path="tui/desk.py",
        old="        hint = without_link(status, desk.keys) if lost else self.hint\n",
        new="        hint = self.hint\n",
        tests=tests_of(
            "tests/tui/test_desk_link.py",
            "test_a_lost_link_promises_no_stop_and_says_how_the_arm_ends",
        ),
    ),
)
