"""Simulated MKS drives: `node` is one drive, `motion` how it moves, `kind` the whole arm.

`quirks` lists peculiarities of real drives, and what is not known about them.
"""

from armdrive.sim.mks.kind import KIND as KIND
