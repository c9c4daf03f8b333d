"""A keyboard, a finger, and the link between them and a program: when each key event arrives.

A key that is held repeats after a delay, at the rate of the keyboard, until the finger lifts. The
link brings the events in their order, each up to `JITTER_S` late; one that stalls keeps back what
it is given meanwhile and delivers it at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

RATES_HZ = (11, 25, 33)
JITTER_S = 0.06
DELAY_S = (0.25, 0.5)
HELD_S = (1.0, 2.0)
STALL_S = 1.0
TOGETHER_S = 0.0002
"""How far apart events are that come in one piece."""


@dataclass(frozen=True, slots=True)
class Press:
    """One press: when its events arrive and when the finger lifts, in s from the first touch."""

    arrivals_s: tuple[float, ...]
    lifted_s: float


def press(chance: Random, rate_hz: float, *, stalls: bool = False) -> Press:
    """Hold a key for a while, on a link that stalls at some moment of it, or does not."""
    lifted_s = chance.uniform(*HELD_S)
    sent = tuple(_sent(chance.uniform(*DELAY_S), rate_hz, lifted_s))
    stall_s = chance.uniform(DELAY_S[1], lifted_s) if stalls else lifted_s + 2.0 * STALL_S
    arrivals: list[float] = []
    for sent_s in sent:
        due_s = sent_s + chance.uniform(0.0, JITTER_S)
        if stall_s <= due_s < stall_s + STALL_S:
            due_s = stall_s + STALL_S
        arrivals.append(max(due_s, arrivals[-1] + TOGETHER_S if arrivals else 0.0))
    return Press(tuple(arrivals), lifted_s)


def _sent(delay_s: float, rate_hz: float, lifted_s: float) -> Iterator[float]:
    yield 0.0
    sent_s = delay_s
    while sent_s < lifted_s:
        yield sent_s
        sent_s += 1.0 / rate_hz
