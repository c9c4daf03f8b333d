"""Stop bounds that are broken, or inflated."""

from __future__ import annotations

from .mutant import Mutant, tests_of

MUTANTS = (
    Mutant(
        name="the time of a stop is announced five times too long",
        promise="an announced bound is not inflated: the worst case reaches half of it",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(5.0 * self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the time of a stop is announced half as long",
        promise="no announced bound is broken",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(0.5 * self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the way of a stop is announced five times too long",
        promise="an announced bound is not inflated: the worst case reaches half of it",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(self.time_s, 5.0 * asked_mm, self.silent_time_s, silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the way of a stop is announced half as long",
        promise="no announced bound is broken",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(self.time_s, 0.5 * asked_mm, self.silent_time_s, silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the time of a program that dies is announced five times too long",
        promise="an announced bound is not inflated: the worst case reaches half of it",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(self.time_s, asked_mm, 5.0 * self.silent_time_s, silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the time of a program that dies is announced half as long",
        promise="no announced bound is broken",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(self.time_s, asked_mm, 0.5 * self.silent_time_s, silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the way of a program that dies is announced five times too long",
        promise="an announced bound is not inflated: the worst case reaches half of it",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(self.time_s, asked_mm, self.silent_time_s, 5.0 * silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
    Mutant(
        name="the way of a program that dies is announced half as long",
        promise="no announced bound is broken",
        path="armdrive/stopping.py",
        old=("        return StopBound(self.time_s, asked_mm, self.silent_time_s, silent_mm)\n"),
        new=(
            "        return StopBound(self.time_s, asked_mm, self.silent_time_s, 0.5 * silent_mm)\n"
        ),
        tests=tests_of(
            "tests/bounds/test_bounds.py",
            "test_the_worst_case_keeps_its_bound_and_reaches_half_of_it",
        ),
    ),
)
