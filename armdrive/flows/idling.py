"""What is done while nobody asks for anything: look at the arm now and then, and remember it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from armdrive.controllers.requests import Denied, SetOutputs
from armdrive.engine import Flow
from armdrive.errors import DeviceFault
from armdrive.flows.referencing import poll
from armdrive.status import State

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire

STILL_S = 2.0
"""An arm that has stood this long is recorded as standing."""


class Idling:
    """Tells the engine what is due in quiet times."""

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._polled_s = 0.0

    def due(self, now_s: float) -> tuple[float, Flow[Any] | None]:
        """Return when to ask again, and what to do now, if anything."""
        core = self._wire.core
        if core.state is not State.STANDBY:
            return math.inf, None
        if core.marked and now_s >= core.still_since_s + STILL_S:
            core.mark_still()
        mark_s = core.still_since_s + STILL_S if core.marked else math.inf
        every_s = core.config.motion.idle_poll_s
        if every_s == 0.0:
            return mark_s, None
        poll_s = max(self._polled_s, core.still_since_s) + every_s
        if now_s < poll_s:
            return min(poll_s, mark_s), None
        self._polled_s = now_s
        return now_s + every_s, poll(self._wire)


def set_outputs(wire: Wire, bits: int) -> Flow[None]:
    """Write the output bits."""
    reply = yield from wire.request(SetOutputs(bits))
    if isinstance(reply, Denied):
        raise DeviceFault(f"the controller refused the output bits {bits}")
    wire.core.outputs = bits
