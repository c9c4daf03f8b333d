"""Simulated MKS drives: what each does with a request (`node`), how it moves (`motion`).

`kind` makes the arm; `quirks` lists what is not plain or not known of real drives.
"""

from armdrive.sim.mks.kind import KIND as KIND
