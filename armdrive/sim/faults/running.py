"""Faults on request: those that are under way on one simulated arm, begun and ended on its clock.

The same on a wire within the process, on a pseudo-terminal and on a socket.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from armdrive.errors import ArmError
from armdrive.errors.arguments import BASIC, checked_calls, made_of
from armdrive.sim.device import SimDevice
from armdrive.sim.faults.request import (
    Begin,
    Cable,
    FaultBench,
    FaultRequest,
    Running,
    check_count,
)
from armdrive.sim.faults.table import fault_kind
from armdrive.sim.wire import PacedDevice
from armdrive.transports.in_process import MemoryLink


@dataclass(frozen=True, slots=True, eq=False)
class _Active:
    request: FaultRequest
    running: Running


def link_cable(link: MemoryLink[PacedDevice]) -> Cable:
    """Return the cable of a wire within the process."""
    return Cable(link.line, link.unplug, link.replug)


@checked_calls({**BASIC, "FaultRequest": made_of(FaultRequest, "a fault that was asked for")})
class Faults:
    """The faults of one device. Called from the thread that owns the device, or under its lock."""

    def __init__(self, device: SimDevice, line: PacedDevice, cable: Cable) -> None:
        self._bench = FaultBench(device, line, cable)
        self._active: list[_Active] = []
        self.troubles: list[str] = []
        """What could not be done when its time came; whoever reads this clears it."""

    @property
    def active(self) -> tuple[str, ...]:
        """What is wrong at present, as it was asked for."""
        return tuple(each.request.text for each in self._active if each.running.alive())

    def add(
        self,
        name: str,
        *arguments: object,
        side: str = "both",
        seed: int = 0,
        after_s: float = 0.0,
        for_s: float | None = None,
    ) -> None:
        """Have something go wrong: `add("drop", 0.01, side="host")`; see `table.FAULTS`.

        `after_s` counts from the device's present time. Raises `BadRequest`.
        """
        words = tuple(str(each) for each in arguments)
        self.ask(FaultRequest(name, words, side, seed, after_s, for_s))

    def ask(self, request: FaultRequest) -> None:
        """Have a fault as it was read from words; what is wrong with it is said at once."""
        begin = self.checked(request)
        lasts_s = fault_kind(request.name).lasts_s if request.for_s is None else request.for_s

        def start() -> None:
            running = begin()
            if running is None:
                return
            active = _Active(request, running)
            self._active = [*(each for each in self._active if each.running.alive()), active]
            if lasts_s is not None:
                device = self._bench.device
                device.at(device.now_s + lasts_s, lambda: self._later(lambda: self._end(active)))

        if request.after_s:
            device = self._bench.device
            device.at(device.now_s + request.after_s, lambda: self._later(start))
        else:
            start()

    def checked(self, request: FaultRequest) -> Begin:
        """Return what would begin a fault, or raise `BadRequest`; nothing happens yet."""
        kind = fault_kind(request.name)
        check_count(kind.usage, request.words)
        return kind.prepare(self._bench, request)

    def end(self, name: str | None = None) -> tuple[str, ...]:
        """End the faults of a name, or all; return those that were."""
        ended = [each for each in self._active if name in (None, each.request.name)]
        for each in ended:
            self._end(each)
        return tuple(each.request.text for each in ended)

    def _later(self, action: Callable[[], None]) -> None:
        """Do something at its time, when nobody is there to hear that it cannot be done."""
        try:
            action()
        except ArmError as error:
            self.troubles.append(str(error))

    def _end(self, active: _Active) -> None:
        if active in self._active:
            self._active.remove(active)
            if active.running.alive():
                active.running.end()


def check_faults(device: SimDevice, requests: Iterable[FaultRequest]) -> None:
    """Raise `BadRequest` for a fault that this device cannot have; nothing happens to it."""
    link = MemoryLink(PacedDevice(device, None), "simulated arm")
    try:
        faults = Faults(device, link.line, link_cable(link))
        for request in requests:
            faults.checked(request)
    finally:
        link.close()
