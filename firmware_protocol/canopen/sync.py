"""SYNC: the beat by which devices take over what PDOs brought them, and answer with theirs."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.canopen.cob import Service, cob_id, opened, sized
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import Frame

COUNTER_MAX = 240
"""Where the counter of SYNC begins anew at 1, at the latest (object 1019)."""


@dataclass(frozen=True, slots=True)
class Sync:
    """One beat; with a counter where object 1019 asks for one."""

    counter: int | None = None

    def __post_init__(self) -> None:
        if self.counter is not None:
            whole("counter", self.counter, 1, COUNTER_MAX)

    @property
    def frame(self) -> Frame:
        """The frame of it."""
        return Frame(cob_id(Service.SYNC), b"" if self.counter is None else bytes((self.counter,)))

    def after(self, overflow: int = COUNTER_MAX) -> Sync:
        """Return the next beat; a counter begins anew at 1 behind `overflow`, 2 to 240."""
        if self.counter is None:
            return self
        return Sync(self.counter % whole("overflow", overflow, 2, COUNTER_MAX) + 1)

    @classmethod
    def read(cls, frame: Frame) -> Sync:
        """Read a frame; raises `RemoteProtocolError`."""
        opened(frame, Service.SYNC)
        data = sized(frame, 0, 1)
        try:
            return cls(data[0] if data else None)
        except BadField as error:  # of what came, not of what we chose
            raise RemoteProtocolError(f"SYNC: {error}") from None
