"""The settings of a device that is known, compared with what its arm file expects."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from armdrive.controllers.requests import Difference
from armdrive.doctor.findings import Finding, note, ok, problem

if TYPE_CHECKING:
    from armdrive.arm import Arm


def settings_findings(differences: Iterable[Difference], firmware: str = "") -> list[Finding]:
    """Say which settings differ; those that keep the arm from moving are problems."""
    listed = [_finding(each) for each in differences]
    told = f" ({firmware})" if firmware else ""
    return listed or [ok(f"the controller's settings{told} are what the arm file expects")]


def _finding(difference: Difference) -> Finding:
    what = f"{difference.setting} is {difference.found}, expected {difference.expected}"
    return (problem if difference.must else note)(what, difference.mend)


def compared(arm: Arm) -> tuple[tuple[Difference, ...], list[Finding]]:
    """Compare once more through a connected arm, which does so at connecting too."""
    settings = arm.mend_settings([])
    return settings.differences, settings_findings(settings.differences, settings.firmware)
