"""Test a program without real arms: `ArmWorld`, and pytest fixtures in `plugin`.

Names are imported on first use, because pytest loads this package wherever armdrive is installed,
even for tests that have nothing to do with arms.
"""

from __future__ import annotations

TYPE_CHECKING = False  # like typing.TYPE_CHECKING
if TYPE_CHECKING:
    from armdrive.testing.arm_world import ArmWorld
else:

    def __getattr__(name: str) -> object:
        """Import a public name on its first use."""
        if name != "ArmWorld":
            raise AttributeError(f"module 'armdrive.testing' has no attribute {name!r}")
        from armdrive.testing.arm_world import ArmWorld

        return ArmWorld


__all__ = ["ArmWorld"]
