"""The kinematics of the arm: poses, joint angles, motor steps, and conversions between them.

Which file decides what:

    spaces         the three types: `Pose`, `Joints`, `Motors`
    transmission   joint angles and opening to motor steps: couplings, the only rounding
    limits         ranges, their tolerance, and which turn of an angle is chosen
    geometry       the interface of every arm that can be driven, and its refusals
    presets        the built-in arms: lengths, limits, speeds, steps, guards
    five_axis/     the Mini-mover's build
    chains/        any other build
    frames/        vectors, rotations, frames
    paths/         lines, arcs, blends, timing
    guards/        collision checks
    textbook/      the lecture notes; nothing that drives an arm uses them
    errors, text   errors with suggestions; numbers and columns as text

Units: mm, rad, whole motor steps. Everything named here is plain Python. The public names are
listed in `kinematics.exports`, which is loaded when one of them is first used, so that importing a
submodule loads nothing else.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from kinematics.exports import *  # noqa: F403 - what type checkers see
else:  # hidden from them: else they would take any name for a public one

    def __getattr__(name: str) -> object:
        """Return a public name."""
        if name == "__all__" or not name.startswith("_"):  # unittest asks for private names
            import kinematics.exports as exports

            if name in vars(exports):
                return getattr(exports, name)
            if name == "__all__":
                return [each for each in vars(exports) if not each.startswith("_")]
        raise AttributeError(f"module 'kinematics' has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted([*globals(), *__getattr__("__all__")])
