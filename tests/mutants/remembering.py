"""Records that are written too late, or trusted too easily."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="a motion does not wait for its mark",
        promise="a program that dies in a motion leaves no wrong position that is trusted",
        path="armdrive/motion/context.py",
        old=("    while not memory.mark_stands():\n        if wire.stopping"),
        new=("    while False:\n        if wire.stopping"),
        tests=tests_of(
            "tests/armdrive/storage/test_slow_disk.py",
            "test_no_motion_begins_before_its_mark_is_on_the_disk_and_then_it_does",
        ),
    ),
    Mutant(
        name="the mark of motion is believed to be kept before it is",
        promise="a program that dies in a motion leaves no wrong position that is trusted",
        path="armdrive/runtime/persistence.py",
        old=(
            "        if outcome.number < self._asked_number:\n"
            "            return False\n"
            "        self._moving = False"
        ),
        new=(
            "        if outcome.number < self._asked_number:\n"
            "            return True\n"
            "        self._moving = False"
        ),
        tests=tests_of(
            "tests/armdrive/storage/test_slow_disk.py",
            "test_no_motion_begins_before_its_mark_is_on_the_disk_and_then_it_does",
        ),
    ),
    Mutant(
        name="the mark of motion is not written",
        promise="a program that dies in a motion leaves no wrong position that is trusted",
        path="armdrive/runtime/arm_state.py",
        old="            in_motion=in_motion,\n",
        new="            in_motion=False,\n",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_a_restored_position_allows_motion_if_the_caller_said_so",
        ),
    ),
    Mutant(
        name="the mark of motion is cleared at once",
        promise="a program that dies in a motion leaves no wrong position that is trusted",
        path="armdrive/motion/standing.py",
        old="STILL_S = 2.0",
        new="STILL_S = 0.0",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_the_mark_is_taken_away_two_seconds_after_the_arm_stands",
        ),
    ),
    Mutant(
        name="a disk that cannot keep the mark lets the arm move",
        promise="an arm whose position cannot be remembered does not move",
        path="armdrive/runtime/persistence.py",
        old=(
            "        self._moving = False\n        raise StateFileError(self._words(outcome.error))"
        ),
        new="        return True",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_an_arm_whose_position_cannot_be_remembered_does_not_move",
        ),
    ),
    Mutant(
        name="a record that would mislead stays where its successor cannot be written",
        promise="a program that dies in a motion leaves no wrong position that is trusted",
        path="armdrive/storage/record.py",
        old="        if self._refused or any(_misleads(one, record) for one in self._left):",
        new="        if False:",
        tests=tests_of(
            "tests/armdrive/storage/test_full_disk.py",
            "test_a_full_disk_keeps_no_motor_on_and_leaves_nothing_to_believe",
        ),
    ),
    Mutant(
        name="a closed arm writes on",
        promise="nothing is written after the end",
        path="armdrive/storage/record.py",
        old=("        if self._ended:\n            return\n"),
        new="",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_a_program_that_has_ended_changes_nothing_on_the_disk_any_more",
        ),
    ),
    Mutant(
        name="a record's check is ignored",
        promise="a damaged record is refused",
        path="armdrive/storage/record.py",
        old="    if entries.pop(_CHECK) != checksum({FORMAT_KEY: FORMAT, **entries}):",
        new="    if not entries.pop(_CHECK):",
        tests=tests_of(
            "tests/armdrive/storage/test_record_text.py",
            "test_a_record_with_any_bit_turned_is_refused_or_says_the_same",
        ),
    ),
    Mutant(
        name="a record of another arm is taken up",
        promise="a record of another arm or calibration is refused",
        path="armdrive/runtime/persistence.py",
        old="            record.require_owner(arm, calibration, motors)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_a_record_that_does_not_fit_is_refused_with_the_reason",
        ),
    ),
    Mutant(
        name="a record is renamed before it is on the disk",
        promise="a file outlives a power cut, old or new, never half",
        path="armdrive/storage/files.py",
        old="        files.sync(handle)\n",
        new="",
        tests=tests_of(
            "tests/armdrive/storage/test_power_cuts.py",
            "test_nothing_wrong_is_believed_after_an_end_at_any_moment[host_cut]",
        ),
    ),
    Mutant(
        name="a record's folder is not brought to the disk",
        promise="a file outlives a power cut once it is written",
        path="armdrive/storage/files.py",
        old=(
            "            files.remove(temporary)\n        raise\n"
            "    files.sync_folder(path.parent)\n"
        ),
        new=("            files.remove(temporary)\n        raise\n"),
        tests=tests_of(
            "tests/armdrive/storage/test_power_cuts.py",
            "test_nothing_wrong_is_believed_after_an_end_at_any_moment[host_cut]",
        ),
    ),
    Mutant(
        name="a reference is not recorded",
        promise="a reference is on the disk when the call returns",
        path="armdrive/motion/reference.py",
        old=(
            "    core.learn(confirmed.evidence, wire.now_s)\n"
            "    core.clear_diagnostics()\n"
            "    yield from _settled(wire)\n"
        ),
        new=(
            "    core.learn(confirmed.evidence, wire.now_s)\n"
            "    core.clear_diagnostics()\n"
            "    core.settle()\n"
        ),
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_an_arm_whose_position_cannot_be_remembered_does_not_move",
        ),
    ),
    Mutant(
        name="a lost wire clears the mark of motion",
        promise="a program that dies in a motion leaves no wrong position that is trusted",
        path="armdrive/connect/parts.py",
        old=("        self._core.lose(lost)\n        self._core.remember()\n"),
        new=("        self._core.lose(lost)\n        self._core.mark_still()\n"),
        tests=tests_of(
            "tests/armdrive/storage/test_record.py",
            "test_a_wire_that_is_lost_soon_after_a_motion_leaves_the_mark",
        ),
    ),
)
