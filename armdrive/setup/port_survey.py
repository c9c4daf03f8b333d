"""A survey of a serial port: what it tells while closed, who answers, and what has to be mended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening
from armdrive.errors import PortUnavailable
from armdrive.registry import DIALECTS
from armdrive.setup import findings as after
from armdrive.setup import prober
from armdrive.setup.diagnosis import Diagnosis, Report
from armdrive.setup.ports import Before, PortNaming, arm_files, look_at, unfound
from armdrive.setup.prober import Examination
from armdrive.storage.arm_lock import hold
from armdrive.tasks import DeviceSettings


def closed_port(config: ArmConfig) -> tuple[str, Before]:
    """Return the present name of an arm file's port, and what can be said while it is closed."""
    try:
        port = PortOpening(config).find()
    except PortUnavailable as error:
        return "", unfound(error)
    wire = config.connection
    own = PortNaming(config.name, wire.port, wire.usb_serial)  # its file may lie elsewhere
    return port, look_at(port, (own, *(each for each in arm_files() if each.arm != own.arm)))


@dataclass(frozen=True, slots=True)
class PortSurvey:
    """A survey of a port that may be opened now.

    `config` is the arm that is expected there, if one is, and `baud` the only rate to try, if it is
    given. With `agree`, settings that differ are written where that returns True.
    """

    report: Report
    before: Before
    config: ArmConfig | None = None
    baud: int | None = None
    agree: Callable[[DeviceSettings], bool] | None = None

    def run(self) -> Diagnosis:
        """Open the port, and find out who answers; what is found goes to the report."""
        report, config = self.report, self.config
        found = self._examined()
        report.add(after.findings(found, self._expected()))
        self._note(found)
        identity = found.identity
        if identity is None or not identity.dialect:
            return Diagnosis.NOBODY
        if config is not None and identity.dialect == config.connection.dialect:
            # all that drives an arm, which a silent port does without
            from armdrive.setup.bus_survey import compare_settings

            compare_settings(config, report, self.agree)
        return report.diagnosis

    def _examined(self) -> Examination:
        port = self.report.port
        holding = hold(self.config.name if self.config is not None else port, port)
        try:
            return prober.examine_port(port, self._only_baud)
        finally:
            holding.release()

    @property
    def _only_baud(self) -> int | None:
        """The one baud rate to try: the given one, or one that is not its dialect's usual."""
        if self.baud is not None or self.config is None:
            return self.baud
        wire = self.config.connection
        return None if wire.baud == DIALECTS[wire.dialect].baud else wire.baud

    def _expected(self) -> after.Expected:
        if self.config is None:
            return after.Expected(baud=self._only_baud)
        wire = self.config.connection
        spared = wire.raise_dtr and wire.keep_dtr_on_close
        return after.Expected(wire.dialect, self._only_baud, spared)

    def _note(self, found: Examination) -> None:
        """Note who answered, and what to do next."""
        report, before, identity = self.report, self.before, found.identity
        known = bool(report.arm or before.owners)
        report.more |= {
            "dialect": identity.dialect if identity else "",
            "firmware": identity.firmware if identity else "",
            "baud": found.baud if identity else None,
            "restarted": found.restarted,
            "next": after.next_steps(
                report.port,
                found,
                arm=report.arm,
                owners=before.owners,
                compared=self.config is not None,
            ),
            "arm_file": []
            if known
            else after.arm_file_lines(report.port, found, before.usb_serial),
        }
