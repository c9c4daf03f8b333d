"""The program that some arms keep in a memory of their own, for their pendant."""

from __future__ import annotations

from armdrive.config.arm import ArmConfig
from armdrive.dialects.pendant import PendantTools

# The TeachMover's is the one such program so far: other code takes the name from here.
from armdrive.dialects.teachmover.pendant import PendantProgram as PendantProgram
from armdrive.errors import Refused
from armdrive.registry import dialect


def pendant_of(config: ArmConfig) -> PendantTools[PendantProgram]:
    """Return how an arm's own program is read and written; raises `Refused` where it has none."""
    tools = dialect(config.connection.dialect).pendant
    if tools is None:
        raise Refused(f"the {config.title} keeps no program in a memory of its own")
    return tools
