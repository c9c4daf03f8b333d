"""How an arm gets its position: from a posture that somebody vouches for, or from the record.

A reference is the controller's registers plus an offset that is kept here. Nothing in this file
moves the arm, and nothing asks the controller to zero its registers, which would drop its
motor current.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.abilities import Switching
from armdrive.controllers.requests import DropCurrent, ReadPosition, Registers, Reply
from armdrive.core import Coordinates
from armdrive.engine import Ask, Flow, Until
from armdrive.errors import DeviceFault, NoAnswer, StateFileError
from armdrive.states import Event
from armdrive.status import Current, Trust
from armdrive.trust import Belief, Evidence
from kinematics import Motors

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire

QUIET_S = 0.3
"""A silence this long ends whatever a disturbed controller had still to say."""

TRIES = 3


def connect(wire: Wire) -> Flow[None]:
    """Find the controller, take up its record, and end in stand-still. Moves nothing."""
    core = wire.core
    registers = yield from _patient_read(wire)
    switched = core.controller.abilities.current is Switching.BOTH
    core.happen(Event.OPENED_SWITCHED if switched else Event.OPENED_HELD)
    _take_up_record(wire, registers)
    core.still_since_s = wire.now_s


def _take_up_record(wire: Wire, registers: Registers) -> None:
    core = wire.core
    core.inputs, core.gripping = registers.inputs, registers.gripping
    core.commanded = core.acknowledged = core.read_back = registers.positions
    core.believe_registers()
    try:
        record = core.recorder.load()
    except StateFileError as error:
        core.learn(Evidence.RECORD_UNUSABLE, wire.now_s, str(error))
        return
    if record is None:
        core.learn(Evidence.NO_RECORD, wire.now_s)
    elif record.calibration != core.config.calibration:
        core.learn(Evidence.RECORD_UNUSABLE, wire.now_s, "it was made with another calibration")
    elif len(record.offset) != len(registers.positions):
        core.learn(Evidence.RECORD_UNUSABLE, wire.now_s, "it is of an arm with other motors")
    elif record.trust == Trust.UNKNOWN.value:
        core.learn(Evidence.NO_RECORD, wire.now_s)
    else:
        same = core.restore(record, registers.positions)
        core.learn(Evidence.RECORD_MATCHES, wire.now_s)
        if record.trust == Trust.SUSPECT.value:
            core.belief = Belief(Trust.SUSPECT, record.reason, wire.now_s)
        if not same:
            core.learn(Evidence.RECORD_DIFFERS, wire.now_s)
        elif record.in_motion:
            core.learn(Evidence.ENDED_IN_MOTION, wire.now_s)


def _patient_read(wire: Wire) -> Flow[Registers]:
    """Read the registers, trying again where an earlier exchange has left its traces."""
    for attempt in range(TRIES):
        try:
            reply = yield from _plain_read()
        except NoAnswer:
            if attempt == TRIES - 1:
                raise
            continue
        if isinstance(reply, Registers):
            return reply
        yield Until(wire.now_s + QUIET_S)
    raise DeviceFault(
        f"whatever is on {wire.engine.link.description} does not answer as this arm does: check "
        "the port and the dialect"
    )


def _plain_read() -> Flow[Reply]:
    reply: Reply = yield Ask(ReadPosition())
    return reply


def begin_home(wire: Wire) -> Flow[None]:
    """Enter the state in which an operator brings the arm to its posture."""
    wire.core.happen(Event.HOME)
    yield from ()


def end_home(wire: Wire) -> Flow[None]:
    """Leave it again without a reference."""
    wire.core.settle()
    yield from ()


def take_reference(wire: Wire, there: Coordinates, evidence: Evidence) -> Flow[None]:
    """Let the present registers mean a posture that somebody vouches for."""
    core = wire.core
    yield from wire.read()
    registers = (core.read_back or core.acknowledged) - core.offset
    core.refer(registers, there)
    core.learn(evidence, wire.now_s)
    core.error = core.notice = ""
    core.settle()
    core.mark_still()


def confirm_record(wire: Wire) -> Flow[None]:
    """Let a restored position count as referenced: the operator compared it with the arm."""
    wire.core.learn(Evidence.CONFIRMED, wire.now_s)
    wire.core.mark_still()
    yield from ()


def disable(wire: Wire) -> Flow[None]:
    """Drop the motor current: the arm can sag, so its position is suspect from then on."""
    core = wire.core
    core.happen(Event.DISABLE)
    core.mark_leaving()
    yield from wire.request(DropCurrent())
    core.current = Current.OFF
    core.learn(Evidence.CURRENT_DROPPED, wire.now_s)
    reply = yield from wire.request(ReadPosition())
    if isinstance(reply, Registers):
        # the registers may have been zeroed: keep the position by moving the offset instead
        core.offset = core.acknowledged - reply.positions
        core.compare(reply)
    core.mark_still()


def enable(wire: Wire) -> Flow[None]:
    """Allow motion again. Moves nothing."""
    wire.core.happen(Event.ENABLE)
    yield from ()


def reset(wire: Wire) -> Flow[None]:
    """Leave error-stop: listen until the line is quiet, and take up what the registers say."""
    core = wire.core
    wire.engine.controller.forget()
    yield Until(wire.now_s + QUIET_S)
    reply = yield from _patient_read(wire)
    core.happen(Event.RESET)
    core.error = core.notice = ""
    weigh_difference(wire, core.compare(reply))
    core.still_since_s = wire.now_s


def poll(wire: Wire) -> Flow[None]:
    """Look at a standing arm: inputs, and whether its registers are still what they were."""
    difference = yield from wire.read()
    weigh_difference(wire, difference)


def weigh_difference(wire: Wire, difference: Motors) -> None:
    """Say what registers mean that changed while nothing was moved from here."""
    core = wire.core
    if not difference.largest:
        return
    registers = (core.read_back or core.acknowledged) - core.offset
    zeroed = not registers.largest
    core.learn(Evidence.CONTROLLER_RESTARTED if zeroed else Evidence.MOVED_BY_OTHERS, wire.now_s)
    if core.belief.trust is Trust.UNKNOWN or not zeroed:
        core.believe_registers()
    else:
        core.offset = core.acknowledged - registers
        core.read_back = core.acknowledged
    core.notice = core.belief.reason
