"""How fast a simulated TeachMover really turns: its own table from SP to half-steps a second.

Apart from the driver's table on purpose: where the two differ, the driver has to find out.
"""

from __future__ import annotations

import itertools

from armdrive.errors import BadRequest

RateTable = tuple[tuple[int, float], ...]
DEFAULT_RATES: RateTable = ((0, 30.0), (140, 150.0), (190, 250.0), (240, 470.0))
"""Unverified: the real table was never published. Straight lines between the points."""
FASTEST_ERROR = -0.95


def rate_hz(table: RateTable, speed: int, error: float) -> float:
    """Return half-steps a second; `error` 0.2 is an arm a fifth slower, -0.2 one that is faster.

    A speed beyond either end of the table has the rate of that end.
    """
    return _between(table, speed) / (1.0 + error)


def checked_error(error: float) -> float:
    """Return a speed error that an arm can have, or raise `BadRequest`."""
    if not FASTEST_ERROR <= error <= 100.0:
        raise BadRequest(
            f"a speed error must be from {FASTEST_ERROR} (much faster) to 100 (much slower), "
            f"not {error}"
        )
    return error


def _between(table: RateTable, speed: int) -> float:
    for (low, slow), (high, fast) in itertools.pairwise(table):
        if speed <= high:
            return slow + (fast - slow) * (max(speed, low) - low) / (high - low)
    return table[-1][1]
