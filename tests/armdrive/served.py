"""A simulated arm of any dialect behind a pty or a socket, in a thread of this process."""

from __future__ import annotations

import json
import os
import queue
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from waiting import LONG_S, TURN_S, PatientClock
from watched_sim import Watch

from armdrive.connect.target import simulated_config
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime import clock
from armdrive.setup import dialog_runner
from armdrive.sim import serving
from armdrive.sim.device import SimDevice
from armdrive.sim.faults import parse_option
from armdrive.sim.serving import make_server, run_device
from armdrive.transports import can_link, can_slcan

# Device and driver share one clock, on which a late device is not late.
PATIENT = PatientClock()
serving.LONGEST_SLEEP_S = TURN_S / 2.0
for module in (clock, can_link, can_slcan, dialog_runner, serving):
    module.time = SimpleNamespace(monotonic=PATIENT.monotonic)


class ServedDevice:
    """One device in a thread in real time, steered by the lines of its console."""

    def __init__(self, server: Any, device: SimDevice, *faults: str) -> None:
        self.server, self.device = server, device
        self._said: queue.Queue[str] = queue.Queue()
        ear, self._mouth = os.pipe()
        self._thread = threading.Thread(
            target=run_device,
            args=(self.device, self.server, ear, self._said.put),
            kwargs={"faults": [parse_option(each) for each in faults]},
            daemon=True,
        )
        self._thread.start()
        PATIENT.wait_for(self._thread)

    def tell(self, line: str) -> str:
        """Give a command of the console and return its answer."""
        os.write(self._mouth, line.encode() + b"\n")
        return self.hear()

    def hear(self) -> str:
        """Return what the console says next."""
        return self._said.get(timeout=LONG_S)

    def end(self) -> None:
        """End the simulation."""
        os.write(self._mouth, b"quit\n")
        self._thread.join(LONG_S)
        assert not self._thread.is_alive()
        os.close(self._mouth)


class Served(ServedDevice):
    """The simulated arm of a dialect, as any driver reaches it; drives are behind an adapter."""

    def __init__(
        self,
        dialect: str,
        *,
        pty: Path | None = None,
        tcp: str | None = None,
        udp: str | None = None,
        **settings: Any,
    ) -> None:
        device = simulate(simulated_config(dialect), **settings).device
        can = DIALECTS[dialect].can
        if can:
            server = make_server(slcan=pty, bits_s=device.board.bits_s)
        else:
            server = make_server(pty=pty, tcp=tcp, udp=udp)
        super().__init__(server, device)
        self.port = str(server.can_addresses[0] if can else server.address)
        """What a driver opens."""
        self.watch = Watch(self.look)

    def look(self) -> tuple[float, dict[str, Any]]:
        """Return the time on the device's own clock, and its physical state then."""
        state = json.loads(self.tell("state --json"))
        return state.pop("time_s"), state

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *error: object) -> None:
        self.end()
