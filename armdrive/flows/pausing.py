"""Waiting in a pause: the arm stands, is looked at now and then, and goes on where it stopped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import DeviceFault, WrongState
from armdrive.flow import Flow, Until
from armdrive.status import State
from armdrive.tempo import LONGEST_PAUSE_S, given_up

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire

LOOK_S = 0.05
"""How often a paused motion asks whether it may go on."""
NOT_THERE = "the arm is no longer where it was paused ({}): the motion does not go on, plan anew"


def wait_out_pause(wire: Wire) -> Flow[None]:
    """Wait until somebody resumes the arm, or stops it; returns at once where nobody has paused.

    The arm is remembered as standing meanwhile. Raises where that takes too long, and where
    the arm is no longer as it was: a motion that goes on from elsewhere has never been audited.
    """
    tempo, core = wire.core.tempo, wire.core
    if not tempo.paused or wire.stopping:
        return
    yield from wire.verify()
    core.mark_still()
    stood, believed, poll_s = core.acknowledged, core.belief, core.config.motion.idle_poll_s
    began_s = looked_s = wire.now_s
    tempo.waits, tempo.given_up = True, False
    try:
        while tempo.paused and not wire.stopping:
            before_s = wire.now_s
            yield Until(before_s + LOOK_S)
            _require_no_fault(wire)
            waited_s = wire.now_s - began_s
            if tempo.given_up or waited_s >= LONGEST_PAUSE_S:
                raise given_up(waited_s)
            if poll_s and wire.now_s >= looked_s + poll_s:
                yield from wire.look()
                looked_s = wire.now_s
            tempo.note_waited(wire.now_s - before_s)
    finally:
        tempo.waits = False
    if wire.stopping:
        return
    yield from wire.look()  # however fresh the last one is: somebody may be about at the arm
    _require_no_fault(wire)
    if core.acknowledged != stood or core.belief is not believed:
        raise WrongState(NOT_THERE.format(core.belief.reason))


def _require_no_fault(wire: Wire) -> None:
    if wire.core.state is State.ERROR_STOP:
        raise DeviceFault(wire.core.error)
