"""grbl: its simulated device."""

from armdrive.sim.grbl.device import KIND as KIND
