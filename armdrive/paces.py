"""What `pace=` of a connection may be, and the pace that each of them is."""

from __future__ import annotations

from armdrive.clock import SimulatedClock
from armdrive.errors import BadRequest
from armdrive.pace import Pace, RealPace, SimulatedPace
from armdrive.strands import present

PaceChoice = str | float | SimulatedClock | SimulatedPace | None
"""What `pace` may be: "simulated", "real", a factor of real time, a clock, or another arm's pace.

Without any, simulated time of the arm's own; in a coroutine, that of its event loop.
"""


def pace_of(choice: PaceChoice) -> Pace:
    """Return the pace of a simulated arm. Raises `BadRequest`."""
    if isinstance(choice, SimulatedClock):
        return SimulatedPace(choice)
    if choice is None:
        strand = present()
        return SimulatedPace(None if strand is None else strand.clock)
    if isinstance(choice, SimulatedPace):
        return SimulatedPace(choice.clock)
    if choice == "simulated":
        return SimulatedPace()
    if choice == "real":
        return RealPace()
    if isinstance(choice, int | float) and choice > 0:
        return RealPace(speed=float(choice))
    raise BadRequest(
        f'pace is "simulated", "real", a factor of real time or a SimulatedClock, not {choice!r}'
    )
