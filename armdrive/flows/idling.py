"""What is done while nobody asks for anything: look at the arm now and then, and remember it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from armdrive.controllers.requests import Done, SetOutputs
from armdrive.errors import BadRequest, DeviceFault
from armdrive.flow import Flow
from armdrive.flows.referencing import poll
from armdrive.lines import OUTPUTS
from armdrive.status import State

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire

MOST_OUTPUTS = (1 << OUTPUTS) - 1

INPUTS_POLL_S = 0.05
"""While somebody waits for an input, a standing arm is looked at so often."""

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
        if core.state is State.STOPPING:  # nothing is at work: the arm stands
            core.settle()
        if core.state not in (State.STANDBY, State.HOMING):
            return math.inf, None
        core.hear_memory()
        if core.memory.owing and now_s >= core.still_since_s + STILL_S:
            core.mark_still()
            core.still_since_s = now_s  # where it could not be written, try again later
        mark_s = core.still_since_s + STILL_S if core.memory.owing else math.inf
        every_s = core.config.motion.idle_poll_s
        if core.awaiting:
            every_s = min(every_s or INPUTS_POLL_S, INPUTS_POLL_S)
        if every_s == 0.0:
            return mark_s, None
        poll_s = max(self._polled_s, core.still_since_s) + every_s
        if now_s < poll_s:
            return min(poll_s, mark_s), None
        self._polled_s = now_s
        return now_s + every_s, poll(self._wire)


def set_outputs(wire: Wire, bits: int) -> Flow[None]:
    """Write the output bits."""
    if isinstance(bits, bool) or not isinstance(bits, int) or not 0 <= bits <= MOST_OUTPUTS:
        raise BadRequest(f"outputs are a whole number from 0 to {MOST_OUTPUTS}, not {bits!r}")
    reply = yield from wire.request(SetOutputs(bits))
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller did not take the output bits {bits}: look at the arm")
    wire.core.outputs = bits
