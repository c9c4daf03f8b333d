"""What both ends of the SUPER protocol do with bytes that come in: a stream, or datagrams."""

from __future__ import annotations

from firmware_protocol.robko01.frames import FrameSplitter


class Receiving:
    """An end that takes bytes, and finds frames in them."""

    def __init__(self, *, counts_check: bool) -> None:
        self._counts_check = counts_check
        self._frames = FrameSplitter(counts_check=counts_check)

    @property
    def buffered(self) -> int:
        """How many received bytes are held."""
        return self._frames.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the other end, in any portions."""
        self._frames.feed(data)

    def receive_datagram(self, data: bytes) -> None:
        """Take a datagram from the other end: no frame reaches from one into the next."""
        self._frames.silence()
        self._frames.feed(data)
        self._frames.silence()

    def silence(self) -> None:
        """Say that nothing has come for longer than a frame pauses.

        A frame that has begun is given up, and what it has swallowed is searched for others. A
        host calls it before `forget`; the firmware does nothing of the kind.
        """
        self._frames.silence()
