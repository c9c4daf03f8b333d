"""What a codec registers to be fuzzed: one case for each of its two ends."""

import functools
import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

DRAWN = 100
"""The number of good frames of a case: the damage makes each a new one."""


class Machine(Protocol):
    """Either end of a codec, as far as bytes coming in are concerned."""

    def receive_data(self, data: bytes) -> None: ...

    def next_event(self) -> object | None: ...


@dataclass(frozen=True, slots=True)
class FuzzCase:
    """One end of a codec: how to build it, what its peer sends, how to see that it understood.

    `frames` draws the bytes of one valid frame as the peer would send it; `sign_of_good` fetches
    every waiting event and tells whether one of them was a valid frame. After bad bytes, one of
    `most_good` good frames is heard, where a codec promises so much.
    """

    name: str
    make: Callable[[], Any]
    frames: st.SearchStrategy[bytes]
    sign_of_good: Callable[[Any], bool]
    most_good: float = math.inf

    def good(self, rng: random.Random) -> bytes:
        """Return one of the frames that the peer may send."""
        return rng.choice(_drawn(self.frames))


@functools.cache
def _drawn(frames: st.SearchStrategy[bytes]) -> list[bytes]:
    """Draw frames once: to draw one takes a thousand times as long as to pick one of them."""
    found: list[bytes] = []

    @settings(
        max_examples=DRAWN,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(frames)
    def draw(frame: bytes) -> None:
        found.append(frame)

    draw()
    return found
