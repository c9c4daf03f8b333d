"""Measuring an arm at its mark: nothing here moves it, its operator has brought it there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.flow import Flow
from armdrive.flows.remembering import be_remembered
from armdrive.status import State, Trust
from armdrive.trust import Evidence

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire
    from kinematics import Motors


def read_at_mark(wire: Wire) -> Flow[Motors]:
    """Return where the registers say that the motors are, while an operator is at work."""
    core = wire.core
    yield from wire.read()
    _require_homing(wire)
    return core.read_back or core.acknowledged


def believe_mark(wire: Wire) -> Flow[None]:
    """Take a restored position for confirmed: the mark has shown that it is right."""
    core = wire.core
    _require_homing(wire)
    if core.belief.trust is Trust.RESTORED:
        core.learn(Evidence.CONFIRMED, wire.now_s)
    core.settle()
    core.mark_still()
    yield from be_remembered(wire)


def doubt_position(wire: Wire, detail: str) -> Flow[None]:
    """Say that the position is off, where nobody wants to take the mark for the new reference."""
    core = wire.core
    _require_homing(wire)
    core.learn(Evidence.OFF_ITS_MARK, wire.now_s, detail)
    core.settle()
    core.mark_still()
    yield from be_remembered(wire)


def _require_homing(wire: Wire) -> None:
    if wire.stopping or wire.core.state is not State.HOMING:
        raise wire.stopped("a stop came between: nothing was changed")
