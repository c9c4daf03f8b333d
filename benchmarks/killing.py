"""A jogging program is killed outright: how long the simulated arm in another process goes on."""

from __future__ import annotations

from statistics import median

from measuring import Row, Section, p99

from tests.conformance.overrun import ENDINGS, LOOK_S, measure

DIALECT = "teachmover"


def killing(kills: int = 10) -> Section:
    """Kill at random moments of a burst."""
    ending = next(each for each in ENDINGS if each.silent and each.begin == "jog")
    found = measure(DIALECT, ending, kills)
    rests = [each.time_s + LOOK_S for each in found]  # it may have moved on until the next look
    bound_s = max(each.announced_s for each in found)
    shares = {"the announced bound": max(rests) / bound_s}
    rows = (
        Row("announced: status.silent_time_s", bound_s * 1e3, "ms"),
        Row("SIGKILL to stand-still", median(rests) * 1e3, "ms", p99(rests) * 1e3),
        Row("the worst of them", max(rests) * 1e3, "ms", times=shares),
    )
    return Section(
        "Killed in mid-jog",
        rows,
        f"{kills} kills of a program that jogs three joints of a TeachMover at full speed; seen "
        "every few ms at the physical motors. Every dialect, and other ends: "
        "benchmarks/stopping.py",
    )
