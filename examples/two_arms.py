"""Two arms hand a block over, each in its own coroutine, on one simulated clock.

Runs unattended: two simulated TeachMovers look at one another over 560 mm of table. For real ones,
leave out the `ArmWorld`, and name your two arm files.
"""

import asyncio

from armdrive import AsyncArm, Pose
from armdrive.testing import ArmWorld

MEETING_MM = 280.0  # from either base: half of what is between them
HEIGHT_MM = 70.0


def at(x_mm: float, y_mm: float, z_mm: float, pitch_deg: float) -> Pose:
    """Return a pose in an arm's own frame: x leads from its base to the other arm's."""
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=pitch_deg)


async def give(arm: AsyncArm, offered: asyncio.Event, taken: asyncio.Event) -> None:
    """Take the block by its top, hold it out, and let go once the other arm has it."""
    await arm.home()
    await arm.gripper.open(40)
    await arm.move_to(at(220, 110, 120, -90))
    await arm.move_l(at(220, 110, 55, -90))
    width_mm = await arm.gripper.grasp()
    print(f"{arm.status.time_s:6.1f} s  left has taken something {width_mm:.1f} mm wide")
    await arm.move_l(at(220, 110, 155, -90))
    await arm.move_to(at(MEETING_MM, 0, 155, -90))
    offered.set()
    await taken.wait()
    await arm.gripper.open(40)
    await arm.move_l(at(MEETING_MM, 0, 210, -90))
    print(f"{arm.status.time_s:6.1f} s  left has let go")


async def take(
    arm: AsyncArm, offered: asyncio.Event, taken: asyncio.Event, free: asyncio.Event
) -> None:
    """Come from the side, take the block low down, and set it on the table."""
    await arm.home()
    await arm.gripper.open(40)
    await arm.move_to(at(210, 0, 120, -20))
    await offered.wait()
    await arm.move_l(at(MEETING_MM, 0, 120, -20))
    width_mm = await arm.gripper.grasp()
    print(f"{arm.status.time_s:6.1f} s  right has it too, and measures {width_mm:.1f} mm")
    taken.set()
    await free.wait()
    await arm.move_l(at(220, 0, 120, -20))
    await arm.move_to(at(190, 110, 60, -45))
    await arm.move_l(at(190, 110, 20, -45))
    await arm.gripper.open(40)
    print(f"{arm.status.time_s:6.1f} s  right has put it down")


async def main() -> None:
    """Let both work at the same time; they wait for one another where they have to."""
    offered, taken, free = asyncio.Event(), asyncio.Event(), asyncio.Event()

    async def giving(arm: AsyncArm) -> None:
        await give(arm, offered, taken)
        free.set()

    async with AsyncArm.connect("left") as left, AsyncArm.connect("right") as right:
        await asyncio.gather(giving(left), take(right, offered, taken, free))


with ArmWorld() as world:
    world.add("left")
    world.add("right", x_mm=2 * MEETING_MM, turned_deg=180)
    world.put("A", 220, 110, width_mm=24, height_mm=HEIGHT_MM)
    asyncio.run(main())

    # the physical world is asked, not what the arms believe
    block = world.blocks["A"]
    print(f"the block stands at x {block.x_mm:.1f}, y {block.y_mm:.1f}, z {block.z_mm:.1f} mm")
    assert abs(block.x_mm - (2 * MEETING_MM - 190)) < 3.0
    assert abs(block.y_mm + 110) < 3.0
    assert block.z_mm == 0.0
    assert world.incidents == (), world.incidents
