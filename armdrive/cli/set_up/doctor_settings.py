"""The settings of a controller that was recognised, compared with those that its arm file expects.

Whatever wire leads to it: this connects as every command does.
"""

from __future__ import annotations

import argparse
from contextlib import closing

from armdrive.arm import Arm
from armdrive.cli.presenter import say
from armdrive.cli.screens import agreed
from armdrive.cli.set_up.doctor_report import Report
from armdrive.config.arm import ArmConfig
from armdrive.connect import parts as connecting
from armdrive.connect.port import bare
from armdrive.dialog.conversation import Finding, note, ok, problem
from armdrive.errors import ArmError
from armdrive.setup.findings import settings_findings
from armdrive.setup.limits import limit_remarks
from armdrive.tasks import DeviceSettings


def compare(config: ArmConfig, report: Report, options: argparse.Namespace) -> None:
    """Connect as every command does, and compare the settings; mend them where that is agreed."""
    try:
        with closing(Arm(connecting.connect_real(config))) as arm:  # `with arm` would enable it
            settings = arm.mend_settings([])
            lines = [each.mend for each in settings.differences]
            if lines and options.mend and _mending_agreed(settings, options):
                arm.mend_settings(lines)
                settings = arm.mend_settings([])
                report.add([ok(f"{len(lines)} settings were written")])
            report.add(settings_findings(settings))
            if settings.differences and options.arm:
                report.more["next"] = [
                    f"armdrive doctor --arm {options.arm} --mend",
                    *report.more.get("next", []),
                ]
            report.add([note(each) for each in limit_remarks(config)])
            report.more["firmware"] = settings.firmware or report.more.get("firmware", "")
    except ArmError as error:
        report.add([_unconnected(error, config)])


def _unconnected(error: ArmError, config: ArmConfig) -> Finding:
    """Say why an arm did not connect that was recognised, and what helps, as its error has it."""
    what, _, mend = bare(error, config.connection).partition(": ")
    return problem(
        f"it was recognised, but did not connect: {what}",
        mend or "try once more",
    )


def _mending_agreed(settings: DeviceSettings, options: argparse.Namespace) -> bool:
    if options.yes:
        return True
    if options.json:
        return False
    for each in settings.differences:
        say(f"  {each}")
    count = len(settings.differences)
    return agreed(f"Write these {count} settings to the controller? Type yes: ")
