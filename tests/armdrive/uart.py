"""What a serial receiver makes of bytes that were sent at another baud rate, bit by bit."""

from bisect import bisect_right
from dataclasses import dataclass

from hypothesis import strategies as st

DATA_BITS = 8


@dataclass(frozen=True)
class Receiver:
    """How a receiver samples. Real ones differ, so tests try all of them.

    `error` is how far the two clocks differ. `validates`: a start bit that is over by its middle
    is no start bit. `by_level`: after a missing stop bit the low line begins the next byte at
    once; without it, the next falling edge does.
    """

    baud: int
    error: float = 0.0
    validates: bool = True
    by_level: bool = False

    def hear(self, data: bytes, baud: int, gap_bits: float = 0.0) -> bytes:
        """Return the bytes, framing errors and all, out of bytes sent at `baud`."""
        line = _Line(data, 1.0 / baud, gap_bits)
        bit_s = (1.0 + self.error) / self.baud
        heard, now_s = bytearray(), 0.0
        while (start_s := line.falls_after(now_s)) is not None:
            while True:
                if self.validates and line.high(start_s + 0.5 * bit_s):
                    now_s = start_s + 0.5 * bit_s
                    break
                samples = [line.high(start_s + (1.5 + k) * bit_s) for k in range(DATA_BITS)]
                heard.append(sum(high << k for k, high in enumerate(samples)))
                now_s = start_s + 9.5 * bit_s
                if line.high(now_s) or not self.by_level:
                    break
                start_s = now_s
        return bytes(heard)


RECEIVERS = st.builds(
    Receiver,
    baud=st.just(0),
    error=st.floats(-0.035, 0.035),
    validates=st.booleans(),
    by_level=st.booleans(),
)


class _Line:
    """The levels of a line over time: high, and its changes."""

    def __init__(self, data: bytes, bit_s: float, gap_bits: float) -> None:
        self._changes: list[float] = []
        now_s, level = bit_s, True
        for byte in data:
            for bit in (False, *(bool(byte >> k & 1) for k in range(DATA_BITS)), True):
                if bit is not level:
                    self._changes.append(now_s)
                    level = bit
                now_s += bit_s
            now_s += gap_bits * bit_s

    def high(self, time_s: float) -> bool:
        return bisect_right(self._changes, time_s) % 2 == 0

    def falls_after(self, time_s: float) -> float | None:
        """Return when the line next falls; every second change is a fall."""
        at = bisect_right(self._changes, time_s)
        at += at % 2
        return self._changes[at] if at < len(self._changes) else None
