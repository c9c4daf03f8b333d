"""The frames of a bus whose adapter another program of the same user has, as that program tells."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from armdrive.errors import ArmError

if TYPE_CHECKING:
    from firmware_protocol.frames import Frame

EVERY_S = 0.05
"""The holder looks so often at what has passed."""


def holder_of(arm: str, port: str) -> str:
    """Return the name under which a program holds an arm, or the port; empty where none does.

    A port is known to its holder as the arm file writes it.
    """
    from armdrive.storage.lock_client import notice_of

    return next((name for name in (arm, port) if name and notice_of(name) is not None), "")


def held_frames(
    name: str, seconds: float | None, missed: Callable[[int], None]
) -> Iterator[tuple[float, Frame]]:
    """Yield what the holder of an arm says and hears, with the time since this began.

    Ends with the time, or when the arm is given back. `missed` is told how many exchanges were
    passed over, as a reader that is too slow has to. Raises `ArmError` where nobody tells.
    """
    from armdrive.storage.lock_client import overhear_holder
    from firmware_protocol.frames import Unpacker

    sides = {"sent": Unpacker(), "heard": Unpacker()}
    end_s = time.monotonic() + (math.inf if seconds is None else seconds)
    began_s: float | None = None
    for told in overhear_holder(name, EVERY_S):
        if "error" in told:
            raise ArmError(str(told["error"]))
        if told.get("missed"):
            missed(int(told["missed"]))
            sides = {side: Unpacker() for side in sides}  # the other half of a frame may have gone
        for time_s, side, data in told.get("wire", ()):
            began_s = time_s if began_s is None else began_s
            for frame in sides[side].feed(bytes.fromhex(data)):
                yield time_s - began_s, frame
        if time.monotonic() >= end_s:
            return
