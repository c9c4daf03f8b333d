"""What a device says unasked, and what that does to trust and state: one table."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.controllers.requests import Alert, AlertKind
from armdrive.remarks import ALARM_VOUCHED, code_of
from armdrive.status import Current
from armdrive.trust import Evidence

if TYPE_CHECKING:
    from armdrive.core import Core

EVIDENCE: Mapping[AlertKind, Evidence | None] = MappingProxyType(
    {
        AlertKind.RESTARTED: Evidence.RESTARTED,
        AlertKind.ALARM: None,
        AlertKind.ALARM_LOST: Evidence.ALARM,
        AlertKind.SWITCHED_OFF: Evidence.SWITCHED_OFF,
        AlertKind.ASTRAY: Evidence.OFF_THE_PATH,
    }
)
"""What each alert says about the position; None where the device vouches for it."""


def alerted(core: Core, alert: Alert, now_s: float) -> None:
    """Latch error-stop with the device's words, and weigh what they mean for the position."""
    evidence = EVIDENCE[alert.kind]
    if evidence is not None:
        core.learn(evidence, now_s, alert.text)
        core.told_early = core.told_early or (evidence, alert.text)
    if alert.kind in (AlertKind.RESTARTED, AlertKind.SWITCHED_OFF):
        core.current = Current.UNKNOWN
    code = ALARM_VOUCHED if evidence is None else code_of(evidence)
    core.fault(f"{alert.text}. Look at the arm, then call `reset()`", code)
