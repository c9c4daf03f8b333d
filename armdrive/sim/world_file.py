"""A world as plain numbers and texts, so that simulated arms can outlive a process."""

from __future__ import annotations

from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.blocks import Block
from armdrive.sim.body import ArmBody
from armdrive.sim.incidents import Incident, IncidentKind
from armdrive.sim.saved import MEND, STEPS_MOST, Json, Saved
from armdrive.sim.world import World

FORMAT = 1
_LENGTHS = ("x_mm", "y_mm", "z_mm", "width_mm", "height_mm")


def world_to_json(world: World) -> dict[str, Json]:
    """Return everything that a world needs to be made again."""
    has_gripper = world.body.transmission.has_gripper
    return {
        "format": FORMAT,
        "arm": world.body.key,
        "motors": list(world.motors),
        "energised": world.energised,
        **({"play_taken": list(world.play.ahead)} if world.play.any else {}),
        **({} if has_gripper else {"fingers_mm": world.fingers_mm}),
        "blocks": [block_to_json(block) for block in world.scene.blocks.values()],
        "held": world.scene.held,
        "incidents": [incident_to_json(incident) for incident in world.incidents],
    }


def world_from_json(data: object, body: ArmBody | None = None) -> World:
    """Make a world again; raises `StateFileError` where it does not fit this arm or itself."""
    saved = Saved(data, "world")
    saved.whole("format", FORMAT, FORMAT)
    world = World(body)
    key = saved.text("arm")
    if key != world.body.key:
        raise StateFileError(f"the saved world is of a {key}, not of a {world.body.key}; {MEND}")
    count = len(world.body.transmission.motors)
    world = World(body, saved.wholes("motors", count, -STEPS_MOST, STEPS_MOST))
    world.energised = saved.flag("energised")
    if saved.has("play_taken"):
        taken = saved.wholes("play_taken", count, 0, STEPS_MOST)
        world.play.stand(taken)
    if not world.body.transmission.has_gripper:
        world.move_fingers(saved.number("fingers_mm"))
    blocks = [_block(item) for item in saved.items("blocks")]
    if len({block.name for block in blocks}) < len(blocks):
        raise StateFileError(f"two blocks of the saved world have the same name; {MEND}")
    held = saved.text_or_none("held")
    if held is not None and held not in {block.name for block in blocks}:
        raise StateFileError(f"the saved world holds {held!r}, which is no block of it; {MEND}")
    world.restore_blocks(blocks, held)
    world.incidents = [_incident(item) for item in saved.items("incidents")]
    saved.end()
    return world


def block_to_json(block: Block) -> dict[str, Json]:
    """Return a block's name, place and size."""
    sizes: dict[str, Json] = {name: getattr(block, name) for name in _LENGTHS}
    return {"name": block.name, **sizes}


def incident_to_json(incident: Incident) -> dict[str, Json]:
    """Return what happened, to what and when."""
    return {
        "kind": incident.kind.value,
        "what": incident.what,
        "sentence": incident.sentence,
        "time_s": incident.time_s,
    }


def _block(data: object) -> Block:
    saved = Saved(data, "block")
    try:
        block = Block(saved.text("name"), *(saved.number(name) for name in _LENGTHS))
    except BadRequest as error:
        raise StateFileError(f"{error}; {MEND}") from None
    saved.end()
    return block


def _incident(data: object) -> Incident:
    saved = Saved(data, "incident")
    kind = saved.text("kind")
    known = {one.value: one for one in IncidentKind}
    if kind not in known:
        raise StateFileError(f"no incident is of the kind {kind!r}; {MEND}")
    incident = Incident(
        known[kind], saved.text("what"), saved.text("sentence"), saved.number("time_s")
    )
    saved.end()
    return incident
