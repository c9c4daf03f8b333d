"""The settings of a device that is known, compared with what its arm file expects."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.controllers.settings import Difference, Settings
from armdrive.doctor.findings import Finding, note, ok, problem

if TYPE_CHECKING:
    from armdrive.arm import Arm


def settings_findings(settings: Settings) -> list[Finding]:
    """Say which settings differ; those that keep the arm from moving are problems."""
    listed = [_finding(each) for each in settings.differences]
    told = f" ({settings.firmware})" if settings.firmware else ""
    return listed or [ok(f"the controller's settings{told} are what the arm file expects")]


def _finding(difference: Difference) -> Finding:
    what = f"{difference.setting} is {difference.found}, expected {difference.expected}"
    return (problem if difference.must else note)(what, difference.mend)


def compared(arm: Arm) -> Settings:
    """Compare once more through a connected arm, which does so at connecting too."""
    return arm.mend_settings([])
