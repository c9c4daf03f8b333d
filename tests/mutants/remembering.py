"""Records that are written too late, or believed too easily."""

from __future__ import annotations

from .mutant import Mutant

MUTANTS = (
    Mutant(
        name="a motion does not wait for its mark",
        promise="a program that ends in mid-motion leaves no wrong position that is believed",
        path="armdrive/flows/remembering.py",
        old=("    while not memory.mark_stands():\n        if wire.stopping"),
        new=("    while False:\n        if wire.stopping"),
        tests=("tests/armdrive/test_slow_disk.py::test_a_stop_does_not_wait_for_the_disk",),
    ),
    Mutant(
        name="the mark of motion is believed to be kept before it is",
        promise="a program that ends in mid-motion leaves no wrong position that is believed",
        path="armdrive/memory.py",
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
        tests=("tests/armdrive/test_slow_disk.py::test_a_stop_does_not_wait_for_the_disk",),
    ),
    Mutant(
        name="the mark of motion is not written",
        promise="a program that ends in mid-motion leaves no wrong position that is believed",
        path="armdrive/core.py",
        old="            in_motion=in_motion,\n",
        new="            in_motion=False,\n",
        tests=(
            ("tests/armdrive/test_record.py::test_a_restored_position_moves_for_who_allowed_it"),
        ),
    ),
    Mutant(
        name="the mark of motion is cleared at once",
        promise="a program that ends in mid-motion leaves no wrong position that is believed",
        path="armdrive/flows/idling.py",
        old="STILL_S = 2.0",
        new="STILL_S = 0.0",
        tests=(
            (
                "tests/armdrive/test_record.py::test_the_mark_is_taken_away_two_"
                "seconds_after_the_arm_stands"
            ),
        ),
    ),
    Mutant(
        name="a disk that cannot keep the mark lets the arm move",
        promise="an arm whose position cannot be remembered does not move",
        path="armdrive/memory.py",
        old=(
            "        self._moving = False\n        raise StateFileError(self._words(outcome.error))"
        ),
        new="        return True",
        tests=(
            (
                "tests/armdrive/test_record.py::test_an_arm_whose_position_canno"
                "t_be_remembered_does_not_move"
            ),
        ),
    ),
    Mutant(
        name="a record that would mislead stays where its successor cannot be written",
        promise="a program that ends in mid-motion leaves no wrong position that is believed",
        path="armdrive/writing.py",
        old="        if self._refused or any(_misleads(one, record) for one in self._left):",
        new="        if False:",
        tests=(
            (
                "tests/armdrive/test_full_disk.py::test_a_full_disk_keeps_no_mot"
                "or_on_and_leaves_nothing_to_believe"
            ),
        ),
    ),
)
