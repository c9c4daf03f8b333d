"""A GRBL board without a driver: how long its motions take, and how soon it stops.

This works for boards with too few axes for an arm, and compares the simulated board with the real
one directly.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from tests.conformance.real_time_bench import RealTimeBench

from .grbl_setup import SOFT_RESET, Conversation
from .measuring import RATES_HZ, SPEEDS, STEADY_S, full_rate_hz
from .steps import Watcher

LENGTHS = (60, 600)
FAR = 5000
LONGEST_S = 60.0
FEED_HOLD, JOG_CANCEL = b"!", b"\x85"


@dataclass(frozen=True, slots=True)
class BoardMotion:
    """One motion or stop of the board's first axis.

    `took_s` is the time from the first step to the last, or from the stop command to the last step.
    """

    what: str
    rate_hz: float
    took_s: float
    pulses: int


def board_motions(
    bench: RealTimeBench, speeds: tuple[float, ...] = SPEEDS
) -> Iterator[BoardMotion]:
    """Time motions of one line each, from the first step to the last."""
    with Conversation(bench.device_port) as board:
        unlock(board)
        for steps in LENGTHS:
            for number, speed in enumerate(speeds):
                rate_hz = speed * full_rate_hz(bench)
                watcher = Watcher(bench)
                board.ask(f"G91G1F{rate_hz * 60.0:.1f}X{steps if number % 2 else -steps}")
                motion = watcher.until(_moved(bench), LONGEST_S)
                yield BoardMotion(f"{steps} steps", rate_hz, motion.physical_s, motion.pulses)


def board_stops(
    bench: RealTimeBench, rates_hz: tuple[float, ...] = RATES_HZ
) -> Iterator[BoardMotion]:
    """Time from a feed hold, and from a jog cancel, to the last step."""
    with Conversation(bench.device_port) as board:
        unlock(board)
        for what, line, end in (("!", "G91G1", FEED_HOLD), ("0x85", "$J=G91", JOG_CANCEL)):
            for number, rate_hz in enumerate(rates_hz):
                board.ask(f"{line}F{rate_hz * 60.0:.1f}X{FAR if number % 2 else -FAR}")
                bench.wait_until_moving()
                bench.sleep(STEADY_S)
                watcher = Watcher(bench)
                board.say(end)
                motion = watcher.until(lambda: True, LONGEST_S)
                yield BoardMotion(what, rate_hz, motion.last_s, motion.pulses)
                unlock(board)


def unlock(board: Conversation) -> None:
    """Reset the board and clear its alarm."""
    board.say(SOFT_RESET)
    board.heard_until("Grbl")
    board.ask("$X")


def _moved(bench: RealTimeBench) -> Callable[[], bool]:
    start = bench.look().motors
    return lambda: bench.look().motors != start
