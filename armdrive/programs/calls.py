"""The calls that a script makes of its arms, and the line of the script that made each.

They are heard where the flight recorder hears them. A call that another call makes, as `park` makes
`move_to`, is not the script's own.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

from armdrive.recorder import calls as recorded

if TYPE_CHECKING:
    from types import FrameType

    from armdrive.arm import Arm
    from armdrive.recorder.witness import Witness

DEEPEST = 1000
"""So many frames are looked through for a line of the script."""


@dataclass(frozen=True, slots=True)
class ScriptCall:
    """A call of a script. `line` is 0 where another file or another thread made it."""

    arm: str
    name: str
    line: int
    at_s: float


Told = Callable[["Arm", ScriptCall], object]


class CallWitness:
    """Tells of an arm's calls on their way to the witness that it had before."""

    def __init__(self, arm: Arm, script: str, told: Told) -> None:
        self._arm = arm
        self._script = script
        self._told = told
        self._inner = arm.witness

    def called(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Hear of a call, and tell of it if it is the script's own."""
        line = script_line(sys._getframe(1), self._script)  # noqa: SLF001 - the noted call's own
        if line is not None:
            now_s = self._arm.pace.now_s()
            self._told(self._arm, ScriptCall(self._arm.config.name, name, line, now_s))
        self._inner.called(name, words, named)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


def watch_calls(arm: Arm, script: str, told: Told) -> None:
    """Have the calls of an arm told that a script makes; `told` may raise to refuse one."""
    arm.witness = cast("Witness", CallWitness(arm, script, told))


def script_line(frame: FrameType | None, script: str) -> int | None:
    """Return the line of the script from which a call comes, 0 where none is on its way.

    None of a call within another one. `frame` is the noted call's own.
    """
    line = 0
    frame = None if frame is None else frame.f_back
    for _ in range(DEEPEST):
        if frame is None:
            break
        if frame.f_code.co_filename == recorded.__file__:
            return None
        if not line and frame.f_code.co_filename == script:
            line = frame.f_lineno
        frame = frame.f_back
    return line
