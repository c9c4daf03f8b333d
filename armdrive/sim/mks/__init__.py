"""mks: its simulated device."""

from armdrive.sim.mks.kind import KIND as KIND
