"""A small host for a simulated Armdroid."""

from armdrive.connect.target import simulated_config
from armdrive.sim.armdroid import ArmdroidBoard, ArmdroidQuirks
from armdrive.sim.device import SimDevice
from armdrive.sim.simulated_arm import link_to

BYTE_S = 10 / 9600
CONFIG = simulated_config("armdroid")


class Bench:
    """Writes characters, and reads replies, in simulated time."""

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
