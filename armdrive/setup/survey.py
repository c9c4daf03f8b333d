"""A survey of a serial port: who answers, and what has to be done. Also what a survey reports."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialog.conversation import Finding, any_problem
from armdrive.registry import DIALECTS
from armdrive.setup import findings as after
from armdrive.setup import prober
from armdrive.setup.ports import ClosedPort, lines_of
from armdrive.setup.prober import Examination
from armdrive.storage.arm_lock import hold


class Diagnosis(Enum):
    """The outcome of a survey."""

    FINE = auto()
    PROBLEM = auto()
    CLOSED = auto()
    """The port cannot be opened."""
    NO_ARM = auto()
    """No arm was recognised."""


def _ignore(_finding: Finding) -> None:
    pass


@dataclass(slots=True)
class Report:
    """The findings at a port; `tell` is called with each as soon as it is made."""

    port: str
    tell: Callable[[Finding], None] = _ignore
    arm: str = ""
    """The arm file that the user named, as the next command would name it."""
    findings: list[Finding] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)
    """Further results as plain data; `next` and `arm_file` are lines to show."""

    def add(self, findings: Sequence[Finding]) -> None:
        """Add findings, and tell them."""
        self.findings += findings
        for each in findings:
            self.tell(each)

    @property
    def diagnosis(self) -> Diagnosis:
        """The outcome if an arm has answered."""
        return Diagnosis.PROBLEM if any_problem(self.findings) else Diagnosis.FINE

    @property
    def dialect(self) -> str:
        """The dialect that was recognised, or an empty text."""
        return str(self.more.get("dialect", ""))

    @property
    def lines(self) -> tuple[str, ...]:
        """The findings as text."""
        return lines_of(self.findings)

    @property
    def answers(self) -> dict[str, str]:
        """What the survey answers of the questions that make an arm file."""
        known = {"connection.port": self.port, "dialect": self.dialect}
        if self.dialect and self.more.get("baud"):
            known["connection.baud"] = str(self.more["baud"])
        return {key: word for key, word in known.items() if word}

    def view(self) -> dict[str, Any]:
        """Return everything as plain data."""
        findings = [each.view() for each in self.findings]
        return {"port": self.port, **self.more, "findings": findings}


def survey_port(
    report: Report,
    closed: ClosedPort,
    config: ArmConfig | None = None,
    baud: int | None = None,
    compare: Callable[[ArmConfig, Report], None] | None = None,
) -> Diagnosis:
    """Open a serial port and report who answers.

    `config` is the arm that is expected there, and `baud` the only rate to try. `compare` is
    called for a controller that is the expected one, and compares its settings.
    """
    only_baud = _only_baud(config, baud)
    holding = hold(report.port if config is None else config.name, report.port)
    try:
        found = prober.examine_port(report.port, only_baud)
    finally:
        holding.release()
    report.add(after.of_examination(found, _expected(config, only_baud)))
    report.more |= _results(report, closed, found, compared=config is not None)
    identity = found.identity
    if identity is None or not identity.dialect:
        return Diagnosis.NO_ARM
    expected = config is not None and identity.dialect == config.connection.dialect
    if config is not None and expected and compare is not None:
        compare(config, report)
    return report.diagnosis


def _only_baud(config: ArmConfig | None, baud: int | None) -> int | None:
    """Return the one baud rate to try: the given one, or the arm file's if it is unusual."""
    if baud is not None or config is None:
        return baud
    wire = config.connection
    return None if wire.baud == DIALECTS[wire.dialect].baud else wire.baud


def _expected(config: ArmConfig | None, only_baud: int | None) -> after.Expected:
    if config is None:
        return after.Expected(baud=only_baud)
    wire = config.connection
    return after.Expected(wire.dialect, only_baud, wire.raise_dtr and wire.keep_dtr_on_close)


def _results(
    report: Report, closed: ClosedPort, found: Examination, *, compared: bool
) -> dict[str, Any]:
    identity = found.identity
    has_file = bool(report.arm or closed.owners)
    return {
        "dialect": identity.dialect if identity else "",
        "firmware": identity.firmware if identity else "",
        "baud": found.baud if identity else None,
        "restarted": found.restarted,
        "next": after.next_steps(
            report.port, found, arm=report.arm, owners=closed.owners, compared=compared
        ),
        "arm_file": [] if has_file else after.arm_file_lines(report.port, found, closed.usb_serial),
    }
