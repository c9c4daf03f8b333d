"""What differs from one Robko 01 to another, as the section [robko01] of an arm file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from armdrive.errors import ArmFileError
from armdrive.sections import within


@dataclass(frozen=True, slots=True)
class Board:
    """What is taken of a board where the arm file says nothing.

    A motor has a chance to make a step every `step_chance_s` (0: whenever it wants). Firmware
    that does not obey speeds moves every axis at `max_rate_hz`.
    """

    acceleration_steps_s2: float
    max_rate_hz: float
    step_chance_s: float
    obeys_speed: bool = True


BOARDS: Mapping[str, Board] = MappingProxyType(
    {
        # seen in a processor simulator: one bus for eight addresses, one of them a millisecond
        "avr": Board(700.0, 125.0, 0.008),
        # the retrofit's own build: robko01/robko01_retrofit_fw include/ApplicationConfiguration.h
        # whose main.cpp sets the top speeds once, and never from a request
        "esp32": Board(75.0, 100.0, 0.0, obeys_speed=False),
    }
)


@dataclass(frozen=True, slots=True)
class RobkoSettings:
    """The board and what is unverified of it; None takes what `BOARDS` has.

    `speed_doubt` is how much slower the arm may be than computed until it has been measured.
    `watchdog_s` is the firmware's (0: it has none). `boot_s` is how long the first answer may
    take, and `answer_margin_s` is added to every deadline. `counts_check` is for firmware that
    counts the check bytes into the length.
    """

    board: str = "avr"
    acceleration_steps_s2: float | None = None
    max_rate_hz: float | None = None
    step_chance_s: float | None = None
    speed_doubt: float = 1.5
    watchdog_s: float = 0.0
    resets_on_open: bool = False
    boot_s: float = 2.0
    answer_margin_s: float = 0.25
    counts_check: bool = False

    def __post_init__(self) -> None:
        if self.board not in BOARDS:
            raise ArmFileError(f"robko01.board is one of {', '.join(BOARDS)}, not {self.board!r}")
        for name, (low, high) in _BOUNDS.items():
            value = getattr(self, name)
            if value is not None:
                within(f"robko01.{name}", value, low, high)

    @property
    def known(self) -> Board:
        """The board's numbers, as the file has them or else the table."""
        taken = BOARDS[self.board]
        given = {name: getattr(self, name) for name in _OF_BOARD}
        return replace(taken, **{key: each for key, each in given.items() if each is not None})


_OF_BOARD = ("acceleration_steps_s2", "max_rate_hz", "step_chance_s")
_BOUNDS = {
    "acceleration_steps_s2": (10.0, 100_000.0),
    "max_rate_hz": (1.0, 5_000.0),
    "step_chance_s": (0.0, 0.1),
    "speed_doubt": (1.0, 20.0),
    "watchdog_s": (0.0, 3600.0),
    "boot_s": (0.0, 30.0),
    "answer_margin_s": (0.03, 10.0),
}
