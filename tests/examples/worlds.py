"""What has to be physically there after each example, and what must never have been on the way."""

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise

from armdrive.sim.world.table import Point, TableBlock

from .on_arms import Ran
from .watching import beside_mm

NEAR_MM = 1.5
"""A block stands where it belongs: rounding to steps, twice, and the fingers' bending it about."""

PAPER_MM = 1.0
"""A pen's point that is no higher draws: it gives a little, and the paper lies on something."""

PRESSED_MM = 0.7
"""So far into the paper a pen may be pressed: rounding to steps, of arms that take turns."""

BESIDE_MM = 1.0
"""So far a line may be from where it belongs."""


def incidents(ran: Ran) -> list[str]:
    """Return what was touched or knocked that should not have been."""
    return [each.sentence for each in ran.watch.world.incidents]


def _misplaced(blocks: Mapping[str, TableBlock], belong: Mapping[str, Point]) -> Iterable[str]:
    for name, place in belong.items():
        away_mm = math.dist(blocks[name].place, place)
        if away_mm > NEAR_MM:
            yield f"block {name} is {away_mm:.1f} mm from where it belongs"


def tower(ran: Ran, count: int) -> list[str]:
    """Look for a tower of so many blocks, the first at the bottom."""
    belong = {name: (240.0, -100.0, 25.0 * level) for level, name in enumerate("ABCD"[:count])}
    wrong = list(_misplaced(ran.watch.world.scene.blocks, belong))
    said = f"a tower of {count} blocks, {25 * count} mm high"
    return wrong if said in ran.said else [*wrong, f"it did not say: {said}"]


def hanoi(ran: Ran, discs: int) -> list[str]:
    """Look for the tower at the right, no disc ever on a smaller one, and no move too many."""
    names = [f"disc{number}" for number in range(discs, 0, -1)]
    belong = {name: (250.0, -90.0, 20.0 * level) for level, name in enumerate(names)}
    wrong = list(_misplaced(ran.watch.world.scene.blocks, belong))
    for blocks in ran.watch.arrangements:
        wrong += _on_smaller(blocks)
    moves = len(ran.watch.arrangements) - 1
    if moves != 2**discs - 1:
        wrong.append(f"{moves} discs were put down")
    return wrong


def _on_smaller(blocks: Mapping[str, TableBlock]) -> Iterable[str]:
    for upper in blocks.values():
        for lower in blocks.values():
            on_it = upper.shares_ground(lower) and upper.z_mm > lower.z_mm
            if on_it and upper.width_mm >= lower.width_mm:
                yield f"{upper.name} lay on {lower.name}"
        if min(abs(upper.y_mm - place) for place in (90.0, 0.0, -90.0)) > NEAR_MM:
            yield f"{upper.name} lay between the places"


def sorted_rows(ran: Ran, rows: Mapping[str, Point]) -> list[str]:
    """Look for every block in its row."""
    return list(_misplaced(ran.watch.world.scene.blocks, rows))


def circle(ran: Ran, radius_mm: float) -> list[str]:
    """Look for one closed circle."""
    strokes = ran.watch.strokes(PAPER_MM)
    if len(strokes) != 1:
        return [f"{len(strokes)} strokes instead of a circle"]
    wrong = list(_pressed(strokes))
    beside = max(abs(math.hypot(x - 250.0, y) - radius_mm) for x, y, _ in strokes[0])
    if beside > BESIDE_MM:
        wrong.append(f"the pen was {beside:.2f} mm beside the circle")
    angles = sorted(math.atan2(y, x - 250.0) for x, y, _ in strokes[0])
    gaps = [b - a for a, b in pairwise(angles)]
    around = max(*gaps, angles[0] + math.tau - angles[-1])
    if around > math.radians(15.0):
        wrong.append(f"the circle has a gap of {math.degrees(around):.0f} deg")
    return wrong


def wanted_strokes(ran: Ran, word: str) -> list[list[Point]]:
    """Return where the strokes of a word belong, taking the table of letters alone from it."""
    found = []
    for place, letter in enumerate(word):
        for stroke in ran.names["LETTERS"][letter]:
            squares = [(6 * place + int(at[0]), int(at[1])) for at in stroke.split()]
            found.append([(230.0 + 5.0 * up, 80.0 - 5.0 * right, 0.0) for right, up in squares])
    return found


def letters(ran: Ran, word: str) -> list[str]:
    """Look for every stroke where it belongs, from corner to corner, and for nothing else."""
    drawn, wanted = ran.watch.strokes(PAPER_MM), wanted_strokes(ran, word)
    if len(drawn) != len(wanted):
        return [f"{len(drawn)} strokes instead of {len(wanted)}"]
    wrong = list(_pressed(drawn))
    for points, corners in zip(drawn, wanted, strict=True):
        if (beside := max(beside_mm(point, corners) for point in points)) > BESIDE_MM:
            wrong.append(f"the pen was {beside:.2f} mm beside a stroke")
        wrong += [f"no stroke came to {each[:2]}" for each in _missed(points, corners)]
    return wrong


def _missed(points: list[Point], corners: list[Point]) -> list[Point]:
    return [
        corner
        for corner in corners
        if min(math.dist(point[:2], corner[:2]) for point in points) > BESIDE_MM
    ]


def _pressed(strokes: list[list[Point]]) -> Iterable[str]:
    deepest_mm = -min(z for stroke in strokes for _, _, z in stroke)
    if deepest_mm > PRESSED_MM:
        yield f"the pen was pressed {deepest_mm:.2f} mm into the paper"
