"""Drive Mini-mover-style robot arms, real or simulated, from Python or a terminal.

```python
from armdrive import Arm, Pose
with Arm.connect("sim:teachmover") as arm:
    arm.home()
    arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))
```

`armdrive.exports` lists the public names. All are loaded when the first one is used, so that the
command line, which is part of this package and needs none of them, starts quickly.
"""

from __future__ import annotations

TYPE_CHECKING = False  # like typing.TYPE_CHECKING; importing typing would slow down the start
if TYPE_CHECKING:
    from armdrive.exports import *  # noqa: F403 - for type checkers
else:  # from them this is hidden: else they would take any name for a public one

    def __getattr__(name: str) -> object:
        """Return a public name."""
        if name == "__all__" or not name.startswith("_"):  # unittest probes for private names
            import armdrive.exports as exports

            if name in vars(exports):
                return getattr(exports, name)
            if name == "__all__":
                return [each for each in vars(exports) if not each.startswith("_")]
        raise AttributeError(f"module 'armdrive' has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted([*globals(), *__getattr__("__all__")])
