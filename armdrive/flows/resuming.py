"""Taking an arm up again over a wire that was lost: believes little, and moves nothing.

It ends in error-stop, or disabled where the arm was disabled before. An error that was latched
stays latched. The position is at best restored: while nobody could see it, the arm may have been
moved by hand.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.controllers.requests import Registers
from armdrive.flow import Flow, Until
from armdrive.flows.comparing import compare_settings
from armdrive.remarks import RECONNECTED
from armdrive.states import Event
from armdrive.status import Current, State, Trust
from armdrive.trust import Evidence

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.flows.exchange import Wire

MEANWHILE = ". Meanwhile "
BACK = "the wire was lost and is back{elsewhere}: look at the arm, then call `reset()`"


def resume(wire: Wire, lost_s: float, lost_link: str) -> Flow[None]:
    """Find the controller behind a wire that was lost at a time. Moves nothing.

    `lost_link` describes that wire: it is said where the new one is another.
    """
    core = wire.core
    stands_s = lost_s + core.stop_bound().silent_time_s
    while wire.now_s < stands_s and not wire.stopping:  # what was sent before runs on for so long
        yield Until(stands_s)
    registers = yield from wire.ask_registers()
    core.cut_off_s = 0.0
    was = core.before_loss
    if was is not State.DISABLED or core.current is not Current.OFF:
        core.current = Current.UNKNOWN
    _weigh(core, registers, wire.now_s)
    core.outputs = None
    core.happen(Event.OPENED_SWITCHED if was is State.DISABLED else Event.OPENED_HELD)
    core.notice = ""
    yield from compare_settings(wire)
    link = wire.engine.link.description
    _latch(core, was, BACK.format(elsewhere="" if link == lost_link else f", now {link}"))
    core.mark_still()
    core.still_since_s = wire.now_s


def _weigh(core: Core, registers: Registers, now_s: float) -> None:
    """Compare the registers with what was known when the wire was lost."""
    if core.belief.trust is Trust.UNKNOWN:
        core.found(registers)
        return
    core.sense(registers)
    same = core.restore(core.present_record(), registers.positions)
    if not same:
        core.learn(Evidence.RECORD_DIFFERS, now_s)
    else:
        core.learn(Evidence.LINK_BACK, now_s)


def _latch(core: Core, was: State, back: str) -> None:
    earlier, code = core.latched
    if earlier and code != RECONNECTED:
        earlier = earlier.partition(MEANWHILE)[0]  # of a wire that is lost often, the last time
        core.fault(f"{earlier}{MEANWHILE}{back}", code)
    elif was is State.DISABLED:
        core.error = ""
    else:
        core.fault(back, RECONNECTED)
