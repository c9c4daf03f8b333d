"""The theory screen of the desk: the arm's present posture in the notes' own terms, read only."""

import math
from types import SimpleNamespace

import pytest
from desk_fake import MODEL, Clock, FakeArm, unknown_position
from desk_session import Session

from kinematics import Joints, system
from kinematics.chains.arm import ChainArm
from tui.desk import Desk
from tui.keys.keyboard import label
from tui.keys.table import THEORY_KEYS
from tui.startup import SCREENS
from tui.theory import LOOK_S, READ_ONLY, UNKNOWN_BUILD


async def opened(session):
    await session.keys("f6")
    await session.poll()  # in the room that it has once it is laid out
    assert session.desk.screens.current.place == "theory"


async def test_f6_shows_the_matrices_of_the_posture_and_moves_nothing():
    async with Session(size=(120, 40)) as session:
        await opened(session)
        assert READ_ONLY in session.text("theory-numbers")
        assert "base          20" in session.text("theory-page-0")
        first = "[ 0.940 0.000  0.342   0.000 ]"  # A1 with the base at 20 degrees
        assert first in session.text("theory-page-0") + session.text("theory-page-1")
        assert "manipulability" in session.text("theory-summary")
        assert "wrist pitch" in session.text("theory-page-0")
        pages = session.text("theory-page-0") + session.text("theory-page-1")
        assert not {"wrist_pitch", "wrist_roll"} & set(pages.split())
        assert session.text("footer").startswith("space STOP")
        assert f"{label('pagedown')} {label('pageup')} page" in session.text("footer")
        session.arm.calls.clear()
        own = (key for row in THEORY_KEYS for key in row.keys)
        await session.press("q", "w", "m", "enter", "G", "Z", "left", *own)
        assert session.arm.calls == []
        await session.press("space")
        assert session.arm.asked("stop")


async def test_the_numbers_follow_the_arm_but_no_oftener_than_need_be():
    async with Session(size=(120, 40)) as session:
        await opened(session)
        session.arm.set(joints=Joints.of(0.0, 60.0, 0.0, -60.0, 15.0))
        await session.poll()
        assert "SINGULAR" not in session.text("theory-summary")
        session.clock.now_s += LOOK_S * 1.01
        await session.poll()
        assert "SINGULAR" in session.text("theory-summary")
        assert "elbow is straight" in session.text("theory-summary")


async def test_an_unknown_posture_shows_no_numbers():
    async with Session(FakeArm(**unknown_position())) as session:
        await opened(session)
        assert session.text("theory-page-0") == ""
        assert session.text("theory-summary") == ""


async def test_an_arm_by_its_link_table_is_studied_too():
    arm = FakeArm()
    chain = ChainArm(system("puma").chain())
    joints = chain.joints_of([math.radians(one) for one in (30, 40, 60, -20, 45, 60)])
    arm.model = SimpleNamespace(
        arm=chain, guards=MODEL.guards, gripper_range_mm=MODEL.gripper_range_mm
    )
    arm.set(joints=joints, pose=chain.fk(joints))
    async with Session(arm, size=(120, 40)) as session:
        await opened(session)
        assert "theta6" in session.text("theory-page-0")


async def test_an_arm_of_another_build_says_that_nothing_is_known():
    arm = FakeArm()
    async with Session(arm) as session:
        session.arm.model = SimpleNamespace(arm=object())
        await session.press("f6")
        await session.pilot.pause()
        assert session.text("no-theory") == UNKNOWN_BUILD


@pytest.mark.parametrize("size", [(80, 24), (200, 60)])
def test_the_theory_screen(snap_compare, size):
    desk = Desk(FakeArm(), screens=SCREENS, braille=True, clock=Clock())
    assert snap_compare(desk, press=["f6"], terminal_size=size)
