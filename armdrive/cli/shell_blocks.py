"""The prompt's words about the table of a simulated arm: what stands there, and one more block."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

from armdrive.cli.putting import put_blocks
from armdrive.errors import BadRequest
from armdrive.sim.serving.console import block_of

if TYPE_CHECKING:
    from armdrive.cli.shell_entries import Shell
    from armdrive.sim.world.scene import Scene


def put(shell: Shell, rest: str) -> None:
    """Put a block on the table: `put A 250 0`, or with commas."""
    _scene(shell)
    block = block_of(rest.replace(",", " ").split())
    put_blocks(shell.arm, [block])
    _tell(shell, block.name)


def blocks(shell: Shell, _: str) -> None:
    """Say where every block stands, as the simulated world itself has it."""
    names = list(_scene(shell).blocks)
    for name in names:
        _tell(shell, name)
    if not names and not shell.json:
        shell.tell({}, "there are no blocks: `put A 250 0` puts one on the table")


def _tell(shell: Shell, name: str) -> None:
    scene = _scene(shell)
    block, held = scene.blocks[name], scene.held == name
    where = "in the fingers, its" if held else "its"
    text = f"{where} bottom at x {block.x_mm:.1f}, y {block.y_mm:.1f}, z {block.z_mm:.1f} mm"
    size = f"{block.width_mm:g} mm wide and {block.height_mm:g} mm high"
    view = {"event": "block", **asdict(block), "held": held}
    shell.tell(view, f"  {name}: {text}, {size}")


def _scene(shell: Shell) -> Scene:
    twin = shell.arm.twin
    if twin is None:
        raise BadRequest("nobody knows what lies on the table of a real arm")
    return twin.world.scene
