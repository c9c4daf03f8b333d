"""A small host on a simulated bus of MKS drives: it asks, and lets simulated time pass."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection, HomingSettings
from armdrive.registry.simulate import simulate
from armdrive.sim.mks.kind import SimMks
from armdrive.sim.simulated_arm import SimulatedArm
from firmware_protocol import mks
from kinematics import preset

IDS = (1, 2, 3, 4, 5, 6)
TURN = 0x4000
LONG_S = 0.01
"""Longer than any answer takes."""


def arm_config(homing: HomingSettings | None = None, **mks: Any) -> ArmConfig:
    """Return an arm on six drives; `mks` is what its file's section says."""
    device = SimpleNamespace(**({"ids": IDS} | mks))
    wire = Connection(dialect="mks", port="", baud=500_000)
    model = preset("minimover5-mks")
    return ArmConfig("bench", model.title, model, wire, device=device, homing=homing)


class Bench:
    """The twin of an arm, and a host at the other end of its bus. Events carry their times."""

    def __init__(
        self,
        ids: tuple[int, ...] = IDS,
        *,
        config: ArmConfig | None = None,
        saved: object = None,
        **settings: Any,
    ) -> None:
        self.twin: SimulatedArm = simulate(config or arm_config(), saved, **settings)
        assert isinstance(self.twin.device, SimMks)
        self.device: SimMks = self.twin.device
        self.world = self.twin.world
        self.link = self.twin.link
        self.host = mks.Host(ids)
        self.now_s = 0.0
        self.heard: list[tuple[float, mks.Event]] = []

    def send(self, node: int, request: mks.Request) -> None:
        """Put a request on the bus."""
        self.link.write(self.host.send(node, request), self.now_s)

    def run(self, seconds: float = LONG_S) -> list[mks.Event]:
        """Let time pass; return what was heard meanwhile."""
        end_s, before = self.now_s + seconds, len(self.heard)
        while self.link.next_s() <= end_s:
            self.now_s = max(self.now_s, self.link.next_s())
            self._read()
        self.now_s = end_s
        self._read()
        return [event for _, event in self.heard[before:]]

    def ask(self, node: int, request: mks.Request, seconds: float = LONG_S) -> list[mks.Event]:
        """Put a request on the bus and return what is heard soon after."""
        self.send(node, request)
        return self.run(seconds)

    def counts(self, node: int) -> int:
        """Ask a drive where it is."""
        (event,) = self.ask(node, mks.ReadEncoder())
        assert isinstance(event, mks.Answered)
        assert isinstance(event.answer, mks.EncoderRead)
        return event.answer.counts

    def state(self, node: int) -> Any:
        """Ask a drive what it does."""
        (event,) = self.ask(node, mks.ReadState())
        assert isinstance(event, mks.Answered)
        assert isinstance(event.answer, mks.StateRead)
        return event.answer.state

    def time_of(self, kind: type) -> float:
        """Return when the last event of a kind was heard."""
        return next(at for at, event in reversed(self.heard) if isinstance(event, kind))

    def _read(self) -> None:
        self.host.receive_data(self.link.read(self.now_s))
        while (event := self.host.next_event()) is not None:
            self.heard.append((self.now_s, event))


def outcomes(events: list[mks.Event]) -> list[type]:
    """Return what kind each event is."""
    return [type(event) for event in events]
