"""One physical arm and a disk that can lose its power, for the programs that come one by one."""

from pathlib import Path

from faults import OVER_THE_TABLE, sim_config
from power_disk import MortalLink, PowerDisk

from armdrive.arm import Arm
from armdrive.connect.parts import assemble
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.sim.simulated_arm import TITLE
from armdrive.status import Trust
from armdrive.storage.record import RecordFile

PATH = Path("/state/arm.json")
CONFIG = sim_config(planned_burst_s=0.5, idle_poll_s=0.0)
REST_S = 5.0


class Life:
    """One physical arm, and the programs that drive it one after the other."""

    def __init__(self, disk=None):
        self.disk = disk or PowerDisk()
        self.twin = simulate(CONFIG)
        world = self.twin.world
        world.drive_to(world.body.transmission.to_motors(OVER_THE_TABLE, 20.0))
        self.now_s = 0.0
        self.arm = None

    def connect(self, disk=None, **options):
        """Have another program connect; `disk` is what it finds."""
        self.disk = disk or self.disk
        self.link = MortalLink(self.twin.device.line(), TITLE)
        self.link.moments = self.disk.moments
        self.pace = SimulatedPace(SimulatedClock(self.now_s))
        recorder = RecordFile(PATH, self.disk)
        self.arm = Arm(
            assemble(CONFIG, self.link, self.pace, simulated=True, record_store=recorder, **options)
        )
        return self.arm

    def end(self):
        """Whatever was sent arrives, and the arm comes to rest."""
        self.now_s = self.pace.now_s() + REST_S
        self.link.line.advance(self.now_s)

    @property
    def motors(self):
        return self.twin.world.motors


def recorded_life():
    """An arm just switched on, its registers all zero, referenced by a program that ended well.

    The hardest case: after a power cut the registers will be zero again, and agree.
    """
    life = Life()
    arm = life.connect()
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    arm.close()
    life.end()
    return life


def move(life):
    """What the next program does: a move, a rest that clears the mark, a move, and the end."""
    arm = life.connect(allow_restored=True)
    arm.move_j(base_deg=4.0)
    arm.sleep(2.5)
    arm.move_j(base_deg=2.0, elbow_deg=-79.0)
    arm.close()


def believed(life, text):
    """Connect as the next program does, with this on its disk; return what it believes."""
    arm = life.connect(life.disk.holding(PATH, text))
    found = (arm.status.trust, arm.status.acknowledged)
    life.now_s = life.pace.now_s()
    return found


def wrong(found):
    """Yield the moments after which something was believed that is not so."""
    for moment, trust, position, truth in found:
        if trust is Trust.REFERENCED or (trust is Trust.RESTORED and position != truth):
            yield moment
