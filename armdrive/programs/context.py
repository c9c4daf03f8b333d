"""What a program is read with when others have run before it, as the lines of a prompt do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from armdrive.programs.syntax import Define
from armdrive.programs.values import Place, Value
from armdrive.programs.vocabulary import Kind


@dataclass(frozen=True, slots=True)
class Context:
    """The subprograms and values that are known already, by names in lower case.

    `opening` is what the fingers are to do with the next move, see state.State.
    """

    defines: tuple[Define, ...] = ()
    variables: Mapping[str, Value] = field(default_factory=dict)
    speed: float = 1.0
    opening: float | str | None = None

    @property
    def kinds(self) -> dict[str, Kind]:
        """Of which kind each value is."""
        return {name: kind_of(value) for name, value in self.variables.items()}

    def but(self, defines: tuple[Define, ...]) -> tuple[Define, ...]:
        """Return the subprograms that these do not replace, and behind them these."""
        said = {define.name.lower() for define in defines}
        return (*(each for each in self.defines if each.name.lower() not in said), *defines)


def kind_of(value: Value) -> Kind:
    """Return of which kind a value is."""
    if isinstance(value, bool):
        return Kind.TRUTH
    if isinstance(value, Place):
        return Kind.PLACE
    return Kind.TEXT if isinstance(value, str) else Kind.NUMBER
