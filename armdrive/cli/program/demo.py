"""The demonstration, drawn in a terminal: the program runs in a thread, while this one draws."""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait

from armdrive.arm import Arm
from armdrive.cli.presenter import Result, as_json, put, show, tell
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.programs.demonstration import JOBS, CarriedBlock, blocks_of, misplaced, perform
from armdrive.registry import DEFAULT, simulate
from armdrive.render.canvas import draws_braille
from armdrive.render.scene import Moment, PostureDrawing
from armdrive.render.sketch import MOST_COLUMNS
from armdrive.sim.simulated_arm import SimulatedArm
from kinematics.guards.shapes import Box
from kinematics.text import mm_text

# Drawing it in a terminal.

FRAME_S = 1.0 / 15.0
MOST_ROWS = 22  # the messages below the picture stay in view
CURSOR_OFF, CURSOR_ON = "\x1b[?25l", "\x1b[?25h"


def draw(
    config: ArmConfig, twin: SimulatedArm, *, pace: float, ascii_only: bool
) -> tuple[list[CarriedBlock], float]:
    """Perform at `pace` times real time, drawn; return what was carried, and the arm's time."""
    messages, lines = [""], 0
    drawing = PostureDrawing(config.model, braille=draws_braille(ascii_only=ascii_only))
    # on Ctrl-C the arm is closed first, which ends the performance
    with ThreadPoolExecutor(1) as pool, Arm(connect_simulated(config, twin=twin, pace=pace)) as arm:
        performance = pool.submit(perform, arm, JOBS, messages.append)
        put("", control=CURSOR_OFF)
        try:
            while not performance.done():
                lines = _draw(arm, twin, messages[-1], pace, drawing, lines)
                wait((performance,), FRAME_S)
            _draw(arm, twin, messages[-1], pace, drawing, lines)
        finally:
            put("", control=CURSOR_ON)
        return performance.result(), arm.parts.pace.now_s()


def _draw(
    arm: Arm,
    twin: SimulatedArm,
    message: str,
    pace: float,
    drawing: PostureDrawing,
    last_lines: int,
) -> int:
    """Draw over the last picture; return how many lines there are now."""
    columns, rows = shutil.get_terminal_size()
    width, height = min(columns - 1, MOST_COLUMNS), max(min(rows - 4, MOST_ROWS), 4)
    with arm.parts.pace.lock:
        blocks = _blocks(twin)
        moment = Moment(twin.world.joints, twin.world.opening_mm)
    left = width * 3 // 5
    side = drawing.side(moment, left, height, blocks)
    top = drawing.top(moment, width - left - 1, height, blocks)
    picture = [f"{a:<{left}} {b}" for a, b in zip(side, top, strict=True)]
    status = arm.status
    picture.append(f"{status.which}, shown {pace:g} times faster"[:width])
    if not drawing.braille:
        message = message.replace("°", " deg")
    picture.append(f"{arm.parts.pace.now_s():6.1f} s  {message}"[:width])
    back = f"\x1b[{last_lines}F" if last_lines else ""
    # full lines, and all at once: they cover the last picture without a flicker
    put("".join(f"{line:<{width}}\n" for line in picture), control=back)
    return len(picture)


def _blocks(twin: SimulatedArm) -> list[Box]:
    """Return the blocks of the physical world as they lie, or are held, now."""
    return [
        Box(
            block.name,
            (block.x_mm - half, block.y_mm - half, block.z_mm),
            (block.x_mm + half, block.y_mm + half, block.z_mm + block.height_mm),
        )
        for block in twin.world.scene.blocks.values()
        for half in (block.width_mm / 2.0,)
    ]


# The simulated arm takes three blocks, measures each with its fingers, and stacks them.

# Its blocks are measured by a grip switch, which the other simulated arms do not have.
DIALECT = DEFAULT


def run(options: argparse.Namespace) -> Result:
    """Show the demonstration, check the world, and say what to try next."""
    config = simulated_config(DIALECT)
    twin = simulate(config, blocks=blocks_of(JOBS))
    began_s = time.monotonic()
    if sys.stdout.isatty() and not as_json(options):
        carried, simulated_s = draw(config, twin, pace=options.pace, ascii_only=options.ascii)
    else:
        with Arm(connect_simulated(config, twin=twin)) as arm:
            tell(options, arm.status.which)
            carried = perform(arm, JOBS, lambda text: show(Result({"step": text}, text), options))
            simulated_s = arm.parts.pace.now_s()
    wrong = misplaced(twin.world, JOBS) + [each.sentence for each in twin.world.incidents]
    return Result(
        _summary(carried, twin, wrong, simulated_s),
        _end(carried, wrong, simulated_s, time.monotonic() - began_s),
        1 if wrong else 0,
    )


def _summary(
    carried: list[CarriedBlock], twin: SimulatedArm, wrong: list[str], simulated_s: float
) -> dict[str, object]:
    places = {name: block.place for name, block in twin.world.scene.blocks.items()}
    return {
        "blocks": [
            {
                "name": each.job.name,
                "measured_mm": round(each.measured_mm, 2),
                "place_mm": [round(v, 2) for v in places.get(each.job.name, ())] or None,
            }
            for each in carried
        ],
        "wrong": wrong,
        "simulated_s": round(simulated_s, 2),
    }


def _end(
    carried: list[CarriedBlock], wrong: list[str], simulated_s: float, took_s: float
) -> Iterator[str]:
    for each in carried:
        yield (
            f"block {each.job.name}: measured {mm_text(each.measured_mm)}, "
            f"is {mm_text(each.job.width_mm)} wide"
        )
    for sentence in wrong:
        yield f"WRONG: {sentence}"
    if not wrong:
        yield "Every block stands where it belongs, in the simulated world itself."
    yield f"{simulated_s:.0f} s of simulated time in {took_s:.1f} s."
    yield "Next, for example:"
    for words in ("home", "move --x 250 --y 40 --z 120 --pitch -90", "jog"):
        yield f"  armdrive {words} --sim {DIALECT}"
