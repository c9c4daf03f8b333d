"""Lists what people can choose for simulated devices: dialects, their settings and faults."""

from __future__ import annotations

from collections.abc import Mapping

from armdrive.sim.device import Value
from armdrive.sim.faults.table import faults_of
from armdrive.sim.simulated_arm import SimDeviceKind

_FAULT_NOTE = (
    "P is a probability for each byte, #N the N-th byte from now, next the whole next message;\n"
    "wire faults take from=host or from=device, and seed=N; for=SECONDS limits the duration;\n"
    "--fault drop:0.01,from=host@5 begins after 5 s."
)


def listing(kinds: Mapping[str, SimDeviceKind]) -> str:
    """Return the tables of these dialects."""
    return "\n\n".join([*(_one(name, kind) for name, kind in kinds.items()), _FAULT_NOTE])


def _one(dialect: str, kind: SimDeviceKind) -> str:
    settings = [
        (f"{row.name}={_shown(row.default)}", _with_choices(row.summary, row.choices))
        for row in kind.options
    ]
    faults = [(row.usage, row.summary) for row in faults_of(kind.board)]
    width = max(len(usage) for usage, _ in [*settings, *faults])
    lines = [f"{dialect}: a simulated {kind.title}"]
    for title, rows in (("settings (--set NAME=VALUE)", settings), ("faults (--fault)", faults)):
        lines += [f"  {title}:"] if rows else []
        lines += [f"    {usage:<{width}}  {summary}" for usage, summary in rows]
    return "\n".join(lines)


def _shown(value: object) -> str:
    return ("yes" if value else "no") if isinstance(value, bool) else str(value)


def _with_choices(summary: str, choices: tuple[Value, ...]) -> str:
    return f"{summary} ({', '.join(map(str, choices))})" if choices else summary
