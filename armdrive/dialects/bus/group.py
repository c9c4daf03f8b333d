"""How the drives of one arm are led through a motion together, whatever they speak.

A motion is in one phase at a time. The stage of the phase says what is due on the bus, and reports
a signal for what has become of it. The table says which phase follows, and what is done on the way
there; a signal that it does not list for a phase changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias, TypeVar

from armdrive.dialects.exchange import ScriptIO
from armdrive.tasks import (
    ClearFault,
    DropCurrent,
    HomeDevice,
    MendSetting,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    SwitchOn,
)

H = TypeVar("H")
BUS_REQUESTS = (
    MoveBy,
    MoveAlong,
    HomeDevice,
    ReadPosition,
    ReadSettings,
    MendSetting,
    SwitchOn,
    DropCurrent,
    ClearFault,
)
"""What drives on a bus carry out."""


class Phase(Enum):
    """What the drives are doing together."""

    MOVING = "moving"
    """They are told where to go, again and again."""
    HELD_UP = "held up"
    """Nobody is heard: each ends where it was sent, and is sent no farther."""
    RETURNING = "returning"
    """Somebody is heard again: late answers are heard first, then it is looked where all are."""
    WAITING = "waiting"
    """The arm was paused while the bus was held up: they stand until it goes on."""
    ARRIVING = "arriving"
    """They were told their goals, and do what is left."""
    STOPPING = "stopping"
    """They were told to stop, and are told again until each has been heard to brake."""
    HOMING = "homing"
    """They search for their switches by themselves."""
    ENDED = "ended"


class Signal(Enum):
    """What has become of a phase."""

    STOP = "a stop was asked for, or a jog was let go of"
    HELD_UP = "nobody has answered for a while although somebody was asked"
    BACK = "somebody has answered again"
    HEARD = "those who owed an answer have said, unasked, that they are there"
    TROUBLE = "one drive does not do what it was told, or is not heard"
    DENIED = "a drive says that it does not take an order"
    SENT = "all has been sent"
    FOUND = "all drives have told where they are"
    PAUSED = "somebody has paused the arm"
    RESUMED = "nobody pauses the arm any more"
    SHORT = "a drive stands short of its goal: its order may have been lost"
    REFUSED = "a target cannot be given"
    THERE = "all stand where they were sent"
    STAND = "all stand"
    LOST = "some do not come to rest, or are not heard to"


class Act(Enum):
    """What is done between one phase and the next."""

    NOTHING = "nothing"
    STOP = "say the stop"
    STOP_DEAD = "say the stop, without a ramp"
    EXPLAIN = "say the stop, then find out what is wrong and say that"
    REPEAT = "say the order again"
    TAKE_UP = "go on from where the drives are, leaving nothing out"
    HOLD = "have each hold where it stands"


TABLE: Mapping[tuple[Phase, Signal], tuple[Phase, Act]] = MappingProxyType(
    {
        (Phase.MOVING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.MOVING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.MOVING, Signal.DENIED): (Phase.MOVING, Act.REPEAT),
        (Phase.MOVING, Signal.REFUSED): (Phase.STOPPING, Act.STOP),
        (Phase.MOVING, Signal.HELD_UP): (Phase.HELD_UP, Act.NOTHING),
        (Phase.MOVING, Signal.BACK): (Phase.RETURNING, Act.NOTHING),
        (Phase.MOVING, Signal.SENT): (Phase.ARRIVING, Act.NOTHING),
        (Phase.HELD_UP, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.HELD_UP, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.HELD_UP, Signal.BACK): (Phase.RETURNING, Act.NOTHING),
        (Phase.HELD_UP, Signal.HEARD): (Phase.MOVING, Act.NOTHING),
        (Phase.RETURNING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.RETURNING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.RETURNING, Signal.PAUSED): (Phase.WAITING, Act.NOTHING),
        (Phase.RETURNING, Signal.FOUND): (Phase.MOVING, Act.TAKE_UP),
        (Phase.RETURNING, Signal.SENT): (Phase.ARRIVING, Act.NOTHING),
        (Phase.WAITING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.WAITING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.WAITING, Signal.RESUMED): (Phase.MOVING, Act.TAKE_UP),
        (Phase.ARRIVING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.ARRIVING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.ARRIVING, Signal.DENIED): (Phase.ARRIVING, Act.REPEAT),
        (Phase.ARRIVING, Signal.SHORT): (Phase.ARRIVING, Act.REPEAT),
        (Phase.ARRIVING, Signal.BACK): (Phase.RETURNING, Act.NOTHING),
        (Phase.ARRIVING, Signal.THERE): (Phase.ENDED, Act.NOTHING),
        (Phase.STOPPING, Signal.STAND): (Phase.ENDED, Act.HOLD),
        (Phase.STOPPING, Signal.LOST): (Phase.ENDED, Act.HOLD),
        (Phase.HOMING, Signal.STOP): (Phase.STOPPING, Act.STOP_DEAD),
        (Phase.HOMING, Signal.TROUBLE): (Phase.STOPPING, Act.STOP_DEAD),
        (Phase.HOMING, Signal.THERE): (Phase.ENDED, Act.NOTHING),
    }
)
"""What happens on each signal, phase by phase."""


class Stage(Protocol):
    """What a dialect does in one phase."""

    def speak(self, now_s: float) -> float:
        """Say what is due; return when more is, if nothing is heard until then."""

    def signal(self, now_s: float) -> Signal | None:
        """Return what has become of the phase by now; None while it goes on."""


Stages: TypeAlias = Mapping[Phase, Callable[[], Stage]]
Acts: TypeAlias = Mapping[Act, Callable[[], Generator[float, Any, None] | None]]
"""What is done for an act; where that takes time, the script of it."""


def lead(
    io: ScriptIO[H], phase: Phase, stages: Stages, acts: Acts
) -> Generator[float, H | None, None]:
    """Carry drives from a phase through all that follow, to the end of their motion."""
    stage = stages[phase]()
    while phase is not Phase.ENDED:
        signal = stage.signal(io.now_s)
        row = None if signal is None else TABLE.get((phase, signal))
        if row is None:
            heard = yield stage.speak(io.now_s)
            while heard is not None:  # nothing is judged before all that has come was read
                io.on_unasked(heard)
                heard = yield io.now_s
            continue
        following, act = row
        doing = None if act is Act.NOTHING else acts[act]()
        if doing is not None:
            yield from doing
        if following not in (phase, Phase.ENDED):
            stage = stages[following]()
        phase = following
