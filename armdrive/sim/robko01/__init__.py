"""robko01: its simulated device."""

from armdrive.sim.robko01.device import KIND as KIND
