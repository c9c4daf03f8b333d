"""The program that some arms keep in a memory of their own, for their pendant.

The TeachMover's is the one such program so far: other code takes the name from here.
"""

from armdrive.dialects.teachmover.pendant import PendantProgram as PendantProgram
