"""One request, and what each answer to it means for the arm."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.controllers.requests import (
    Denied,
    Interrupted,
    MoveBy,
    ReadPosition,
    Registers,
    Reply,
    Request,
)
from armdrive.core import Coordinates, Core
from armdrive.engine import Ask, Flow
from armdrive.errors import DeviceFault, LinkLost, NoAnswer, PendantStop, PositionMismatch
from armdrive.trust import Evidence

if TYPE_CHECKING:
    from armdrive.engine import Engine
    from kinematics import Motors


class Wire:
    """What a flow needs of the engine: the time, and whether somebody asked for a stop."""

    def __init__(self, engine: Engine, core: Core) -> None:
        self.engine = engine
        self.core = core

    @property
    def now_s(self) -> float:
        """The arm's time."""
        return self.engine.now_s

    @property
    def stopping(self) -> bool:
        """Whether a stop has been asked for."""
        return self.engine.stop_asked

    def request(self, request: Request) -> Flow[Reply]:
        """Send one request and return its reply; a refusal or silence is a fault of the arm."""
        try:
            reply: Reply = yield Ask(request)
        except NoAnswer as silence:
            self.core.learn(Evidence.ANSWER_LOST, self.now_s)
            self.core.fault(str(silence))
            raise
        return reply

    def read(self) -> Flow[Motors]:
        """Read the registers; return how far they are from the acknowledged position."""
        reply = yield from self.request(ReadPosition())
        if isinstance(reply, Registers):
            return self.core.compare(reply)
        raise self._fault(
            DeviceFault("the controller did not tell its position: look at the arm, then reset")
        )

    def move(self, target: Motors, rate_hz: float, there: Coordinates | None) -> Flow[None]:
        """Send one burst to an absolute target and wait until it has ended."""
        core = self.core
        steps = target - core.acknowledged
        if not steps.largest:
            core.coordinates = there or core.coordinates
            return
        core.mark_leaving()
        core.goes_to(target)
        try:
            reply = yield from self.request(MoveBy(steps, rate_hz))
        except LinkLost:
            core.learn(Evidence.LOST_IN_MOTION, self.now_s)
            raise
        if isinstance(reply, Interrupted):
            yield from self._pendant_stop()
        elif isinstance(reply, Denied):
            yield from self._refusal()
        core.arrived(there)

    def verify(self) -> Flow[None]:
        """Compare the registers with what was acknowledged; a difference is a fault."""
        difference = yield from self.read()
        if not difference.largest:
            return
        self.core.believe_registers()
        self.core.learn(Evidence.READ_BACK_DIFFERS, self.now_s, f"by {tuple(difference)} steps")
        raise self._fault(
            PositionMismatch(
                f"the registers differ by {tuple(difference)} steps from where the motion should "
                "have ended: a byte was lost, or the controller lost its power. Look at the arm, "
                "reset, then home"
            )
        )

    def _pendant_stop(self) -> Flow[None]:
        """Find out how far an interrupted burst came: the registers counted it."""
        difference = yield from self.read()
        core = self.core
        way = core.commanded - core.acknowledged
        if not _on_the_way(difference, way):
            core.learn(Evidence.READ_BACK_DIFFERS, self.now_s)
        core.believe_registers()
        raise self._fault(
            PendantStop("the STOP key of the pendant was pressed: look at the arm, then reset")
        )

    def _refusal(self) -> Flow[None]:
        yield from self.read()
        self.core.believe_registers()
        self.core.learn(Evidence.MOTION_REFUSED, self.now_s)
        raise self._fault(
            DeviceFault(
                "the controller refused a motion that it should have understood; a byte may have "
                "been garbled. Look at the arm, then reset"
            )
        )

    def _fault(self, error: DeviceFault | PendantStop) -> DeviceFault | PendantStop:
        self.core.fault(str(error))
        return error


def _on_the_way(came: Motors, way: Motors) -> bool:
    """Tell whether every motor stands between where it started and where it was sent."""
    return all(min(0, end) <= steps <= max(0, end) for steps, end in zip(came, way, strict=True))
