"""The drives of a simulated arm as plain data: what is to be seen of them, and what is kept."""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.errors import StateFileError
from armdrive.sim.mks_answers import state
from armdrive.sim.mks_flash import Flash
from armdrive.sim.mks_node import Node
from armdrive.sim.saved import MEND, Json, Saved
from firmware_protocol.mks import HomingState


def known_json(nodes: Sequence[Node]) -> dict[str, Json]:
    """Return what each drive is set up to be, and whether it holds its shaft."""
    return {
        "drives": [
            {
                "powered": node.powered,
                "enabled": node.enabled,
                "stalled": node.stalled,
                "homed": node.homing is HomingState.DONE,
                "settings": dict(node.flash.to_json()),
            }
            for node in nodes
        ]
    }


def seen_json(node: Node, error: int, now_s: float) -> dict[str, Json]:
    """Return what a drive would tell of itself, and how far its shaft is from its set-point."""
    return {
        "id": node.device.node,
        "firmware": ".".join(map(str, node.firmware)),
        "powered": node.powered,
        "mode": node.mode.name.lower(),
        "enabled": node.enabled,
        "stalled": node.stalled,
        "state": state(node, now_s).name.lower(),
        "rpm": round(node.point.rpm(now_s), 2),
        "error_counts": error,
        "stored": node.stored is not None,
        "watchdog_s": 0.0 if math.isinf(node.timeout_s) else node.timeout_s,
        "watchdog_stops": node.watchdog_stops,
    }


def recall_known(nodes: Sequence[Node], saved: Saved, *, powered: bool) -> None:
    """Know again what `known_json` wrote. Raises `StateFileError`."""
    drives = saved.items("drives")
    if len(drives) != len(nodes):
        raise StateFileError(
            f"{len(drives)} drives are saved of an arm that has {len(nodes)}; {MEND}"
        )
    for node, item in zip(nodes, drives, strict=True):
        _recall(node, Saved(item, f"drive {node.index + 1}"), powered=powered)


def _recall(node: Node, saved: Saved, *, powered: bool) -> None:
    node.powered = saved.flag("powered") and powered
    node.stalled = saved.flag("stalled")
    node.homing = HomingState.DONE if saved.flag("homed") else None
    node.flash = Flash.from_json(saved.table("settings"))
    node.remake()
    node.recall_enabled(saved.flag("enabled"))
    saved.end()
