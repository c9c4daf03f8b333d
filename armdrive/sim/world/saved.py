"""The saved state of simulated arms, which outlive a process: plain data, read strictly.

Each saved thing is a dataclass whose fields are its entries. Whatever does not fit is a
`StateFileError` that names the entry.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from armdrive.errors import ArmFileError, StateFileError
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from armdrive.sim.world.table import Incident, TableBlock
from armdrive.text.toml import plain, section_of, setting

Json: TypeAlias = "bool | int | float | str | list[Json] | dict[str, Json] | None"
S = TypeVar("S")

# The advice given for a saved state that cannot be used.
FIX = "begin with a fresh simulated arm (--fresh)"


def restored(kind: type[S], data: object, what: str) -> S:
    """Return plain data as a dataclass. Raises `StateFileError` with the first misfit."""
    try:
        return section_of(kind, data)
    except ArmFileError as error:
        raise unfit(f"the saved {what} cannot be used: {error}") from None


def unfit(why: str) -> StateFileError:
    """Return the error of a saved state that cannot be used."""
    return StateFileError(f"{why}; {FIX}")


def require_names(what: str, found: Iterable[str], wanted: Iterable[str]) -> None:
    """Raise `StateFileError` unless a table without a schema has exactly these keys."""
    if strange := set(found) ^ set(wanted):
        raise unfit(f"the saved {what} lack {min(strange)!r:.60}, or should not have it")


def require_counts(what: str, counts: Sequence[int], motors: int, low: int, high: int) -> None:
    """Raise `StateFileError` unless there is one count within bounds for each motor."""
    if len(counts) != motors:
        raise unfit(f"the saved {what} are of {len(counts)} motors, not of {motors}")
    for count in counts:
        if not low <= count <= high:
            raise unfit(f"the saved {what} are from {low} to {high}, not {count}")


# Far more steps from zero than a motor of such an arm ever makes.
STEPS_MOST = 10_000_000
FORMAT = 1


@dataclass(frozen=True, slots=True)
class SavedWorld:
    """A world: `play_taken` of motors with backlash, `fingers_mm` where no motor turns them."""

    arm: str
    motors: tuple[int, ...]
    energised: bool
    blocks: tuple[TableBlock, ...]
    incidents: tuple[Incident, ...]
    held: str | None
    format: int = setting(low=FORMAT, high=FORMAT)
    play_taken: tuple[int, ...] | None = None
    fingers_mm: float | None = None


def world_to_json(world: World) -> dict[str, Json]:
    """Return everything needed to recreate a world."""
    saved = SavedWorld(
        world.body.key,
        tuple(world.motors),
        world.energised,
        tuple(world.scene.blocks.values()),
        tuple(world.incidents),
        world.scene.held,
        FORMAT,
        tuple(world.play.ahead) if world.play.any else None,
        None if world.body.transmission.has_gripper else world.fingers_mm,
    )
    entries: dict[str, Json] = plain(saved)
    return entries


def world_from_json(data: object, body: ArmBody) -> World:
    """Recreate a world.

    Raises `StateFileError` if the data do not fit this arm or contradict themselves.
    """
    saved = restored(SavedWorld, data, "world")
    if saved.arm != body.key:
        raise unfit(f"the saved world is of a {saved.arm}, not of a {body.key}")
    count = len(body.transmission.motors)
    require_counts("motors", saved.motors, count, -STEPS_MOST, STEPS_MOST)
    world = World(body, saved.motors)
    world.energised = saved.energised
    if saved.play_taken is not None:
        require_counts("play_taken", saved.play_taken, count, 0, STEPS_MOST)
        world.play.stand(saved.play_taken)
    if (saved.fingers_mm is None) is not body.transmission.has_gripper:
        raise unfit("fingers_mm is saved of an arm without a gripper's motor, and of no other")
    if saved.fingers_mm is not None:
        world.move_fingers(saved.fingers_mm)
    names = {block.name for block in saved.blocks}
    if len(names) < len(saved.blocks):
        raise unfit("two blocks of the saved world have the same name")
    if saved.held is not None and saved.held not in names:
        raise unfit(f"the saved world holds {saved.held!r:.60}, which is no block of it")
    world.restore_blocks(list(saved.blocks), saved.held)
    world.incidents = list(saved.incidents)
    return world
