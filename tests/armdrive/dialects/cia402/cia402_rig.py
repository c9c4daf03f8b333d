"""A CiA 402 controller on the simulated bus of an arm, without the engine."""

import math
from dataclasses import replace

from driver_bench import BusBench

from armdrive.connect.target import simulated_config
from armdrive.dialects.cia402.controller import Cia402Controller
from armdrive.registry import DIALECTS, simulate
from armdrive.tasks import MoveAlong, MoveBy
from firmware_protocol.canopen import Service, service_of
from firmware_protocol.frames import Frame
from kinematics import Motors

QUICK = {"period_ms": 10}
"""The settings of tests of single cycles: as shipped."""


class Rig(BusBench):
    """A controller and its drives in simulated time.

    Most tests do without every other SYNC, which halves their work.
    """

    def __init__(self, settings: dict | None = None, **options) -> None:
        config = simulated_config("cia402")
        settings = {"period_ms": 20} | (settings or {})
        self.config = replace(config, device=replace(config.device, **settings))
        self.twin = simulate(self.config, **options)
        controller = Cia402Controller(DIALECTS["cia402"].abilities, self.config)
        super().__init__(controller, self.twin.device, self.twin.link)

    def node(self, number: int):
        """Return a drive, counted from 1."""
        return self.device.board.nodes[number - 1]

    def along(self, *segments: MoveBy, released=lambda: False, ahead_s: float = 0.3):
        """Move along segments, and return the reply."""
        return self.do(MoveAlong(iter(segments), ahead_s, released=released))

    def stop(self, *, hard: bool = False) -> None:
        """Request a stop."""
        self.controller.stop(hard=hard)

    def frames(self, service: Service, since_s: float = -math.inf) -> list[tuple[float, Frame]]:
        """Return the frames of a service that the driver sent, with their times."""
        return [
            (at_s, frame)
            for at_s, frame in self.sent
            if at_s >= since_s and (service_of(frame.can_id) or (None,))[0] is service
        ]

    def targets(self, node: int, since_s: float = -math.inf) -> list[tuple[float, int]]:
        """Return the targets that a drive got, with their times."""
        return [
            (at_s, int.from_bytes(frame.data[3:7], "little", signed=True))
            for at_s, frame in self.frames(Service.RPDO1, since_s)
            if frame.can_id == 0x200 + node
        ]

    def words(self, node: int) -> list[int]:
        """Return the controlwords that a drive got."""
        return [
            int.from_bytes(frame.data[:2], "little")
            for _, frame in self.frames(Service.RPDO1)
            if frame.can_id == 0x200 + node
        ]

    def states(self) -> set[object]:
        """Return the set of the drives' states."""
        return {node.states.state for node in self.device.board.nodes}


def steps(*counts: int) -> Motors:
    """Return the steps of six motors; the remaining ones stand."""
    return Motors((*counts, *[0] * (6 - len(counts))))


def moving(way: Motors, after_s: float = 0.5, settings: dict | None = None, **options) -> Rig:
    """Return a bench whose drives have been moving for a while, at 20,000 increments per second."""
    rig = Rig(settings, **options).ready()
    burst = bool(settings) and settings.get("strategy") == "profile"
    move = MoveBy(way, 20_000.0)
    rig.begin(move if burst else MoveAlong(iter([move]), 10.0))
    rig.run(after_s)
    return rig
