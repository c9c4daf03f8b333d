"""What the driver asks of any controller and what it hears back, in motor steps and seconds.

Requests and replies name no dialect. Registers are the controller's own counts; the driver adds
its reference offset (core.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from armdrive.abilities import Abilities
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class MoveBy:
    """Move all motors together; the busiest one at `rate_hz` steps a second or slower."""

    steps: Motors
    rate_hz: float


@dataclass(frozen=True, slots=True)
class ReadPosition:
    """Ask for the position registers and the inputs. Never moves anything."""


@dataclass(frozen=True, slots=True)
class SetOutputs:
    """Write the output bits. Never moves anything."""

    bits: int


@dataclass(frozen=True, slots=True)
class DropCurrent:
    """Switch the motor current off: the arm can sag. Sent by an explicit `disable` alone."""


Request = MoveBy | ReadPosition | SetOutputs | DropCurrent


@dataclass(frozen=True, slots=True)
class Done:
    """The request was carried out, and the motion has ended."""

    def __str__(self) -> str:
        return "done"


@dataclass(frozen=True, slots=True)
class Interrupted:
    """The operator's own stop (a pendant key) ended the motion part of the way."""

    def __str__(self) -> str:
        return "stopped at the pendant"


@dataclass(frozen=True, slots=True)
class Denied:
    """The controller understood nothing, or refused."""

    def __str__(self) -> str:
        return "refused"


@dataclass(frozen=True, slots=True)
class Registers:
    """The controller's position counts, in its own origin, and its input bits."""

    positions: Motors
    inputs: int
    gripping: bool
    key: str

    def __str__(self) -> str:
        pressed = f", key {self.key}" if self.key != NO_KEY else ""
        return f"registers {' '.join(map(str, self.positions))}, inputs {self.inputs}{pressed}"


NO_KEY = "NONE"
"""What `Registers.key` says while no key has been pressed."""


Reply = Done | Interrupted | Denied | Registers


@dataclass(frozen=True, slots=True)
class Sent:
    """A request on the wire: its bytes, how long its answer should take, and its text."""

    request: Request
    data: bytes
    motion_s: float
    wire_s: float
    patience_s: float
    text: str


@dataclass(frozen=True, slots=True)
class Oddity:
    """Something on the wire that answers nothing: garbage, a line nobody asked for."""

    text: str


class Controller(Protocol):
    """The driver's end of one dialect. Sans-IO: the engine carries its bytes."""

    @property
    def abilities(self) -> Abilities:
        """What the device can do."""

    def encode(self, request: Request) -> Sent:
        """Turn a request into bytes; raises while an earlier one is unanswered."""

    def receive(self, data: bytes) -> None:
        """Take bytes from the device."""

    def next_event(self) -> Reply | Oddity | None:
        """Return the next thing heard, or None when more bytes are needed."""

    def answered(self, sent: Sent, elapsed_s: float) -> bool:
        """Learn from the time that an answer took; False where that time is hard to believe.

        An answer far too early may belong to another request; one far too late may be that of
        another motion than the one meant. Either way the registers are to be looked at.
        """

    def forget(self) -> None:
        """Give up on the unanswered request and on half a line that was received."""

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate that the device really offers, at or below the one wanted."""

    def doubt(self, rate_hz: float) -> float:
        """Return by what factor the device may be slower than that rate: measured, or assumed."""

    def stop_overhead_s(self) -> float:
        """Return the wire's share of the worst-case stop: a burst's line and its answer."""

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the registers' wrap-around, for a position near the given one."""
