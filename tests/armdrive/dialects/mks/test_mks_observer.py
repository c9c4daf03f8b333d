"""The observer of drives on a bus: what it concludes from orders, questions and readings alone.

A case is a text of one event a line: when, what, of which drive. The motion that a case is about
has begun at its start.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from armdrive.dialects.bus.intervals import MAX_DELAY_S, DriveFinding
from armdrive.dialects.bus.paths import Course
from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.observer import Observer
from armdrive.dialects.mks.paths import SteeredPath
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.steering import ContourCheck
from armdrive.tasks import MoveBy
from kinematics import Motors

CASES = sorted((Path(__file__).parent / "cases").glob("*.txt"))
SLOPE = 1_365_333.0


def observer(count: int = 2) -> Observer:
    nodes = range(1, count + 1)
    return Observer([MksDrive(node, f"motor {node}", MksSettings()) for node in nodes])


def ask(found: Observer, node: int, now_s: float) -> None:
    found.sent(found[node], now_s, owes=True)
    found[node].ledger.asked(now_s)


def tell(found: Observer, node: int, count: int, now_s: float) -> None:
    found.replied(found[node], now_s, settles=True)
    found[node].read(count, now_s)


def order(found: Observer, node: int, goal: int, speed: float, now_s: float) -> None:
    found[node].order(goal, speed, SLOPE, now_s)


def rest(found: Observer, node: int, count: int, now_s: float) -> None:
    ask(found, node, now_s)
    tell(found, node, count, now_s)
    found[node].rest_at(count, now_s)
    found[node].watch()


def happen(found: Observer, line: str) -> None:
    """Carry out one line of a case; raise `AssertionError` where it expects something else."""
    time, what, *words = line.split()
    now_s = float(time)
    match what, *words:
        case "rests", node, "at", count:
            rest(found, int(node), int(count), now_s)
        case "ordered", node, "to", goal, "at", speed:
            order(found, int(node), int(goal), float(speed), now_s)
        case "order-unanswered", node:
            found.sent(found[int(node)], now_s, owes=True)
        case "confirms", node:
            found[int(node)].confirmed_s = now_s
        case "asked", node:
            ask(found, int(node), now_s)
        case "reads", node, count:
            tell(found, int(node), int(count), now_s)
        case "reports", node:
            found.replied(found[int(node)], now_s, settles=False, asked=False)
        case "silent-for", seconds:
            assert found.silent_s(now_s) == pytest.approx(float(seconds)), line
        case "outage", word:
            assert found.in_outage(now_s) is (word == "yes"), line
        case "rereads", "nothing":
            assert not found.to_reread, line
        case "rereads", node:
            assert found.to_reread == (found[int(node)],), line
        case "expect", node, finding:
            assert found[int(node)].is_located
            assert found[int(node)].finding.value == finding, line
        case "ends", "nothing":
            assert found.judge() is None, line
        case "ends", node, finding:
            verdict = found.judge()
            assert verdict is not None, line
            assert (verdict.drive.node, verdict.finding.value) == (int(node), finding), line
        case _:
            raise ValueError(line)


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_a_case(path: Path) -> None:
    found = observer()
    lines = path.read_text().splitlines()
    assert lines[0].startswith("# ")
    for line in lines[1:]:
        happen(found, line)


def test_a_drive_that_homed_by_itself_begins_its_next_motion_where_it_stands() -> None:
    found = observer(1)
    rest(found, 1, 0, 0.0)
    drive = found[1]
    drive.moving = True
    for at_s, count in ((0.05, 359), (0.1, 700), (0.15, 0)):  # it sets its zero at its switch
        ask(found, 1, at_s)
        tell(found, 1, count, at_s)
    drive.moving = False
    assert drive.course.place > drive.bounds.rest
    drive.stand(0.2)
    assert drive.course.place == 0.0


def test_every_verdict_of_one_drive_has_a_case() -> None:
    words = " ".join(path.read_text() for path in CASES)
    assert all(each.value in words for each in DriveFinding if each is not DriveFinding.OFF_PATH)


@given(
    late_s=st.floats(0.0, MAX_DELAY_S - 0.01),
    slope=st.sampled_from([SLOPE, SLOPE / 10.0]),
    every_s=st.sampled_from([0.05, 0.1, 0.2, 0.4]),
    look_s=st.sampled_from([0.02, 0.04, 0.05, 0.1]),
    orders=st.lists(
        st.tuples(st.integers(-60_000, 60_000), st.integers(300, 90_000)), min_size=1, max_size=8
    ),
)
@example(0.09, SLOPE, 0.4, 0.1, [(18_693, 46_736), (0, 46_736)])
@example(0.086, SLOPE, 0.2, 0.02, [(0, 78_000), (-35_000, 78_000)] * 4)
def test_a_healthy_drive_however_late_within_the_bound_is_never_blamed(
    late_s: float, slope: float, every_s: float, look_s: float, orders: list[tuple[int, int]]
) -> None:
    found, shaft = observer(1), observer(1)[1].course
    rest(found, 1, 50_000, 0.0)
    shaft.rest_at(50_000, 0.0)
    moments = [(look_s * index, "look", 0, 0) for index in range(1, 5 + round(4.0 / look_s))]
    for index, (turn, speed) in enumerate(orders):
        moments.append((every_s * index, "order", 50_000 + turn, speed))
        moments.append((every_s * index + late_s, "obey", 50_000 + turn, speed))
    for at_s, what, goal, speed in sorted(moments):
        if what == "order":
            found[1].order(goal, speed, slope, at_s)
        elif what == "obey":
            shaft.order(goal, speed, slope, at_s)
            found[1].confirmed_s = at_s
        else:
            shaft.advance(at_s)
            ask(found, 1, at_s)
            tell(found, 1, round(shaft.place), at_s)
            assert found.judge() is None


LEARNT_S = 0.8
"""By then a drive has replied often enough to tell how long it takes."""


@pytest.mark.parametrize("wait_s", [0.004, 0.03, 0.07])
def test_a_drive_on_a_slow_link_is_not_taken_to_have_been_away(wait_s: float) -> None:
    found, replies, asked = observer(2), list[tuple[float, int]](), 0
    for node in (1, 2):
        rest(found, node, 0, 0.0)
        order(found, node, 20_000, 2000, 0.0)
    for moment in range(1, 2000):
        now_s = 0.001 * moment
        polled = [node for node in (1, 2) if moment % 100 == 50 * node % 100]
        for node in (*polled, *(each.node for each in found.to_retry(now_s))):
            ask(found, node, now_s)
            replies.append((now_s + wait_s, node))
            asked += 1
        for due in [each for each in replies if each[0] <= now_s]:
            replies.remove(due)
            tell(found, due[1], round(2000 * max(due[0] - 0.02, 0.0)), now_s)
            assert now_s < LEARNT_S or not found[due[1]].absence.suspected
            assert found.judge() is None
    assert asked < 80  # retries wait as well


def leading(*counts: int) -> ContourCheck:
    """Return drives that were looked at a while into a path that takes them along together."""
    found, path = observer(len(counts)), SteeredPath(Motors([0] * len(counts)))
    for _ in range(20):
        path.append(MoveBy(Motors([3000] * len(counts)), 30_000.0))
    for node, count in enumerate(counts, 1):
        rest(found, node, count, 0.0)
    return ContourCheck(found.drives, path)


def test_drives_that_are_late_together_are_on_their_way() -> None:
    contour = leading(12_000, 11_500)
    assert all(contour.compare(0.8, 0.04, 0.8) is None for _ in range(5))


def test_a_drive_that_lags_alone_is_off_its_path_at_the_second_look() -> None:
    contour = leading(24_000, 9_000)
    assert contour.compare(0.8, 0.04, 0.8) is None
    verdict = contour.compare(0.9, 0.04, 0.9)
    assert verdict is not None
    assert (verdict.drive.node, verdict.finding) == (2, DriveFinding.OFF_PATH)


@given(
    st.lists(st.tuples(st.integers(-2000, 2000), st.integers(1, 3000)), min_size=1, max_size=6),
    st.integers(-3000, 3000),
    st.floats(0.0, 1.0),
)
def test_how_far_a_place_is_off_the_course_is_its_distance_from_the_hull(orders, place, from_s):
    course, now_s = Course(), 0.0
    course.rest_at(0.0, now_s)
    for goal, speed in orders:
        now_s += 0.07
        course.order(goal, speed, SLOPE, now_s)
    off, hull = course.off(place, from_s), course.hull(from_s)
    assert abs(off) == hull.beyond(place)
    assert (off < 0.0) == (place < hull.low)
