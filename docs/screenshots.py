"""Take the pictures of the documentation from the running program."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path

from armdrive import Arm, Pose
from tui.desk import Desk

HERE = Path(__file__).parent
SIZE = (120, 38)
FROM_ELSEWHERE = re.compile(r",\s*url\([^)]*\) format\([^)]*\)")
"""Fonts that the picture would fetch from the network; the reader's own monospace one will do."""


async def desk(arm: Arm) -> None:
    """Jog the simulated arm a little in the desk, and take its picture."""
    app = Desk(arm, braille=True)
    async with app.run_test(size=SIZE) as pilot:
        await pilot.press("enter", "m")
        for key in ("e", "e", "w"):
            await pilot.press(key)
            await pilot.pause(0.4)
            arm.sleep(1.0)
        app.poll()
        await pilot.pause()
        picture = FROM_ELSEWHERE.sub("", app.export_screenshot(title="armdrive jog"))
        (HERE / "desk.svg").write_text(picture, encoding="utf-8")


def main() -> None:
    """Take all pictures."""
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        arm.move_to(Pose.of(x_mm=260, y_mm=90, z_mm=110, pitch_deg=-60))
        arm.gripper.open(40)
        asyncio.run(desk(arm))


if __name__ == "__main__":
    main()
