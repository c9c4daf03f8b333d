"""Testing a program of arms without any: `ArmWorld` here, and its pytest fixtures in `plugin`.

Names are imported when they are first used: pytest loads this package wherever armdrive is
installed, also for tests that have nothing to do with arms.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from typing import Any

    from armdrive.testing.arm_world import ArmWorld

__all__ = ["ArmWorld"]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    if name != "ArmWorld":
        raise AttributeError(f"module 'armdrive.testing' has no attribute {name!r}")
    from armdrive.testing.arm_world import ArmWorld

    return ArmWorld
