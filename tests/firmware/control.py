"""The control port of a device: it reports where the motors stand, and injects faults.

The processor simulator has one, and a rig around a real board can have one. Each UDP datagram is
one command and gets one answer (see `commands` in avrdev.c).
"""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from armdrive.errors import BadRequest
from armdrive.sim.faults import BROWN_OUT_S, FaultRequest
from kinematics import Motors


class NoSimulator(Exception):
    """Something that a simulated board needs is missing; the message says what to do."""


MIN_RUN_S = 1.0
"""The ratio of simulated to real time is meaningless over a shorter time."""


class Pace:
    """Measures how well simulated processors keep real time."""

    def __init__(self) -> None:
        self._sim_s = self._run_s = 0.0

    def add(self, sim_s: float, run_s: float) -> None:
        """Add how long a processor ran, and how long it should have run."""
        self._sim_s += sim_s
        self._run_s += run_s

    def taken(self) -> float | None:
        """Return simulated seconds per second since the last call; None if that is too short."""
        if self._run_s < MIN_RUN_S:
            return None
        ratio = self._sim_s / self._run_s
        self._sim_s = self._run_s = 0.0
        return ratio


ANSWERS_S = 5.0
NOISE_BYTES = 8


@dataclass(frozen=True, slots=True)
class PhysicalState:
    """The physical state of a device at one moment.

    `time_s` is the device's own clock. `sim_s` is how long its processor ran and `run_s` how long
    it should have run; they differ if the computer is too slow.
    """

    time_s: float
    positions: dict[str, int]
    energised: bool = True
    powered: bool = True
    sim_s: float = 0.0
    run_s: float = 0.0
    resets: int = 0


class ControlPort:
    """A control port reached by UDP: reports the physical motors, and injects faults."""

    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.settimeout(ANSWERS_S)
        self._socket.connect((host, port))
        self._alone = threading.Lock()

    @classmethod
    def at(cls, address: str) -> ControlPort:
        """Return the control port at HOST:PORT."""
        host, _, port = address.rpartition(":")
        if not port.isdecimal():
            raise BadRequest(f"a control port is written HOST:PORT, not {address!r}")
        return cls(host or "127.0.0.1", int(port))

    def say(self, words: str) -> str:
        """Send a command and return the answer. Raises `BadRequest` if it is refused."""
        with self._alone:
            self._socket.send(words.encode())
            answer = self._socket.recv(65536).decode()
        if answer.startswith("error"):
            raise BadRequest(f"{words!r}: {answer}")
        return answer

    def look(self) -> PhysicalState:
        """Return the physical state."""
        told: dict[str, Any] = json.loads(self.say("stat"))
        axes = told["axes"]
        return PhysicalState(
            told["cycle"] / told["hz"],
            {name: axis["pos"] for name, axis in axes.items()},
            all(axis["on"] for axis in axes.values()),
            told["powered"],
            told["sim_s"],
            told["run_s"],
            told["resets"],
        )

    def fault(self, request: FaultRequest, letters: str) -> None:
        """Inject a fault now; motor 1 has the first letter. Raises `BadRequest`."""
        for words in commands_of(request, letters):
            self.say(words)

    def heal(self) -> None:
        """Undo every fault."""
        self.say("heal")

    def replug(self, port: str) -> None:
        """Put the cable back under another name."""
        self.say(f"replug {port}")

    def place(self, letters: str, motors: Motors) -> None:
        """Set where the motors stand."""
        pairs = (f"{name} {at}" for name, at in zip(letters, motors, strict=True))
        self.say(f"pos {' '.join(pairs)}")

    def switch_at(self, letter: str, position: int, way: int) -> None:
        """Set the position from which on, upwards or downwards, a limit switch is closed."""
        self.say(f"limit_at {letter} {position} {way}")

    def flush(self) -> None:
        """Write the step log to disk."""
        self.say("flush")

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


EFFECTS = {"drop": "lose", "corrupt": "flip", "duplicate": "repeat", "delay": "delay"}
SWITCHES = {"closed": 1, "open": 0, "free": -1}


def commands_of(request: FaultRequest, letters: str) -> Iterator[str]:
    """Translate a fault of `armdrive.sim` into commands of a control port.

    Raises `BadRequest` if a control port has no such fault.
    """
    words, for_s = request.words, request.for_s or 0.0
    match request.name:
        case "drop" | "corrupt" | "duplicate" | "delay":
            delay_s = words[0] if request.name == "delay" else "0"
            amount = words[-1]
            for side in ("host", "device") if request.side == "both" else (request.side,):
                yield f"wire {side} {EFFECTS[request.name]} {amount} {for_s:g} {delay_s}"
        case "mute":
            yield f"wire device lose 1 {for_s:g}"
        case "garbage":
            yield f"garbage {words[0] if words else NOISE_BYTES}"
        case "unplug":
            yield f"unplug {round(for_s * 1000)}"
        case "brown-out":
            yield f"brown_out {round((for_s or BROWN_OUT_S) * 1000)}"
        case "reset":
            yield "reset"
        case "lose-steps":
            yield f"lose {_axis(words[0], letters)} {words[1]}"
        case "stall":
            yield f"stall {_axis(words[0], letters)} 1"
        case "switch":
            yield f"limit {_axis(words[0], letters)} {SWITCHES[words[1]]}"
        case _:
            raise BadRequest(f"a control port has no fault {request.text!r}")


def _axis(motor: str, letters: str) -> str:
    return letters[int(motor) - 1]
