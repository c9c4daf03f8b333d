"""Idle work: poll an arm at rest, save its position, set outputs, and recover a lost link."""

from __future__ import annotations

import math
from typing import Any

from armdrive.abilities import OUTPUTS
from armdrive.errors import BadRequest, DeviceFault
from armdrive.motion.context import MotionContext
from armdrive.motion.device import compare_settings
from armdrive.motion.reference import poll
from armdrive.runtime.arm_state import RECONNECTED, Core
from armdrive.runtime.states import Event
from armdrive.status import Current, Evidence, State, Trust
from armdrive.tasks import Done, Registers, SetOutputs, SleepUntil, TaskBody

MOST_OUTPUTS = (1 << OUTPUTS) - 1

INPUTS_POLL_S = 0.05  # poll interval while a call waits for an input

STILL_S = 2.0
"""After this long at rest, remove the motion mark. Short stops do not write to the disk twice."""


class Idling:
    """Tells the engine what to do while no task is running."""

    def __init__(self, wire: MotionContext) -> None:
        self._wire = wire
        self._polled_s = 0.0

    def due(self, now_s: float) -> tuple[float, TaskBody[Any] | None]:
        """Return when to call again, and a task to run now, if any."""
        core = self._wire.core
        if core.state is State.STOPPING:  # no task is running, so the arm is at rest
            core.settle()
        if core.state not in (State.STANDBY, State.HOMING):
            return math.inf, None
        core.report_write_errors()
        if core.memory.owing and now_s >= core.still_since_s + STILL_S:
            core.mark_still()
            core.still_since_s = now_s  # if writing fails, try again later
        mark_s = core.still_since_s + STILL_S if core.memory.owing else math.inf
        every_s = core.config.motion.idle_poll_s
        if core.readings.awaiting:
            every_s = min(every_s or INPUTS_POLL_S, INPUTS_POLL_S)
        if every_s == 0.0:
            return mark_s, None
        poll_s = max(self._polled_s, core.still_since_s) + every_s
        if now_s < poll_s:
            return min(poll_s, mark_s), None
        self._polled_s = now_s
        return now_s + every_s, poll(self._wire)


def set_outputs(wire: MotionContext, bits: int) -> TaskBody[None]:
    """Write the output bits."""
    if isinstance(bits, bool) or not isinstance(bits, int) or not 0 <= bits <= MOST_OUTPUTS:
        raise BadRequest(f"outputs are a whole number from 0 to {MOST_OUTPUTS}, not {bits!r}")
    reply = yield from wire.request(SetOutputs(bits))
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller did not take the output bits {bits}: look at the arm")
    wire.core.readings.outputs = bits


# Recovering a lost link. Moves nothing, and trusts little.
#
# The arm ends in error-stop, or disabled if it was disabled before. A latched error stays latched.
# The position is restored at best, because the arm may have been moved by hand meanwhile.

MEANWHILE = ". Meanwhile "
BACK = "the connection was lost and is back{elsewhere}: look at the arm, then call `reset()`"


def resume(wire: MotionContext, lost_s: float, lost_link: str) -> TaskBody[None]:
    """Find the controller on a new link after the loss of the old one. Moves nothing.

    `lost_link` describes the old link; the error names the new one if it differs.
    """
    core = wire.core
    stands_s = lost_s + core.stop_bound().silent_time_s
    while wire.now_s < stands_s and not wire.stopping:  # the device finishes what it was sent
        yield SleepUntil(stands_s)
    registers = yield from wire.ask_registers()
    core.stops.cut_off_s = 0.0
    was = core.before_loss
    if was is not State.DISABLED or core.readings.current is not Current.OFF:
        core.readings.current = Current.UNKNOWN
    _weigh(core, registers, wire.now_s)
    core.readings.outputs = None
    core.happen(Event.OPENED_SWITCHED if was is State.DISABLED else Event.OPENED_HELD)
    core.diagnostics.notice = ""
    yield from compare_settings(wire)
    link = wire.engine.link.description
    _latch(core, was, BACK.format(elsewhere="" if link == lost_link else f", now {link}"))
    core.mark_still()
    core.still_since_s = wire.now_s


def _weigh(core: Core, registers: Registers, now_s: float) -> None:
    """Compare the registers with the position at the loss of the link."""
    if core.belief.trust is Trust.UNKNOWN:
        core.position.found(registers)
        return
    core.readings.sense(registers)
    same = core.position.restore(core.record(in_motion=False), registers.positions)
    if not same:
        core.learn(Evidence.RECORD_DIFFERS, now_s)
    else:
        core.learn(Evidence.LINK_BACK, now_s)


def _latch(core: Core, was: State, back: str) -> None:
    earlier, code = core.latched
    if earlier and code != RECONNECTED:
        earlier = earlier.partition(MEANWHILE)[0]  # of repeated losses, report only the latest
        core.fault(f"{earlier}{MEANWHILE}{back}", code)
    elif was is State.DISABLED:
        core.diagnostics.error = ""
    else:
        core.fault(back, RECONNECTED)
