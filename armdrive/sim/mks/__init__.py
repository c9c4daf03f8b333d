"""Simulated MKS drives: `node` is one drive, `motion` how it moves, `kind` the arm and quirks."""

from armdrive.sim.mks.kind import KIND as KIND
