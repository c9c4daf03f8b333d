"""cia402: its simulated device."""

from armdrive.sim.cia402.kind import KIND as KIND
