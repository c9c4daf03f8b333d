"""Lost motion, physically: a pin in a slot between each motor and what it drives.

The motor moves the slot, which is longer than the pin by the play; the pin follows only where an
end of the slot pushes it. All in steps.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.errors import BadRequest
from kinematics.spaces import Motors

MOST_STEPS = 10_000


class Play:
    """The slots of all motors; `ahead` is how far each is ahead of its pin, from 0 to its width."""

    def __init__(self, widths: Sequence[int]) -> None:
        self.widths = tuple(widths)
        self.any = any(self.widths)
        self.ahead = [0] * len(self.widths)

    def stand(self, ahead: Sequence[int]) -> None:
        """Have the slots stand so far ahead, or as far as they are long."""
        self.ahead = [min(one, width) for one, width in zip(ahead, self.widths, strict=False)]

    def drive(self, steps: Sequence[int]) -> Sequence[int]:
        """Move the slots; return how far the pins were pushed."""
        if not self.any:
            return steps
        pushed = []
        for motor, (step, width) in enumerate(zip(steps, self.widths, strict=True)):
            slot = (
                self.ahead[motor] + step
            )  # the pin is at 0, and has to be in slot - width ... slot
            pin = min(max(0, slot - width), slot)
            self.ahead[motor] = slot - pin
            pushed.append(pin)
        return Motors(pushed)

    def turns_for(self, steps: Motors) -> Motors:
        """Return how far motors have to turn to push their pins so far."""
        if not self.any:
            return steps
        return Motors(
            step + (width - ahead if step > 0 else -ahead if step else 0)
            for step, width, ahead in zip(steps, self.widths, self.ahead, strict=True)
        )


def play_of(play: int | Sequence[int], count: int) -> tuple[int, ...]:
    """Return the play of each motor, from one number for all of them or one for each."""
    widths = tuple(play) if isinstance(play, Sequence) else (play,) * count
    if len(widths) != count or any(
        type(width) is not int or not 0 <= width <= MOST_STEPS for width in widths
    ):
        raise BadRequest(
            f"play is a whole number of steps from 0 to {MOST_STEPS}, or {count} of them, "
            f"not {play!r}"
        )
    return widths
