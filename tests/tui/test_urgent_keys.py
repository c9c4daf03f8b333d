"""The stop acts in the thread that reads the keys; what was typed before it begins nothing anew."""

from __future__ import annotations

import pytest
from desk_session import Session
from textual import events
from textual.drivers.headless_driver import HeadlessDriver

from tui.keys.presses import UrgentKeys
from tui.terminal import lasting_driver

SPACE = ("space", " ")


def read(session, key, character):
    """Have the driver read a key, as its thread does; the app takes it later."""
    # a Pilot puts its own driver in its place
    driver = lasting_driver(HeadlessDriver)(session.desk)
    driver.process_message(events.Key(key, character))


async def test_the_stop_reaches_the_arm_before_the_app_takes_its_key():
    async with Session() as session:
        session.arm.calls.clear()
        read(session, *SPACE)
        assert session.arm.calls == [("stop",)]


async def test_the_app_does_the_rest_of_the_stop_when_it_takes_the_key():
    async with Session() as session:
        await session.arm_keys()
        read(session, *SPACE)
        await session.pilot.pause()
        assert not session.desk.screens.current.armed
        assert "STOP" in session.desk.message


async def test_jog_keys_that_a_stop_has_overtaken_move_nothing():
    async with Session() as session:
        await session.arm_keys()
        session.arm.calls.clear()
        for _ in range(3):
            read(session, "w", "w")
        read(session, *SPACE)
        await session.pilot.pause()
        assert session.arm.asked("stop")
        assert not {"nudge", "hold"} & {call[0] for call in session.arm.calls}


async def test_keys_behind_a_stop_count_again():
    async with Session() as session:
        read(session, *SPACE)
        await session.pilot.pause()
        await session.arm_keys()
        read(session, "w", "w")
        await session.pilot.pause()
        assert session.arm.calls[-1][0] == "nudge"


@pytest.mark.parametrize("lost", [0, 1])
def test_a_stop_that_never_came_is_forgotten_with_the_next(lost):
    urgent, stopped = UrgentKeys(), []
    keys = [events.Key(*SPACE) for _ in range(2)]
    for key in keys:
        urgent.read(key, {"space": lambda: stopped.append(1)})
    assert len(stopped) == 2
    assert urgent.overtook(events.Key("w", "w"))
    for key in keys[lost:]:
        assert not urgent.overtook(key)
    assert not urgent.overtook(events.Key("w", "w"))


def test_other_keys_do_nothing_before_the_app_takes_them():
    urgent, stopped = UrgentKeys(), []
    urgent.read(events.Key("w", "w"), {"space": lambda: stopped.append(1)})
    assert not stopped
    assert not urgent.overtook(events.Key("q", "q"))
