"""Which evidence a power failure or reset leaves, and when a driver can have seen it.

Registers that fall to zero show at the next poll. Registers that were zero before show nothing.
Then the board may send a greeting, or a poll may find it silent. If neither happens, no driver can
know of the restart, and it is excused.
"""

from .stage import Stage

LOOK_S = 0.5
"""A poll that is due has begun within this time, whatever its result."""
BOOT_S = 2.0
"""A board that sends a greeting has sent it within this time."""
RESET_S = 0.15
"""A simulated MKS drive that is reset holds its shaft again after this time (`BOOT_S`)."""


def next_poll_by_s(stage: Stage) -> float:
    """Return the latest time at which an idle program polls the arm next."""
    return stage.now_s + stage.config.motion.idle_poll_s + LOOK_S


def note_power_loss(stage: Stage, for_s: float = 0.0) -> None:
    """Note that the board loses its power for `for_s` from now on, or is reset."""
    stage.look()
    stage.watch.excuse_restart(stage.now_s)
    stage.watch.note_change(stage.now_s, next_poll_by_s(stage))
    stage.note_drive_restarts(range(len(stage.world.motors)), for_s or RESET_S)
    if not stage.twin.device.registers.largest or stage.reads_zero:
        _registers_stay_zero(stage, for_s)


def _registers_stay_zero(stage: Stage, for_s: float) -> None:
    """Excuse the restart, or note by when a greeting or a silent poll reveals it."""
    watch, arm = stage.watch, stage.arm
    greets = stage.receives_greeting
    found_silent = stage.polls_arm and for_s > stage.config.motion.idle_poll_s + LOOK_S
    if stage.twin.faults.active or not (greets or found_silent):
        watch.excuse_restart()
        return
    watch.restart_shown_by_s = stage.now_s + for_s + (BOOT_S if greets else LOOK_S)
    watch.note_change(stage.now_s, watch.restart_shown_by_s)

    def end() -> None:
        """Excuse the restart after all if that program did not run all the time."""
        if stage.arm is not arm or not (stage.receives_greeting if greets else stage.polls_arm):
            watch.excuse_restart()

    stage.schedule.at(watch.restart_shown_by_s, end)
