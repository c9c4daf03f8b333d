"""teachmover: its simulated device."""

from armdrive.sim.teachmover.device import KIND as KIND
