"""The simulated Tutor board."""

from armdrive.sim.tutor.device import KIND as KIND
