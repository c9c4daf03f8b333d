"""The status of an arm as a person reads it, and the lines of `armdrive watch`."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import replace

import pytest

from armdrive import Arm
from armdrive.cli.look.status import INKS, Watched, next_step, status_lines
from armdrive.cli.presenter import Inked
from armdrive.status import State, Trust, rounded_up, status_view

PROGRAM = {"file": "stack.arm", "line": 3, "text": "move pick", "percent": 40.2, "left_s": 12.4}


@pytest.fixture(scope="module")
def view():
    """The status of a simulated arm that stands in its reference posture."""
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        return status_view(arm.status)


def plain(line) -> str:
    parts = (line,) if isinstance(line, str) else line
    return "".join(part.text if isinstance(part, Inked) else part for part in parts)


def page(view, **options) -> dict[str, str]:
    """Return the page of a status by its labels; joints by their names."""
    rows = [plain(line) for line in status_lines(view, Namespace(**options))]
    return {row[:10].strip() or row[10:].split("  ")[0]: row[10:] for row in rows[2:] if row}


def test_the_page_has_everything_with_its_unit(view):
    rows = page(view)
    assert rows["state"] == "standby"
    assert rows["position"] == "referenced: referenced in the reference posture"
    assert rows["tip"] == "x 127.0 mm, y 0.0 mm, z 0.0 mm, pitch -90.0°, roll 0.0°"
    assert rows["joints"].split() == ["base", "0.0°"]
    assert rows["wrist pitch"].split()[-1] == "10.7°"
    assert rows["gripper"] == "0.0 mm open"
    assert rows["inputs"] == "all off"
    assert "s and" in rows["stop"]
    assert rows["disable"].startswith("the arm sags")
    assert "`armdrive move`" in rows["next"]
    assert "-508" not in "".join(rows.values())  # motor steps are in the JSON alone


def test_a_bound_is_never_shown_smaller_than_it_is(view):
    bounds = {"stop_time_s": 0.651, "stop_distance_mm": 115.2}
    silent = {"silent_time_s": 0.701, "silent_distance_mm": 120.01}
    shown = page(view | bounds | silent)["stop"]
    assert shown == "takes at most 0.66 s and 116 mm; without this program, 0.71 s and 121 mm"


@pytest.mark.parametrize(
    ("bound", "digits", "shown"),
    [(0.28, 2, 0.28), (0.281, 2, 0.29), (115.01, 0, 116), (115.0, 0, 115), (0.0, 1, 0.0)],
)
def test_a_bound_is_rounded_up_and_a_round_one_stays(bound, digits, shown):
    assert rounded_up(bound, digits) == shown


def test_the_json_of_a_bound_is_never_smaller_either(view):
    with Arm.connect("sim:teachmover") as arm:
        status = replace(arm.status, stop_time_s=0.65101, stop_distance_mm=115.01)
    assert status_view(status)["stop_time_s"] == 0.652
    assert status_view(status)["stop_distance_mm"] == 115.1


def test_angles_and_names_stand_below_each_other(view):
    rows = [plain(line) for line in status_lines(view, Namespace())]
    angles = [row for row in rows if row.endswith("°") and "mm" not in row]
    assert len(angles) == 5
    assert len({len(row) for row in angles}) == 1


@pytest.mark.parametrize(
    ("changes", "label", "shown"),
    [
        ({"paused": True, "speed_override": 0.2}, "state", "standby, PAUSED, slowed to 20%"),
        ({"current": "off"}, "motors", "off"),
        ({"inputs": 5}, "inputs", "on: 1, 3"),
        ({"gripping": True}, "gripper", "0.0 mm open, gripping"),
        ({"underruns": 2}, "underruns", "2: the arm stood still in mid-motion"),
        ({"error": "no answer", "error_code": "E502"}, "error", "[E502] no answer"),
        ({"program": PROGRAM}, "program", "stack.arm, line 3: move pick (40 %, 12 s left)"),
        ({"current": "unknown"}, "motors", "on or off: the controller does not say"),
        (
            {"current": "unknown", "state": "disabled"},
            "motors",
            "not switched on by this program; they may hold the arm all the same",
        ),
        ({"program": {}}, "tip", "x 127.0 mm, y 0.0 mm, z 0.0 mm, pitch -90.0°, roll 0.0°"),
    ],
)
def test_what_is_unusual_is_shown(view, changes, label, shown):
    assert page(view | changes)[label] == shown


@pytest.mark.parametrize(
    ("trust", "code", "shown"),
    [
        ("restored", "E702", "restored: the record agrees"),
        ("suspect", "E703", "suspect: [E703] the record agrees"),
        ("referenced", "", "referenced: the record agrees"),
    ],
)
def test_a_position_has_a_code_only_if_something_is_wrong_with_it(view, trust, code, shown):
    changes = {"trust": trust, "trust_code": code, "trust_reason": "the record agrees"}
    assert page(view | changes)["position"] == shown


def test_an_arm_without_a_position_shows_none(view):
    rows = page(view | {"joints": None, "pose": None, "gripper_mm": None, "inputs": None})
    assert not rows.keys() & {"tip", "joints", "gripper", "inputs"}


@pytest.mark.parametrize(
    ("changes", "step"),
    [
        ({"state": "error-stop", "error_code": "E502"}, "then call `reset()`"),
        ({"state": "error-stop"}, "call `reset()`"),
        ({"trust": "suspect", "trust_code": "E703"}, "then call `home()`"),
        ({"trust": "suspect", "trust_code": "E716"}, "Look at the arm, then call `home()`"),
        ({"trust": "unknown", "trust_code": "E701"}, "Call `home()`."),
        ({"trust": "restored", "trust_code": "E702"}, "a simulated arm confirms its position"),
        (
            {"trust": "restored", "trust_code": "E702", "simulated": False},
            "asks first whether the arm still stands as it was left",
        ),
        ({"paused": True, "state": "moving"}, "`armdrive resume`"),
        ({"state": "moving"}, "`armdrive stop`"),
        ({"state": "disabled"}, "`armdrive enable`"),
        ({}, "`armdrive move`"),
    ],
)
def test_the_page_ends_with_what_to_do_next(view, changes, step):
    assert step in next_step(view | changes)


def test_the_next_command_names_the_arm_that_was_named(view):
    unknown = view | {"trust": "unknown", "trust_code": "E701"}
    assert page(unknown, sim="grbl")["next"] == "Run `armdrive home --sim grbl`."


def test_every_state_and_every_trust_has_its_colour():
    assert set(INKS) == {each.value for kind in (State, Trust) for each in kind}


def test_watching_repeats_nothing_and_shows_news_before_the_place(view):
    watched = Watched()
    assert len(list(watched.lines(view))) == 2  # headings, and where the arm is
    assert list(watched.lines(view | {"read_back_steps": [1] * 6})) == []
    moved = view | {"pose": view["pose"] | {"x_mm": 130.04}, "program": PROGRAM}
    program, place = map(plain, watched.lines(moved))
    assert program == f"{'':<10}stack.arm, line 3: move pick"
    assert place.split()[1:4] == ["standby", "referenced", "130.0"]
    further = moved | {"program": PROGRAM | {"percent": 50.0}}
    assert list(watched.lines(further)) == []
    (fault,) = watched.lines(further | {"error": "no answer", "error_code": "E502"})
    assert plain(fault).strip() == "[E502] no answer"
    lost = watched.lines(further | {"pose": None, "gripper_mm": None, "trust": "unknown"})
    assert [plain(line).split()[1:] for line in lost] == [["standby", "unknown", *"-----"]]
