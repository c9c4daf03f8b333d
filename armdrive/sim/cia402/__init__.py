"""Simulated CiA 402 drives: objects and frames (`node`), states, and motion.

`objects` holds what the EDS file describes; `kind` makes the arm, and lists what the standard
leaves open.
"""

from armdrive.sim.cia402.kind import KIND as KIND
