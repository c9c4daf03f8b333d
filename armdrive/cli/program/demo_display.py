"""The demonstration drawn in a terminal: the script runs in a thread, the drawing follows it."""

from __future__ import annotations

import os
import shutil
import sys
import threading

from armdrive.arm import Arm
from armdrive.cli.presenter import draw_over, put
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.programs.demo import JOBS, CarriedBlock, perform
from armdrive.render.canvas import can_braille
from armdrive.render.side_view import ArmScene, DrawnBox, side_view, top_view
from armdrive.sim.simulated_arm import SimulatedArm

FRAME_S = 1.0 / 15.0
MOST_COLUMNS, MOST_ROWS = 110, 22
CLEAR_LINE, CURSOR_OFF, CURSOR_ON = "\x1b[K", "\x1b[?25l", "\x1b[?25h"


class _Performance(threading.Thread):
    """The script in a thread of its own, with what it last said."""

    def __init__(self, arm: Arm) -> None:
        super().__init__(name="demo", daemon=True)
        self.arm = arm
        self.said = ""
        self.carried: list[CarriedBlock] = []
        self.error: Exception | None = None

    def run(self) -> None:
        """Perform, and keep what went wrong for the thread that draws."""
        try:
            self.carried = perform(self.arm, JOBS, self._hear)
        except Exception as error:
            self.error = error

    def _hear(self, text: str) -> None:
        self.said = text


def show(
    config: ArmConfig, twin: SimulatedArm, *, pace: float, braille: bool
) -> tuple[list[CarriedBlock], float]:
    """Perform at `pace` times real time, drawn; return what was carried, and the arm's time."""
    braille = braille and can_braille(sys.stdout.encoding, os.environ)
    with Arm(connect_simulated(config, twin=twin, pace=pace)) as arm:
        performance = _Performance(arm)
        performance.start()
        lines = 0
        put("", control=CURSOR_OFF)
        try:
            while performance.is_alive():
                lines = _draw(arm, twin, performance.said, pace, braille, lines)
                performance.join(FRAME_S)
            lines = _draw(arm, twin, performance.said, pace, braille, lines)
        finally:
            put("", control=CURSOR_ON)
        if performance.error is not None:
            raise performance.error
        return performance.carried, arm.pace.now_s()


def _draw(
    arm: Arm, twin: SimulatedArm, said: str, pace: float, braille: bool, last_lines: int
) -> int:
    """Draw over the last picture; return how many lines there are now."""
    columns, rows = shutil.get_terminal_size()
    width, height = min(columns - 1, MOST_COLUMNS), max(min(rows - 4, MOST_ROWS), 4)
    with arm.pace.lock:
        scene = _scene(twin)
    left = width * 3 // 5
    side = side_view(scene, left, height, braille)
    top = top_view(scene, width - left - 1, height, braille)
    picture = [f"{a:<{left}} {b}" for a, b in zip(side, top, strict=True)]
    status = arm.status
    picture.append(f"{status.which}, shown {pace:g} times faster"[:width])
    if not braille:
        said = said.replace("°", " deg")
    picture.append(f"{arm.pace.now_s():6.1f} s  {said}"[:width])
    back = f"\x1b[{last_lines}F" if last_lines else ""
    draw_over(picture, control=back, line_end=f"{CLEAR_LINE}\n")
    return len(picture)


def _scene(twin: SimulatedArm) -> ArmScene:
    """Return the physical world as there is to draw."""
    world = twin.world
    geometry = world.body.arm
    return ArmScene(
        points=geometry.points(world.joints),
        opening_mm=world.opening_mm,
        base_rad=world.joints[0],
        reach_mm=geometry.levers_mm(None)[0],
        blocks=tuple(
            DrawnBox(b.name, b.x_mm, b.y_mm, b.z_mm, b.width_mm, b.height_mm)
            for b in world.scene.blocks.values()
        ),
    )
