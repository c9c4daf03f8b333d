"""Take the pictures of the documentation from the running program: `python docs/screenshots.py`.

Arms are simulated, their time and the desk's pass only as it is said here, and nothing of this
computer is in a picture: taking them again changes a file only where the program has changed.
"""

from __future__ import annotations

import asyncio
import math
import os
import re
import sys
import tempfile
import threading
from collections.abc import Callable, Coroutine, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

from textual.app import App
from textual.pilot import Pilot

from armdrive import Arm, Pose
from armdrive.cli.chosen_arm import connect_remembered
from armdrive.connect.target import find
from armdrive.motion.dead_man import GATE_S
from armdrive.status import status_view
from armdrive.storage.points import Point
from kinematics import Joints
from kinematics.textbook.study import subject_of_system
from kinematics.textbook.systems import system
from tui.app import KeyApp
from tui.desk import Desk
from tui.model_desk import ModelDesk
from tui.program import ProgramScreen
from tui.watch import Watching

FOLDER = Path(__file__).parent / "pictures"
EXAMPLES = Path(__file__).parents[1] / "examples"
SIZE = (120, 40)
ARM = "sim:teachmover"
FROM_ELSEWHERE = re.compile(r",\s*url\([^)]*\) format\([^)]*\)")
"""Fonts that the picture would fetch from the network; the reader's own monospace one will do."""

LONG_NAME = re.compile(r"terminal-\d+")
"""Stands before every name in a picture, which it makes half as long again; "t" does as well."""

START = Pose.of(x_mm=260, y_mm=90, z_mm=110, pitch_deg=-60)
KEY_S = 2.5
"""A key comes so long after the one before: no jog key is taken for one that is held."""

TURNS = 3
"""So often a screen is given time for what it works out in threads, one thing after the other."""

POINTS = {
    "above": Point(Joints.of(0.0, 50.3, -90.2, -50.1, 0.0), 40.0, "above the block"),
    "pick": Point(Joints.of(0.0, 36.2, -89.4, -36.8, 0.0), 40.0, "fingers round the block"),
    "wait": Point(Joints.of(30.0, 60.0, -80.0, -60.0, 0.0), None, "out of the way"),
}


class Clock:
    """Time that passes only when it is told to."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        """Return the time, s."""
        return self.now_s


async def settle(pilot: Pilot[Any]) -> None:
    """Have an app work out all that it wants to show, and show it."""
    for _ in range(TURNS):
        await pilot.pause()
        await pilot.app.workers.wait_for_complete()
        poll = getattr(pilot.app, "poll", None)
        if poll is not None:
            poll()
    await pilot.pause()


async def keyed(app: App[Any], keys: tuple[str, ...], then: Callable[[], object]) -> str:
    """Press keys, each when the one before has had its effect, and return the picture as SVG."""
    async with app.run_test(size=SIZE) as pilot:
        await settle(pilot)
        for key in keys:
            await pilot.press(key)
            await settle(pilot)
            then()
        await settle(pilot)
        return picture_of(app)


def picture_of(app: App[Any]) -> str:
    """Return what an app shows as SVG."""
    picture = app.export_screenshot(title="armdrive")
    return LONG_NAME.sub("t", FROM_ELSEWHERE.sub("", picture))


def begin(arm: Arm) -> None:
    """Reference an arm and have it leave the reference."""
    arm.home()
    arm.move_to(START)
    arm.gripper.open(40)


@contextmanager
def standing() -> Iterator[Arm]:
    """Lend a simulated arm that is referenced, has moved, and has been taught points."""
    with Arm.connect(ARM) as arm:
        begin(arm)
        for name, point in POINTS.items():
            arm.points[name] = point
        yield arm


async def desk(*keys: str, memory: Path | None = None) -> str:
    """Picture the desk of an arm that stands, after these keys."""
    with standing() as arm:
        return await of(arm, keys, memory)


def take_every_key(app: KeyApp) -> None:
    """Let keys follow each other at once, however busy this computer is."""
    fresh = app.input.fresh
    fresh.suspended_s = fresh.starved_s = math.inf
    fresh.person_s = 0.0


async def of(arm: Arm, keys: tuple[str, ...], memory: Path | None = None) -> str:
    """Picture the desk of this arm, after these keys."""
    clock = Clock()

    def pass_by() -> None:
        clock.now_s += GATE_S
        if app.hand is not None:
            app.hand.tick()
        clock.now_s += KEY_S
        arm.sleep(KEY_S)

    app = Desk(arm, braille=True, clock=clock, memory=memory)
    take_every_key(app)
    app.programs = Path(os.environ["ARMDRIVE_HOME"])  # what is taught is written there
    return await keyed(app, keys, pass_by)


async def first_run() -> str:
    """Picture what a desk shows that remembers nothing."""
    return await desk(memory=Path(os.environ["ARMDRIVE_HOME"]) / "no-such-desk.json")


async def question() -> str:
    """Picture the question whether an arm still stands where the last program left it."""
    config = find(ARM).config
    with connect_remembered(config) as arm:
        begin(arm)
    with connect_remembered(config) as arm:
        return await of(arm, ("C",))


async def waiting(app: Desk, pilot: Pilot[Any], after: str = "") -> str:
    """Let a program go on until it waits for a person with something new; return with what."""
    run = cast("ProgramScreen", app.current).run
    while run.asks in ("", after):
        app.poll()
        await pilot.pause()
    for _ in range(TURNS):
        app.poll()
        await pilot.pause()
    return run.asks


async def program() -> str:
    """Picture a program that is stepped through: it waits before a motion."""
    with standing() as arm:
        clock = Clock()
        app = Desk(arm, braille=True, clock=clock)
        app.programs = EXAMPLES
        take_every_key(app)
        async with app.run_test(size=SIZE) as pilot:
            for key in ("f8", "down", "down", "s", "r", "enter", "enter"):
                await pilot.press(key)
                await settle(pilot)
                clock.now_s += KEY_S
            first = await waiting(app, pilot)
            await pilot.press("right")  # the first line that moves only references the arm
            clock.now_s += KEY_S
            await waiting(app, pilot, after=first)
            picture = picture_of(app)
            app.action_stop_arm()
            await settle(pilot)
            return picture


async def model(name: str, *keys: str) -> str:
    """Picture a model without an arm."""
    app = ModelDesk(subject_of_system(system(name)), braille=True)
    take_every_key(app)
    return await keyed(app, keys, lambda: None)


async def watch() -> str:
    """Picture an arm that another program drives."""
    with standing() as arm:
        ended = threading.Event()

        def views() -> Iterator[Mapping[str, Any]]:
            yield status_view(arm.status)
            ended.wait()

        app = Watching(arm.status.arm, arm.model, views(), lambda *_: {}, braille=True)
        try:
            return await keyed(app, (), lambda: None)
        finally:
            ended.set()


def _typed(text: str) -> tuple[str, ...]:
    names = {"-": "minus", ".": "full_stop"}
    return tuple(names.get(each, each) for each in text)


PICTURES: Mapping[str, Callable[[], Coroutine[Any, Any, str]]] = MappingProxyType(
    {
        "jog": partial(desk, "enter", "m", "e", "e", "w"),
        "move": partial(desk, "f3", *_typed("220"), "down", *_typed("-120"), "down", *_typed("80")),
        "points": partial(desk, "f4", "a", "enter", "l", "down", "a", "enter", "g", "enter"),
        "setup": partial(desk, "f5", "down", "down", "down", "enter", "t", "t"),
        "log": partial(desk, "f7"),
        "program": program,
        "watch": watch,
        "model": partial(model, "puma", "q", "q", "w"),
        "first-run": first_run,
        "help": partial(desk, "question_mark"),
        "palette": partial(desk, "ctrl+p", *_typed("ref")),
        "question": question,
    }
)
"""Every picture by the name of its file, and how it comes about."""


@contextmanager
def nobodys_settings() -> Iterator[None]:
    """Have no file of this computer's user read or written."""
    before = dict(os.environ)
    with tempfile.TemporaryDirectory() as home:
        os.environ["ARMDRIVE_HOME"] = home
        os.environ.pop("NO_COLOR", None)
        try:
            yield
        finally:
            os.environ.clear()
            os.environ.update(before)


def take(name: str) -> str:
    """Take a picture, and return it as SVG."""
    with nobodys_settings():
        return asyncio.run(PICTURES[name]())


def main(names: Sequence[str]) -> None:
    """Take these pictures again, or all if none is named."""
    FOLDER.mkdir(exist_ok=True)
    for name in names or tuple(PICTURES):
        (FOLDER / f"{name}.svg").write_text(take(name), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
