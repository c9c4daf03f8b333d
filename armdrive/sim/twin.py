"""A simulated twin: an arm's world, its controller and the wire to it, for one process."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.blocks import Block
from armdrive.sim.body import ArmBody
from armdrive.sim.device import SimDevice
from armdrive.sim.drives import DrivesOnBus
from armdrive.sim.faults import Faults, LinkCable
from armdrive.sim.operator import SimulatedOperator
from armdrive.sim.options import Options, Value
from armdrive.sim.play import play_of
from armdrive.sim.recalling import recalled
from armdrive.sim.saved import MEND, Json
from armdrive.sim.table import Stand
from armdrive.sim.twins import twin_kind
from armdrive.sim.world import World
from armdrive.transports.memory import MemoryLink

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig

DIALECT = "dialect"
"""The entry of a saved world that names the dialect; without it, the only one that there was."""
_FIRST = "teachmover"


@dataclass(frozen=True, slots=True)
class Twin:
    """The simulated counterpart of a connected arm. `world` is the physical truth.

    `faults` makes things go wrong: `twin.faults.add("drop", 0.01, side="host")`.
    """

    dialect: str
    device: SimDevice
    link: MemoryLink
    operator: SimulatedOperator
    faults: Faults

    @property
    def world(self) -> World:
        """The physical arm and what is around it."""
        return self.device.world

    def save(self) -> dict[str, Json]:
        """Return the dialect, the world and the controller's memory as plain data."""
        return {DIALECT: self.dialect, **self.device.to_json()}


def make_twin(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[Block] = (),
    play: int | Sequence[int] | None = None,
    stand: Stand | None = None,
    **options: Value,
) -> Twin:
    """Build the twin of an arm: as it was saved, or as one finds it in the morning.

    `play` is the lost motion of every motor's train, or of each, in steps: without it, the
    backlash of the arm file, which is what the driver takes up. `stand` puts the arm on a table
    with others, which a saved world cannot be put on. `options` are settings of the
    dialect's device (`twins.py`), `speed_error=0.2` say. Raises `StateFileError` where what was
    saved fits no such arm, and `BadRequest` for the rest.
    """
    device = make_device(config, saved, blocks=blocks, play=play, stand=stand, settings=options)
    link = link_to(device)
    operator, faults = SimulatedOperator(device.world), Faults(device, link.line, LinkCable(link))
    return Twin(config.connection.dialect, device, link, operator, faults)


def link_to(device: SimDevice) -> MemoryLink:
    """Return a wire within this process to a device: a serial line, or the bus of its drives."""
    if not isinstance(device, DrivesOnBus):
        return MemoryLink(device, device.baud)
    from armdrive.transports.can_memory import CanMemoryLink

    return CanMemoryLink(device, device.bits_s())


def make_device(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[Block] = (),
    play: int | Sequence[int] | None = None,
    stand: Stand | None = None,
    settings: Mapping[str, Value] | None = None,
) -> SimDevice:
    """Build the simulated device alone, for a process of its own."""
    dialect = config.connection.dialect
    kind = twin_kind(dialect)
    body = ArmBody.of_preset(config.model)
    widths = config.backlash_steps if play is None else play_of(play, len(body.transmission.motors))
    body = replace(body, play=widths)
    chosen = Options(kind.options, settings)
    if saved is None:
        return kind.make(config, World(body, blocks=blocks, stand=stand), chosen)
    if stand is not None:
        raise BadRequest("a saved world has a table of its own: it cannot be put on another")
    known = _of_dialect(saved, dialect)
    what = f"simulated {kind.title}"
    return recalled(known, lambda world: kind.make(config, world, chosen), body, what=what)


def _of_dialect(saved: object, dialect: str) -> object:
    """Return a saved world without its dialect, which must be this one."""
    if not isinstance(saved, Mapping):
        return saved
    spoken = saved.get(DIALECT, _FIRST)
    if spoken != dialect:
        raise StateFileError(
            f"the saved arm speaks {spoken!r}, not {dialect!r}: they have nothing in common; {MEND}"
        )
    return {key: value for key, value in saved.items() if key != DIALECT}
