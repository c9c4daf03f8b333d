"""Snapshots of the desk: small and large, and in plain ASCII; and texts that must fit."""

import pytest
from desk_fake import END, MODEL, Clock, FakeArm, FakeHolder, unknown_position
from desk_planner import at_rest
from desk_session import Session
from waiting import until_seen

from armdrive.status import status_view
from tui.axes import AxisTable, bar
from tui.desk import Desk
from tui.startup import SCREENS
from tui.watch import Watching

SIZES = [(80, 24), (120, 40), (200, 60)]


@pytest.mark.parametrize("size", SIZES)
def test_the_jog_screen(snap_compare, size):
    desk = Desk(FakeArm(), screens=SCREENS, braille=True, clock=Clock())
    assert snap_compare(desk, terminal_size=size)


def test_the_jog_screen_in_plain_ascii_with_an_unknown_position(snap_compare):
    desk = Desk(FakeArm(**unknown_position()), screens=SCREENS, braille=False, clock=Clock())
    assert snap_compare(desk, press=["enter", "m"], terminal_size=(80, 24))


def test_the_watching_screen(snap_compare):
    holder = FakeHolder(status_view(FakeArm().status))
    app = Watching("sim", MODEL, holder, braille=True)

    async def heard(pilot):
        await until_seen(lambda: app.view, pilot.pause)

    try:
        assert snap_compare(app, terminal_size=(120, 40), run_before=heard)
    finally:
        holder.said.put(END)


def test_the_first_run(snap_compare, tmp_path):
    desk = Desk(
        FakeArm(), screens=SCREENS, braille=True, clock=Clock(), memory=tmp_path / "none.json"
    )
    assert snap_compare(desk, terminal_size=(80, 24), run_before=at_rest)


DIALOGS = {"help": ("question_mark",), "question": ("H",), "palette": ("ctrl+p", "r", "e", "f")}


@pytest.mark.parametrize(("name", "size"), zip(DIALOGS, SIZES, strict=True))
def test_the_dialogs(snap_compare, name, size):
    desk = Desk(FakeArm(simulated=False), screens=SCREENS, braille=True, clock=Clock())

    async def opened(pilot):
        await at_rest(pilot)
        for key in DIALOGS[name]:
            await pilot.press(key)
            await at_rest(pilot)

    assert snap_compare(desk, terminal_size=size, run_before=opened)


@pytest.mark.parametrize(
    ("value", "shown"),
    [(None, "━━━━━"), (0, "●━━━━"), (10, "━━━━●"), (-1, "<━━━━"), (11, "━━━━>")],
)
def test_a_bar_shows_the_place_between_the_limits_and_beyond(value, shown):
    assert bar(value, 0.0, 10.0, 5) == shown


@pytest.mark.parametrize("more", [{}, unknown_position()], ids=["known", "unknown"])
async def test_every_axis_has_a_row_of_its_own_on_the_smallest_terminal(more):
    async with Session(FakeArm(**more)) as session:
        for mode in ("joints", "Cartesian"):
            for name, axes in (("tip", 5), ("joints", 5), ("gripper", 1)):
                table = session.desk.screens.current.query_one(f"#{name}", AxisTable)
                lines = table.shown.splitlines()[:axes]
                assert len(lines) == axes, mode
                assert max(len(line.rstrip()) for line in lines) <= table.content_size.width, mode
                assert table.region.bottom <= 22, f"the panel is cut off: {mode}"
            await session.press("m")
