"""What a failure of power leaves to be known, and when: what a device cannot tell is excused here.

Counts that fall to zero are seen at the next look. Counts that were zero before tell nothing. Then
a board may greet, or may have been silent when a program looked; if neither, nobody can know.
"""

from __future__ import annotations

from .stage import Stage

LOOK_S = 0.5
"""A program that looks when it is due to has begun to look by then, whatever comes of it."""
BOOT_S = 2.0
"""A board that greets has done so by then."""


def seen_by_s(stage: Stage) -> float:
    """Return when an idle program looks next, at the latest."""
    return stage.now_s + stage.config.motion.idle_poll_s + LOOK_S


def fail_power(stage: Stage, for_s: float = 0.0) -> None:
    """Hear that the board loses its power now, or is reset."""
    stage.look()
    stage.watch.untold(stage.now_s)
    stage.watch.change(stage.now_s, seen_by_s(stage))
    if not stage.twin.device.registers.largest or stage.told_zeros:
        _zeros_stay_zeros(stage, for_s)


def _zeros_stay_zeros(stage: Stage, for_s: float) -> None:
    watch, arm = stage.watch, stage.arm
    greets = stage.hears_greetings
    looked_at = stage.looks and for_s > stage.config.motion.idle_poll_s + LOOK_S
    if stage.twin.faults.active or not (greets or looked_at):
        watch.untold()
        return
    watch.told_by_s = stage.now_s + for_s + (BOOT_S if greets else LOOK_S)
    watch.change(stage.now_s, watch.told_by_s)

    def end() -> None:
        """Excuse it after all where that program has not been there all the time."""
        if stage.arm is not arm or not (stage.hears_greetings if greets else stage.looks):
            watch.untold()

    stage.agenda.at(watch.told_by_s, end)
