"""Snapshots of the desk: small and large, and in plain ASCII; and texts that must fit."""

import pytest
from amounts import THOROUGH, every_row
from desk_fake import FakeArm, LoggedArm, unknown_position
from desk_session import Session
from waiting import until_seen

from armdrive.status import State
from tui.axes import AxisTable, bar_parts

# docs/pictures has the other screens, each at 120x40.


def test_the_jog_screen_in_plain_ascii_with_an_unknown_position(snap_compare):
    desk = Session(FakeArm(**unknown_position()), braille=False).desk
    assert snap_compare(desk, press=["enter", "m"], terminal_size=(80, 24))


@every_row(
    "value, shown",
    [(None, "━━━━━"), (0, "●━━━━"), (10, "━━━━●"), (-1, "<━━━━"), (11, "━━━━>")],
)
def test_a_bar_shows_the_place_between_the_limits_and_beyond(value, shown):
    assert "".join(bar_parts(value, 0.0, 10.0, 5)) == shown


LONG = {
    "silent_time_s": 1.25,
    "silent_distance_mm": 120.0,
    "outputs": 0xA5,
    "inputs": 0x5A,
    "last_answer": "registers 39 867 874 128 128 582, inputs 0, the end",
}


ALL_PANELS = ("tip", "joints", "gripper", "near", "details")
DETAILED = [
    # a size, keys, the panels that the details leave room for
    ((80, 24), "D", ("joints", "gripper", "details")),
    ((80, 24), "m", ("tip", "gripper", "details")),
    ((80, 24), "D m", ("tip", "joints", "gripper", "near")),
    ((80, 39), "D", ALL_PANELS),
    ((80, 14), "D", ("joints", "gripper")),
    ((80, 14), "m", ("tip", "gripper")),
    ((80, 9), "m", ("joints", "gripper")),
    ((120, 40), "D", ALL_PANELS),
]


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"] if THOROUGH else ["grbl"])
async def test_details_are_shown_on_asking_and_no_line_is_cut(dialect):
    size = (80, 24)
    async with Session(FakeArm(**LONG, dialect=dialect), size=size) as session:
        for here, keys, panels in DETAILED:
            if here != size:
                size = here
                await session.resize(*size)
            await session.keys(keys)
            for name in ALL_PANELS:
                shown = " ".join(session.text(name).split())
                painted = session.screen.query_one(f"#{name}").display
                assert painted == (name in panels), (size, keys, name)
                if painted and size[1] >= (40 if name == "near" else 24):  # smaller ones cut it
                    assert session.painted_words(name) == shown, (size, keys, name)
            if "details" in panels:
                assert "sent @STEP" in session.text("details")
                assert session.text("details").endswith("the end")


async def test_the_tiniest_terminal_still_offers_the_stop_and_the_keys():
    async with Session(LoggedArm(), size=(30, 8)) as session:
        for more in ({}, {"state": State.ERROR_STOP, "error": "the elbow slipped " * 20}):
            session.arm.set(**more)
            for key in ("f2", "f3", "f7"):
                await session.keys(key)
                assert "STOP" in session.painted[2], key
                assert session.painted[-1].split()[:2] == ["space", "STOP"], key
                assert "? help" in session.painted[-1], key


async def test_every_axis_has_a_row_on_the_smallest_terminal_and_the_rest_is_a_key_away():
    async with Session(FakeArm(**LONG)) as session:
        shown = lambda: session.screen.query_one("#panels").scroll_offset.y  # noqa: E731
        await session.follow(
            [("f2", {"messages": "(^d: more)"}), ("ctrl+d", {"not_messages": "more)"})]
        )
        assert shown() > 0
        await session.follow([("ctrl+u", {"messages": "(^d: more)"})])
        assert shown() == 0
        for more, mode in (({}, "joints"), ({}, "tip"), (unknown_position(), "joints")):
            session.arm.set(**more)
            await session.settle()
            for name, axes in (("tip", 5), ("joints", 5), ("gripper", 1)):
                table = session.desk.current.query_one(f"#{name}", AxisTable)
                lines = table.shown.splitlines()[:axes]
                assert len(lines) == axes, mode
                assert max(len(line.rstrip()) for line in lines) <= table.content_size.width, mode
                assert table.region.bottom <= 22, f"the panel is cut off: {mode}"
            await session.press("m")
        await session.keys("question_mark down pagedown")
        dialog = session.desk.screen.query_one(".dialog")
        await until_seen(lambda: dialog.scroll_offset.y > 0, session.pilot.pause)
        await session.keys("question_mark")
        await session.resize(120, 40)
        await session.follow([("ctrl+d", {"messages": "nothing is out of view here"})])
