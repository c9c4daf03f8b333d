"""The face of every simulated controller: what a wire, and what a person beside the arm, can ask.

A `WireDevice` is the least: bytes in, bytes out, on a clock that is handed to it. A `SimDevice` is
that together with the physical arm and what one can see and do there. What only some devices have
is a protocol of its own, asked for by `isinstance`; `lacks` is the sentence for the others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Protocol, runtime_checkable

from armdrive.errors import BadRequest
from armdrive.sim.saved import Json, Saved
from armdrive.sim.world import World
from kinematics.spaces import Joints, Motors


class WireDevice(Protocol):
    """The device side of a dialect, as its wire knows it."""

    @property
    def byte_gap_s(self) -> float:
        """How long the device pauses after each byte that it sends, beyond the baud rate's time."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that have arrived at the device by now."""

    def transmit(self, now_s: float) -> bytes:
        """Advance the arm to now and return the bytes that it has to say since the last call."""

    def next_s(self) -> float:
        """Tell when the device next does something by itself; infinity while it only waits."""


class SimDevice(WireDevice, Protocol):
    """A controller with its arm; `sim_base.SimBase` holds what all of them do alike."""

    @property
    def title(self) -> str:
        """What it is, for people: `TeachMover`, say."""

    @property
    def world(self) -> World:
        """The physical arm and what is around it."""

    @property
    def baud(self) -> int | None:
        """The pace of its line; None where bytes arrive at once, as from a network."""

    @property
    def powered(self) -> bool:
        """Whether it is switched on."""

    @property
    def now_s(self) -> float:
        """The device's present time."""

    @property
    def busy(self) -> bool:
        """Whether it is at work on something that the host has asked for."""

    @property
    def moving(self) -> bool:
        """Whether motors turn."""

    @property
    def registers(self) -> Motors:
        """The positions that it would tell its host: they know only what was commanded."""

    @property
    def inputs(self) -> int:
        """The input bits as the host would read them."""

    def details(self) -> dict[str, Json]:
        """Return what only this kind of device has to show."""

    def at(self, time_s: float, action: Callable[[], None]) -> None:
        """Have something done when the device's clock shows this time."""

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force: the registers know nothing of it."""

    def bring_to(self, joints: Joints, opening_mm: float) -> None:
        """Jog the arm to a physical posture, as a person does who looks at it; this is counted.

        Raises `BadRequest` without power or in motion.
        """

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit from outside. Raises `BadRequest` for one that there is not."""

    def power_off(self) -> None:
        """Switch off: motion stops dead, the arm sags, and what it knew is lost."""

    def power_on(self) -> None:
        """Switch on."""

    def to_json(self) -> dict[str, Json]:
        """Return everything that a standing device needs to be made again, and its world."""

    def recall(self, saved: Saved) -> None:
        """Know again what `to_json` wrote, apart from the world. Raises `StateFileError`."""


@runtime_checkable
class HasPendant(Protocol):
    """A device with a teach pendant, whose keys have names."""

    def key_names(self) -> tuple[str, ...]:
        """Name the keys."""

    def press_named(self, name: str) -> None:
        """Press a key. Raises `BadRequest` for one that there is not."""


@runtime_checkable
class GivesControl(Protocol):
    """A device whose host can hand control over to the person beside the arm."""

    def pendant_returns(self) -> bool:
        """Give control back to the host; False where the host has it."""


@runtime_checkable
class HasSpeedError(Protocol):
    """A device whose motors can be set to turn faster or slower than it believes."""

    @property
    def speed_error(self) -> float:
        """By which share motions last longer than they should."""

    def set_speed_error(self, error: float) -> None:
        """Set it for motions that begin from now on. Raises `BadRequest`."""


@runtime_checkable
class Resettable(Protocol):
    """A board with a reset that leaves the power on: a button, a watchdog, DTR."""

    def reset(self) -> None:
        """Begin the firmware anew; what that does to position and current is the board's own."""


class SwitchState(Enum):
    """What a limit switch does."""

    FREE = "free"
    """It follows the arm, as it should."""
    OPEN = "open"
    """It is stuck, and never seen pressed."""
    CLOSED = "closed"
    """It is stuck, and always seen pressed."""


@runtime_checkable
class HasSwitches(Protocol):
    """A device with a limit switch on each of its axes."""

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Have the switch of an axis (counted from 0) stick, or free it."""


def lacks(device: SimDevice, what: str) -> BadRequest:
    """Return the refusal for a device that has no such thing."""
    return BadRequest(f"the simulated {device.title} has no {what}")
