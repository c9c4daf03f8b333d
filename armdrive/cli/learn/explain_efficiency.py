"""What each way of computing an arm costs, counted by running it: `armdrive explain efficiency`.

Source of the question: McKerrow, chapter 4, section 15.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from armdrive.cli.presenter import emit, say
from armdrive.errors import BadRequest
from kinematics.errors import UnknownSystem
from kinematics.textbook.efficiency import Efficiency, Tally, Way, efficiency
from kinematics.textbook.systems import SYSTEMS, system

DEFAULT = ("minimover5", "puma")


def explain_efficiency(names: Sequence[str], *, as_json: bool) -> None:
    """Print the counts of these systems, or of the Mini-mover and the Puma."""
    try:
        counted = [efficiency(system(name)) for name in names or DEFAULT]
    except UnknownSystem as error:
        raise BadRequest(str(error)) from None
    if as_json:
        emit({"efficiency": [_view(one) for one in counted]})
        return
    for one in counted:
        say(f"{SYSTEMS[one.system].title}")
        for title, ways in (("forward", one.forward), ("inverse", one.inverse)):
            if ways:
                _say_ways(title, ways)
        say("")
    say("counted by running the code on numbers that count; constants of an arm cost nothing")
    if not names:
        others = ", ".join(name for name in SYSTEMS if name not in DEFAULT)
        say(f"armdrive explain efficiency NAME ... counts others: {others}")


def _say_ways(title: str, ways: Sequence[Way]) -> None:
    kinds = [each.name for each in fields(Tally)]
    width = max(len(way.name) for way in ways)
    say(f"  {title:<{width}}  " + "  ".join(kinds))
    for way in ways:
        counts = (f"{getattr(way.tally, kind):>{len(kind)}}" for kind in kinds)
        say(f"  {way.name:<{width}}  {'  '.join(counts)}")
    for what in dict.fromkeys(way.what for way in ways):
        names = [way.name for way in ways if way.what == what]
        say(f"    {names[0] if len(names) == 1 else 'each branch'}: {what}")


def _view(counted: Efficiency) -> dict[str, Any]:
    return {
        "system": counted.system,
        "forward": [_way(way) for way in counted.forward],
        "inverse": [_way(way) for way in counted.inverse],
    }


def _way(way: Way) -> dict[str, Any]:
    return {"name": way.name, "what": way.what, **asdict(way.tally)}
