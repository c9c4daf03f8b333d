"""Simulated arms and devices, made from an arm's file and its dialect's row."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from armdrive.config.arm import ArmConfig
from armdrive.registry import DEFAULT, simulated_kind

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.device import SimDevice, Value
    from armdrive.sim.simulated_arm import SimulatedArm
    from armdrive.sim.world.table import Stand, TableBlock


def simulate(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[TableBlock] = (),
    play: int | Sequence[int] | None = None,
    stand: Stand | None = None,
    **options: Value,
) -> SimulatedArm:
    """Build the simulated counterpart of an arm, as `SimDeviceKind.simulate` says."""
    kind, saved = simulated_kind(config.connection.dialect), _with_dialect(saved)
    device = kind.simulate(config, saved, blocks=blocks, play=play, stand=stand, settings=options)
    return kind.twin(config, device)


def simulate_device(
    config: ArmConfig,
    saved: object = None,
    *,
    play: int | Sequence[int] | None = None,
    settings: Mapping[str, Value] | None = None,
) -> SimDevice:
    """Build the simulated device of an arm alone, for a process of its own."""
    kind = simulated_kind(config.connection.dialect)
    return kind.simulate(config, _with_dialect(saved), play=play, settings=settings)


def _with_dialect(saved: object) -> object:
    """Return a saved world with its dialect: those of the first versions do not name it."""
    return {"dialect": DEFAULT, **saved} if isinstance(saved, Mapping) else saved
