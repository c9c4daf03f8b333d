"""Ports of real arms with simulated controllers behind them, driven in simulated time.

A command opens them as any real arm: it asks the person, holds locks, and writes records. Only the
bytes skip the operating system, and waiting takes no time. `served` has the same in real time.
"""

import pytest

from armdrive.connect import parts, port
from armdrive.connect.target import simulated_config
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.transports.link import Link


class SimulatedPorts:
    """The ports of one computer, on one clock."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.arms: dict[str, SimulatedArm] = {}
        self._clock = SimulatedClock()
        patch.setattr(parts, "RealPace", lambda: SimulatedPace(self._clock))
        patch.setattr(port.opening, "open_link", self._open)

    def put(self, address: str, dialect: str) -> SimulatedArm:
        """Put the controller of a dialect behind an address, and return it."""
        self.arms[address] = simulate(simulated_config(dialect))
        return self.arms[address]

    def _open(self, address: str, baud: int, **_: bool) -> Link:
        named = address.partition("?")[0].removeprefix("can:slcan:")
        return self.arms[named].link.reopen(self._clock.now_s)
