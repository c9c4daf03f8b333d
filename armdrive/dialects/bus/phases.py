"""Lead the drives of one arm through a motion: one table of phases and signals for every dialect.

A motion is in one phase at a time. The phase's stage sends the frames that are due and reports a
signal when something has changed. The table gives the next phase and the action on the way there.
A signal that the table does not list for a phase changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias, TypeVar

from armdrive.dialects.exchange import ScriptIO
from armdrive.tasks import never

H = TypeVar("H")


class Phase(Enum):
    """What all drives of the arm are doing."""

    MOVING = "moving"
    """The drives receive one target after the other."""
    OUTAGE = "bus outage"
    """No drive replies, or drives may have missed this program's heartbeat and stopped: none gets a
    further target, and each ends at its last one. Late replies are read first, then the position or
    state of every drive. If the arm is paused meanwhile, this lasts until it resumes (MKS)."""
    ARRIVING = "arriving"
    """The drives have their final targets and complete the rest."""
    STOPPING = "stopping"
    """The stop is repeated until every drive is seen to brake."""
    HOMING = "homing"
    """The drives search for their switches by themselves."""
    ENDED = "ended"


class Signal(Enum):
    """What has changed in a phase."""

    STOP = "a stop was requested, or a jog was released"
    OUTAGE = "no drive has replied for a while, one replies again, or a heartbeat may be missing"
    TROUBLE = "a drive does not follow its orders, or does not reply"
    REJECTED = "a drive reports that it rejects an order"
    ALL_SENT = "the final targets have been sent"
    LOCATED = "every drive's position and speed are known, or its state can be read"
    SHORT = "a drive stands short of its target: its order may have been lost"
    OUT_OF_RANGE = "a target cannot be expressed"
    ARRIVED = "all drives stand at their targets"
    STOPPED = "all drives stand"
    NOT_STOPPED = "some drives do not come to rest, or do not reply"


class Act(Enum):
    """The action between one phase and the next."""

    NOTHING = "nothing"
    STOP = "send the stop"
    STOP_HARD = "send the stop, without a ramp"
    EXPLAIN = "send the stop, and ask a drive that replies what is wrong"
    REPEAT = "send the order again"
    RESUME = "continue from where the drives are, leaving nothing out"
    HOLD = "have each drive hold where it stands, and find out what is still unknown"


TABLE: Mapping[tuple[Phase, Signal], tuple[Phase, Act]] = MappingProxyType(
    {
        (Phase.MOVING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.MOVING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.MOVING, Signal.REJECTED): (Phase.MOVING, Act.REPEAT),
        (Phase.MOVING, Signal.OUT_OF_RANGE): (Phase.STOPPING, Act.STOP),
        (Phase.MOVING, Signal.OUTAGE): (Phase.OUTAGE, Act.NOTHING),
        (Phase.MOVING, Signal.ALL_SENT): (Phase.ARRIVING, Act.NOTHING),
        (Phase.OUTAGE, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.OUTAGE, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.OUTAGE, Signal.LOCATED): (Phase.MOVING, Act.RESUME),
        (Phase.OUTAGE, Signal.ALL_SENT): (Phase.ARRIVING, Act.NOTHING),
        (Phase.ARRIVING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.ARRIVING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.ARRIVING, Signal.REJECTED): (Phase.ARRIVING, Act.REPEAT),
        (Phase.ARRIVING, Signal.SHORT): (Phase.ARRIVING, Act.REPEAT),
        (Phase.ARRIVING, Signal.OUTAGE): (Phase.OUTAGE, Act.NOTHING),
        (Phase.ARRIVING, Signal.ARRIVED): (Phase.ENDED, Act.NOTHING),
        (Phase.STOPPING, Signal.STOPPED): (Phase.ENDED, Act.HOLD),
        (Phase.STOPPING, Signal.NOT_STOPPED): (Phase.ENDED, Act.HOLD),
        (Phase.HOMING, Signal.STOP): (Phase.STOPPING, Act.STOP_HARD),
        (Phase.HOMING, Signal.TROUBLE): (Phase.STOPPING, Act.STOP_HARD),
        (Phase.HOMING, Signal.ARRIVED): (Phase.ENDED, Act.NOTHING),
    }
)
"""The next phase and the action for each signal, phase by phase."""


class Stage(Protocol):
    """What a dialect does in one phase. It need not watch for stops: `run_phases` does."""

    def step(self, now_s: float) -> float:
        """Send the frames that are due; return when to call again if no reply comes first."""

    def signal(self, now_s: float) -> Signal | None:
        """Return what has changed; None while the phase goes on."""


Stages: TypeAlias = Mapping[Phase, Callable[[], Stage]]
Acts: TypeAlias = Mapping[Act, Callable[[], Generator[float, Any, None] | None]]
"""What each action does; an action that takes time is a script."""


def run_phases(
    io: ScriptIO[H],
    phase: Phase,
    stages: Stages,
    acts: Acts,
    released: Callable[[], bool] = never,
) -> Generator[float, H | None, None]:
    """Lead the drives from a phase through all that follow, until the motion has ended.

    A stop goes first, in every phase: before the stage is asked what else has changed. `released`
    tells whether the motion is a jog that was released, which is a stop too.
    """
    stage = stages[phase]()
    while phase is not Phase.ENDED:
        row = TABLE.get((phase, Signal.STOP)) if io.stop_asked or released() else None
        if row is None and (signal := stage.signal(io.now_s)) is not None:
            row = TABLE.get((phase, signal))
        if row is None:
            event = yield stage.step(io.now_s)
            while event is not None:  # read everything that has arrived before judging
                io.on_unsolicited(event)
                event = yield io.now_s
            continue
        following, act = row
        script = None if act is Act.NOTHING else acts[act]()
        if script is not None:
            yield from script
        if following not in (phase, Phase.ENDED):
            stage = stages[following]()
        phase = following
