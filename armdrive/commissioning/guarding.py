"""Trying out whether a drive stops by itself when its bus falls silent (98, firmware 1.0.9 on)."""

from __future__ import annotations

from armdrive.commissioning.acts import Hear, Put, Stands, Talk, agreed, say
from armdrive.commissioning.drives import Known
from armdrive.commissioning.moving import ACC, MOST_RPM, turn_to, where
from armdrive.commissioning.plan import Plan, Planned
from armdrive.commissioning.setting import write
from armdrive.commissioning.trying import counts_of
from firmware_protocol.mks import COUNTS_PER_TURN, Ability, MoveAbsoluteAxis, SilenceWatchdog

TRIAL_MS = 100
"""What it is set to while it is tried."""
RUN_S = 0.8
"""A motion that would take so long, were it not stopped."""
SILENCE_S = 1.2
STILL_SHARE = 0.01
"""One that has come no farther did not run at all."""
STOPPED_SHARE = 0.7
"""It was stopped where it has come no farther than this share of its way."""


def try_watchdog(plan: Plan, drive: Planned, found: Known, gear: float) -> Talk[bool | None]:
    """Try the watchdog; return whether it stopped the motor, None where that was not tried."""
    if not plan.device.watchdog_s or Ability.SILENCE_WATCHDOG not in found.able:
        return None
    counts, rpm = _run(drive, gear)
    if not (
        yield from agreed(
            f"Try the watchdog? The {drive.name} runs as far as before, and the bus is silent: it "
            f"should stop early by itself. For {RUN_S:g} s only the supply's switch could stop "
            "it otherwise. Now?",
            f"The watchdog is set to {TRIAL_MS} ms meanwhile, and back to "
            f"{plan.device.watchdog_s:g} s afterwards. no trusts it untried.",
            motor=drive.motor,
        )
    ):
        return None
    start = yield from where(drive.node)
    final = SilenceWatchdog(round(plan.device.watchdog_s * 1000))
    if start is None or not (yield from write(drive.node, SilenceWatchdog(TRIAL_MS), found)):
        yield from say("The drive does not take the watchdog.")
        return False
    yield Put(drive.node, MoveAbsoluteAxis(start + counts, rpm, ACC))
    yield Hear(SILENCE_S)
    at = yield from where(drive.node)
    yield Stands(drive.node)
    kept = yield from write(drive.node, final, found)
    yield from turn_to(drive.node, start, rpm)
    if at is None or not kept:
        yield from say(f"Drive {drive.node} stopped answering: look at its supply and cable.")
        return False
    share = abs(at - start) / counts
    if share < STILL_SHARE:
        yield from say("The motor did not move at all, so that this tells nothing.")
        return None
    works = share <= STOPPED_SHARE
    yield from say(
        f"The watchdog works: it stopped after {share:.0%} of the way."
        if works
        else "The watchdog did not stop it. The drive ends at its last target when the computer "
        "dies, which armdrive keeps no further ahead than 0.3 s."
    )
    return works


def _run(drive: Planned, gear: float) -> tuple[int, int]:
    """Return counts and speed of a run that takes as long as it should, and is not too short."""
    counts = counts_of(drive, gear)
    rpm = round(counts / COUNTS_PER_TURN * 60.0 / RUN_S)
    if 1 <= rpm <= MOST_RPM:
        return counts, rpm
    rpm = min(max(rpm, 1), MOST_RPM)
    return round(rpm / 60.0 * COUNTS_PER_TURN * RUN_S), rpm
