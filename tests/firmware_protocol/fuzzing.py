"""What a codec registers to be fuzzed: one case for each of its two ends."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol


class Machine(Protocol):
    """Either end of a codec, as far as bytes coming in are concerned."""

    def receive_data(self, data: bytes) -> None: ...

    def next_event(self) -> object | None: ...


@dataclass(frozen=True, slots=True)
class FuzzCase:
    """One end of a codec: how to build it, what its peer sends, how to see that it understood.

    `good` gives the bytes of one random valid frame as the peer would send it; `sign_of_good`
    fetches every waiting event and tells whether one of them was a valid frame. `most_held` bounds
    the bytes in its buffers; after bad bytes, one of `most_good` good frames is heard, where a
    codec promises so much.
    """

    name: str
    make: Callable[[], Any]
    good: Callable[[random.Random], bytes]
    sign_of_good: Callable[[Any], bool]
    most_held: int = 1 << 17
    most_good: float = math.inf
