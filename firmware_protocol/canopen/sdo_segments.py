"""Data in segments, cut and put together: the part of a transfer that both sides have in common."""

from __future__ import annotations

from firmware_protocol.canopen.sdo_codes import AbortCode
from firmware_protocol.canopen.sdo_messages import SEGMENT_MAX, Segment

SIZE_MAX = 4096
"""Bytes of the longest object that is transferred, unless a machine is told otherwise."""


class Sending:
    """Data that leaves in segments, one after another."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0
        self.toggle = False

    @property
    def done(self) -> bool:
        """Whether the last segment was said to have arrived. No data at all is one segment too."""
        return self._at >= max(1, len(self._data))

    @property
    def segment(self) -> Segment:
        """The segment whose turn it is."""
        end = self._at + SEGMENT_MAX
        return Segment(self.toggle, self._data[self._at : end], end >= len(self._data))

    def advance(self) -> None:
        """Turn to the next segment."""
        self._at += SEGMENT_MAX
        self.toggle = not self.toggle


class Receiving:
    """Data that comes in segments. Held is never more than `size_max` bytes."""

    def __init__(self, size: int | None, size_max: int) -> None:
        self._size = size
        self._most = size_max if size is None else size
        self._too_much = AbortCode.OUT_OF_MEMORY if size is None else AbortCode.TOO_LONG
        self._data = bytearray()
        self.toggle = False

    @property
    def data(self) -> bytes:
        """What has come."""
        return bytes(self._data)

    def take(self, segment: Segment) -> AbortCode | None:
        """Add the segment whose turn it is; returns why the transfer cannot go on, if it cannot.

        What was announced and what comes must agree: a segment that came twice, or one that was
        lost, shows so where the toggle bit does not tell.
        """
        if len(self._data) + len(segment.data) > self._most:
            return self._too_much
        self._data += segment.data
        self.toggle = not self.toggle
        if segment.last and self._size not in (None, len(self._data)):
            return AbortCode.TOO_SHORT
        return None
