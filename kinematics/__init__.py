"""The kinematics of the arm: poses, joint angles, motor steps, and conversions between them.

Units: mm, rad, whole motor steps. Everything named here is plain Python. The public names are
listed in `kinematics.exports` and, for the lecture notes, in `kinematics.textbook.exports`. Each
list is loaded when one of its names is first used, so that importing a submodule loads nothing
else.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from kinematics.exports import *  # noqa: F403 - what type checkers see
    from kinematics.textbook.exports import *  # noqa: F403
else:  # hidden from them: else they would take any name for a public one

    def __getattr__(name: str) -> object:
        """Return a public name."""
        if name == "__all__" or not name.startswith("_"):  # unittest asks for private names
            import kinematics.exports as exports

            if name in vars(exports):
                return getattr(exports, name)
            import kinematics.textbook.exports as textbook

            if name in vars(textbook):
                return getattr(textbook, name)
            if name == "__all__":
                names = (*vars(exports), *vars(textbook))
                return [each for each in names if not each.startswith("_")]
        raise AttributeError(f"module 'kinematics' has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted([*globals(), *__getattr__("__all__")])
