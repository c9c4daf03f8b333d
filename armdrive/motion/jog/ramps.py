"""Ramps and braking of a jog: how quickly its rates change, and where they must be slower.

Rates are those of axes, in any unit a second, or shares of full speed. A jog is decided many times
a second, so nothing but floats and tuples is made, and nothing is checked.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt
from operator import add, sub

Rates = tuple[float, ...]


def ramped(now: Rates, wish: Rates, slope: float, time_s: float) -> tuple[Rates, Rates]:
    """Return the mean over a time, and what there is at its end, of rates on their way to a wish.

    They go straight there, all at once, the one with most to change by `slope` a second: so a
    line from rest is straight, and a change of direction passes through zero.
    """
    gaps = list(map(sub, wish, now))
    gap = max(*gaps, -min(gaps))
    if gap == 0.0 or slope == inf:
        return wish, wish
    share = slope * time_s / gap
    if share >= 1.0:
        return _along(wish, -0.5 / share, gaps), wish
    return _along(now, 0.5 * share, gaps), _along(now, share, gaps)


def _along(place: Rates, share: float, gaps: Sequence[float]) -> Rates:
    return tuple(map(add, place, map(share.__mul__, gaps)))


def braking_share(way_s: float, time_s: float, ramp_s: float) -> float:
    """Return the share of a speed that may be had for a time, so as to stop before a bound still.

    At that speed the way to the bound would last `way_s`, and losing the speed lasts `ramp_s`:
    v^2 = 2 a d at the end of the time. From rest to the bound it is never more than all of it.
    """
    if way_s <= 0.0:
        return 0.0
    share = 2.0 * way_s / (time_s + sqrt(time_s * time_s + 2.0 * ramp_s * way_s))
    return min(share, 1.0)


def share_of_limits(rates: Sequence[float], limits: Sequence[float]) -> float:
    """Return by how much rates have to be slowed so that none exceeds its limit: 1 for not at all.

    Slowing all of them alike keeps the tip on its line.
    """
    share = 1.0
    for rate, limit in zip(rates, limits, strict=True):
        if rate > limit or -rate > limit:
            share = min(share, limit / abs(rate))
    return share


def shares_to_stop(
    places: Sequence[float],
    rates: Sequence[float],
    spans: Sequence[tuple[float, float]],
    time_s: float,
    ramps_s: Sequence[float],
) -> list[float]:
    """Return by how much each rate has to be slowed to stop at the end of its span at the latest.

    `ramps_s` is how long each takes to lose its speed. The least of the shares, given to all of
    them, keeps the tip on its line.
    """
    shares = []
    for place, rate, (low, high), ramp_s in zip(places, rates, spans, ramps_s, strict=True):
        if rate == 0.0:
            shares.append(1.0)
            continue
        way_s = ((high if rate > 0.0 else low) - place) / rate
        shares.append(1.0 if way_s > time_s + ramp_s else braking_share(way_s, time_s, ramp_s))
    return shares
