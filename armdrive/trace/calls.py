"""Which calls of a program or a person are noted, and how: a wrapper around each.

What a call raises is noted as well. A stop is not in the table: a signal handler may ask for one,
and the engine sees it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

C = TypeVar("C", bound=type)
R = TypeVar("R")

CALLS = (
    "home", "confirm_reference", "confirm_restored", "declare_posture",
    "go", "move_j", "move_to", "move_l", "move_c", "move_path", "move_motors", "move_gripper",
    "park", "jog_j", "jog_l", "hold", "nudge", "release",
    "enable", "disable", "reset", "estop", "mend_settings", "set_outputs", "read_inputs",
    "wait_inputs", "grasp", "feel", "verify", "pause", "resume",
    "read_pendant_program", "write_pendant_program",
)  # fmt: skip
"""The methods of an arm or of its gripper whose calls are noted."""


def witnessed(kind: C) -> C:
    """Have the calls of a class noted by the witness of its arm."""
    for name in CALLS:
        method = getattr(kind, name, None)
        if method is not None:
            setattr(kind, name, _noted(name, method))
    return kind


def _noted(name: str, method: Callable[..., R]) -> Callable[..., R]:
    @functools.wraps(method)
    def call(self: Any, *words: Any, **named: Any) -> R:
        arm = getattr(self, "_arm", self)
        witness = arm.witness  # no lock: an emergency stop waits for nobody
        witness.called(name, words, named)
        try:
            return method(self, *words, **named)
        except BaseException as error:
            witness.raised(error)
            raise

    return call
