"""armdroid: its simulated device."""

from armdrive.sim.armdroid.device import KIND as KIND
