"""A host on the wire of a simulated Armdroid, and simulated Armdroids that stand referenced."""

from __future__ import annotations

from dataclasses import replace

from armdrive.arm import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate
from armdrive.sim.armdroid.device import ArmdroidBoard, ArmdroidQuirks
from armdrive.sim.device import SimDevice
from armdrive.sim.simulated_arm import link_to
from armdrive.status import Trust
from kinematics import Joints

BYTE_S = 10 / 9600
OVER_THE_TABLE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)
CONFIG = simulated_config("armdroid")


class Bench:
    """Writes characters and reads what comes, on simulated time."""

    def __init__(self, **quirks):
        self.board = ArmdroidBoard(quirks=ArmdroidQuirks(**({"character_s": 0.0} | quirks)))
        self.device = SimDevice(self.board)
        self.link = link_to(self.device)
        self.now_s = 0.0

    def send(self, text):
        self.link.write(text.encode("ascii"), self.now_s)

    def hear(self, seconds=2.0):
        self.now_s += seconds
        return self.link.read(self.now_s).decode("ascii")

    def ask(self, text, seconds=2.0):
        self.send(text)
        return self.hear(seconds)


def configured(burst_s=None, **device):
    """An Armdroid's config with other settings of the dialect."""
    motion = CONFIG.motion if burst_s is None else replace(CONFIG.motion, planned_burst_s=burst_s)
    return replace(CONFIG, motion=motion, device=replace(CONFIG.device, **device))


def ready_arm(config=CONFIG, **options) -> Arm:
    """An arm that stands over the table, enabled and referenced."""
    twin = simulate(config, **options)
    twin.world.drive_to(twin.world.body.transmission.to_motors(OVER_THE_TABLE, 20.0))
    arm = Arm(connect_simulated(config, twin=twin))
    arm.enable()
    arm.declare_posture(OVER_THE_TABLE, opening_mm=20.0)
    return arm


def honest(arm):
    """A referenced arm stands where it says, by its physical motors."""
    status = arm.status
    return status.trust is not Trust.REFERENCED or arm.twin.world.motors == status.acknowledged
