"""Taking a reference from somebody who looks at the arm, unless it has changed since he looked.

A reference is the controller's registers plus an offset that is kept here. Nothing in this file
moves the arm, and nothing asks the controller to zero its registers, which would drop its motor
current.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.errors import DeviceFault
from armdrive.flow import Flow
from armdrive.flows.asking import weigh_difference
from armdrive.flows.remembering import be_remembered
from armdrive.status import State, Trust
from armdrive.trust import Belief, Evidence

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.flows.exchange import Wire
    from armdrive.whereabouts import Coordinates
    from kinematics import Motors

PROMPT_S = 0.3
"""Registers that are read this soon show the arm as it was vouched for."""


@dataclass(frozen=True, slots=True)
class Vouched:
    """A posture that somebody vouches for, and what was known of the arm when he did."""

    there: Coordinates
    evidence: Evidence
    belief: Belief
    registers: Motors
    at_s: float


def vouched(core: Core, there: Coordinates, evidence: Evidence, now_s: float) -> Vouched:
    """Note that somebody vouches for a posture now."""
    return Vouched(there, evidence, core.belief, core.expected, now_s)


def take_reference(wire: Wire, word: Vouched) -> Flow[None]:
    """Let the present registers mean a posture that somebody vouches for.

    Raises `DeviceFault` where the arm may have changed since: there is worse news of it, or the
    registers have fallen to zero (the controller was restarted, and the arm may have sagged), or
    they have changed and could not be read at once. Registers that were read at once may have
    changed before he looked: somebody has just brought the arm there.
    """
    core = wire.core
    difference = yield from wire.read()
    if wire.stopping or core.state not in (State.STANDBY, State.HOMING):
        raise wire.stopped("a stop came between: nothing was referenced")
    registers = core.counts
    changed = registers != word.registers
    late = wire.now_s > word.at_s + PROMPT_S
    doubted = core.belief is not word.belief and core.belief.trust is Trust.SUSPECT
    if doubted or (changed and (late or not registers.largest)):
        weigh_difference(wire, difference)
        why = core.belief.reason if doubted or not registers.largest else _MOVED
        raise DeviceFault(
            f"nothing was referenced, because of what was seen a moment ago: {why}. Look at the "
            "arm, and vouch for its posture again"
        )
    core.refer(registers, word.there)
    core.learn(word.evidence, wire.now_s)
    core.clear_remarks()
    core.settle()
    core.mark_still()
    yield from be_remembered(wire)


_MOVED = "the wire was disturbed, and the registers have changed meanwhile"
