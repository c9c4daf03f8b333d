"""What a fault of a simulated arm is: the row of the table, and what it can befall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from armdrive.sim.device import SimDevice
from armdrive.sim.fault_request import FaultRequest
from armdrive.sim.pacing import PacedDevice


class Cable(Protocol):
    """What can be pulled out and put back."""

    def unplug(self) -> None:
        """Pull it."""

    def replug(self, name: str | None = None) -> None:
        """Put it back, where it may be found under another name."""


@dataclass(frozen=True, slots=True)
class Bench:
    """All that a fault can befall."""

    device: SimDevice
    line: PacedDevice
    cable: Cable


@dataclass(frozen=True, slots=True)
class Running:
    """A fault that goes on: how to end it, and whether it still does something."""

    end: Callable[[], None]
    alive: Callable[[], bool] = lambda: True


Begin = Callable[[], Running | None]
Prepare = Callable[[Bench, FaultRequest], Begin]


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One row; `needs` is what a device must be able to do, and `lasts_s` how long unless told."""

    name: str
    arguments: str
    summary: str
    prepare: Prepare
    counts: tuple[int, int] = (0, 0)
    needs: type | None = None
    lasts_s: float | None = None

    @property
    def usage(self) -> str:
        """How it is written."""
        return f"{self.name} {self.arguments}".strip()

    def befalls(self, device: type[SimDevice]) -> bool:
        """Tell whether this kind of device can have it."""
        return self.needs is None or issubclass(device, self.needs)
