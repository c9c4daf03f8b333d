"""A simulated arm of any dialect behind a pty or a socket, in a thread of this process."""

from __future__ import annotations

import io
import json
import os
import threading
from pathlib import Path
from typing import Any

from waiting import LONG_S, until

from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate_device
from armdrive.sim.serving.loop import make_server, run_device


class Served:
    """One device in real time, steered by the lines of its console."""

    def __init__(
        self,
        dialect: str,
        *,
        pty: Path | None = None,
        tcp: str | None = None,
        udp: str | None = None,
    ) -> None:
        self.server = make_server(pty=pty, tcp=tcp, udp=udp)
        self._scheme = "socket" if udp is None else "udp"
        self.device = simulate_device(simulated_config(dialect))
        self.out = io.StringIO()
        ear, self._mouth = os.pipe()
        self._thread = threading.Thread(
            target=run_device, args=(self.device, self.server, ear, self.out), daemon=True
        )
        self._thread.start()

    @property
    def port(self) -> str:
        """What a driver opens."""
        address = self.server.address
        return address if address.startswith("/") else f"{self._scheme}://{address}"

    def tell(self, line: str) -> str:
        """Give a command of the console and return its answer."""
        count = self.out.getvalue().count("\n")
        os.write(self._mouth, line.encode() + b"\n")
        until(lambda: self.out.getvalue().count("\n") > count)
        return self.out.getvalue().splitlines()[count]

    def look(self) -> tuple[float, dict[str, Any]]:
        """Return the time on the device's own clock, and its physical state then."""
        state = json.loads(self.tell("state --json"))
        return state.pop("time_s"), state

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *error: object) -> None:
        os.write(self._mouth, b"quit\n")
        self._thread.join(LONG_S)
        os.close(self._mouth)
