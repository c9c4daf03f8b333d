"""Which simulated arm a program's connection leads to in a test's world."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.connecting import DEFAULT_TARGET, Target, find
from armdrive.durable import always
from armdrive.errors import ArmFileError, BadRequest
from armdrive.record import Record
from armdrive.sim.table import Stand, Table
from armdrive.sim.twin import Twin, make_twin

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.armfile import ArmConfig

ONLY = "arm"
"""The name of the arm of a world in which nobody has placed any by name."""


class Remembered:
    """What one arm's driver remembers between two connections, for as long as the world lasts."""

    def __init__(self) -> None:
        self._record: Record | None = None

    def load(self) -> Record | None:
        """Return what was saved last."""
        return self._record

    def refuse(self) -> None:
        """Take no notice: there is no file to be kept aside."""

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Keep a record."""
        if wanted():
            self._record = record

    def remove(self) -> None:
        """Forget it."""
        self._record = None


@dataclass(slots=True)
class Placed:
    """One simulated arm at the table, and who holds it."""

    config: ArmConfig
    twin: Twin
    recorder: Remembered = field(default_factory=Remembered)
    arm: Arm | None = None

    @property
    def taken(self) -> bool:
        """Whether a connection to it is open."""
        return self.arm is not None and not self.arm.closed


class Places:
    """The arms at one table by their names. One that nobody has placed is made when it is needed.

    `target` is what that one is: as `Arm.connect` takes it. Without it, what the program asks for,
    and the simulated TeachMover where the program's own name is not known on this computer.
    """

    def __init__(self, table: Table, target: str | None = None) -> None:
        self._table = table
        self._target = target
        self._placed: dict[str, Placed] = {}

    @property
    def all(self) -> Mapping[str, Placed]:
        """Every arm by its name."""
        return MappingProxyType(self._placed)

    def add(
        self,
        name: str,
        target: str | None,
        place: tuple[float, float, float] = (0.0, 0.0, 0.0),
        **options: Any,
    ) -> Placed:
        """Place an arm: what it is, and where its base stands (mm, mm, deg)."""
        if name in self._placed:
            raise BadRequest(f"an arm called {name!r} stands at the table already")
        config = find(target or self._target or DEFAULT_TARGET).config
        return self._place(name, config, place, options)

    def first(self) -> Placed:
        """Return the first arm, made now where nobody has placed any."""
        if not self._placed:
            self.add(ONLY, None)
        return next(iter(self._placed.values()))

    def meant(self, target: str | None, dialect: str | None, baud: int | None) -> Placed:
        """Return the arm that a program's connection leads to. Raises `BadRequest`."""
        if target in self._placed:
            return self._placed[target or ""]
        if self._placed and ONLY not in self._placed:
            raise BadRequest(
                f"no arm of this test is called {target!r}: {', '.join(self._placed)}; place it "
                f"with arm_world.add({target!r})"
            )
        asked = _known(target, dialect, baud)
        if not self._placed and self._target is None and asked is not None:
            return self._place(ONLY, asked.config)
        only = self.first()
        if asked is not None and not _alike(asked.config, only.config):
            raise BadRequest(
                f"the program connects to {asked.config.title} ({asked.config.connection.dialect}),"
                f" but this test has {only.config.title} ({only.config.connection.dialect}): mark "
                'it with @pytest.mark.armdrive(dialect="...") or (file="...")'
            )
        return only

    def _place(
        self,
        name: str,
        config: ArmConfig,
        place: tuple[float, float, float] = (0.0, 0.0, 0.0),
        options: Mapping[str, Any] = MappingProxyType({}),
    ) -> Placed:
        x_mm, y_mm, turned_deg = place
        stand = Stand(self._table, x_mm, y_mm, math.radians(turned_deg))
        placed = Placed(config, make_twin(config, stand=stand, **options))
        self._placed[name] = placed
        return placed


def _known(target: str | None, dialect: str | None, baud: int | None) -> Target | None:
    """Return what a program asks for; None for a name that only its own computer knows."""
    if target is None:
        return None
    try:
        return find(target, dialect_name=dialect, baud=baud)
    except (ArmFileError, BadRequest):
        if target.startswith("sim:") or target.endswith(".toml"):
            raise
        return None


def _alike(asked: ArmConfig, here: ArmConfig) -> bool:
    """Tell whether an arm is what a program takes it for."""
    same_dialect = asked.connection.dialect == here.connection.dialect
    return same_dialect and asked.calibration == here.calibration
