"""A survey of a serial port: what was found, in words, and what to do next.

`survey_port` has the prober find out who answers, turns that into findings, and compares the
settings of a controller that is the expected one. The findings of a bus, which `bus_survey` asks,
and of this computer are here too: so every finding is worded in one file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.connect import parts
from armdrive.connect.port import bare
from armdrive.dialects.bus.tools import RESISTORS, Listened, numbers
from armdrive.dialects.recognition import excerpt
from armdrive.dialog import Finding, Grade, any_problem, note, ok, parted, problem
from armdrive.errors import ArmError
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS, likely
from armdrive.setup import prober
from armdrive.setup.ports import ClosedPort, lines_of
from armdrive.setup.prober import Examination
from armdrive.storage.arm_lock import hold
from armdrive.tasks import DeviceSettings
from armdrive.transports.can_health import BusHealth, BusState, frame_bits
from kinematics.text import counted

CHECK_WIRING = (
    "check that the arm is switched on, that the cable carries data, and that transmit and "
    "receive are not swapped"
)
# The warning before a port is opened.
OPENING_RISK = (
    "Opening {port} can restart the board behind it: its motors lose their current, and a raised "
    "arm sags. Support it, or park it first. Nothing that is sent moves it."
)

NEVER_RESET = "in the arm file, under [connection]: raise_dtr = true and keep_dtr_on_close = true"


def of_examination(found: Examination, connection: Connection | None = None) -> list[Finding]:
    """Return the findings of an examination.

    `connection` is that of the arm file, if one says what is expected at the port.
    """
    identity = found.identity
    if identity is None:
        return [_unrecognised(found)]
    spoken = identity.dialect
    if not spoken:
        what = f"the device is {identity.firmware}, which armdrive cannot drive"
        listed = [problem(what, identity.remedy)]
    else:
        at = f" at {found.baud} baud" if found.baud else ""
        listed = [ok(f"it speaks {spoken}: {identity.firmware}{at}")]
        if connection is not None and spoken != connection.dialect:
            fix = f'write dialect = "{spoken}" in the arm file (--dialect {spoken}), or connect '
            what = f"the device speaks {spoken}, not {connection.dialect}"
            listed.append(problem(what, f"{fix}the other arm"))
    if found.echoes:
        fix = "switch the echo off in the adapter or on the board; check transmit and receive"
        listed.append(problem("the line echoes everything that is sent", fix))
    if found.restarted:
        what = "the board restarted when its port was opened: motors lose their current, and an arm"
        spared = connection is not None and connection.keeps_dtr
        once = "; the first opening after plugging in always does that" if spared else ""
        listed.append(
            note(f"{what} sags{once}", "" if spared or found.baud is None else NEVER_RESET)
        )
    return listed


def _unrecognised(found: Examination) -> Finding:
    if found.echoes:
        fix = "transmit and receive are connected, or a terminal echoes: check the wiring"
        return problem("everything that is sent comes straight back, and no device answers", fix)
    rates = " and ".join(map(str, sorted({each.baud for each in found.replies})))
    at = "" if found.baud is None else f" at {rates} baud"
    if not found.everything:
        return problem(f"no device answers{at}", f"{CHECK_WIRING}; or try another --baud N")
    return problem(
        f"the bytes received{at} are no answer of an arm that armdrive knows: "
        f"{excerpt(found.everything)}",
        "try another baud rate (--baud N); check the contacts and the ground wire. A text that is "
        "whole is that of another firmware, not an arm's",
    )


def next_steps(
    port: str,
    found: Examination,
    *,
    arm: str = "",
    owners: Sequence[str] = (),
    compared: bool = False,
) -> list[str]:
    """Return the commands to type next; none if no arm was found.

    `arm` is the arm file that was examined, `owners` are those that the port belongs to, and
    `compared` says that the settings have been compared already.
    """
    identity = found.identity
    if identity is None or identity.dialect not in DIALECTS:
        return []
    if arm:
        return [command_line("status", "--arm", arm)]
    if owners and not compared:
        return [command_line("doctor", "--arm", each) for each in owners]
    row = DIALECTS[identity.dialect]
    spoken = ["--dialect", row.name]
    if found.baud not in (None, row.baud):
        spoken += ["--baud", str(found.baud)]
    status = command_line("status", "--port", port, *spoken)
    settings = command_line("doctor", port, *spoken)
    describe = command_line("config", "new", "--port", port)
    return [status, describe] if compared else [settings, status, describe]


# A CAN bus: its traffic, its adapter, and the drives that answer.

# The most commands of another program that a finding quotes.
MOST_SHOWN = 3


def of_listening(traffic: Listened, seconds: float, bits_s: int) -> list[Finding]:
    """Return the findings of the traffic on a bus on which nothing was sent."""
    count = len(traffic.passing)
    if not count:
        return [ok(f"nothing passed in {seconds:g} s, so asking disturbs no other program")]
    # the longest that each frame can be on the wire: a load that is too low would be no warning
    load = sum(map(frame_bits, traffic.passing)) / seconds / bits_s if bits_s else 0.0
    shown = f", a load of {load:.1%}" if bits_s else ""
    what = f"{counted(count, 'frame')} passed in {seconds:g} s{shown}"
    if traffic.commands:
        describer = likely(traffic.commands).describer()
        quoted = "; ".join(describer.describe(each).words for each in traffic.commands[:MOST_SHOWN])
        fix = "so no drive was asked: end that program, then ask again; `armdrive can monitor`"
        return [
            problem(
                f"{what}, and another program commands drives ({quoted})",
                f"{fix} shows what it sends",
            )
        ]
    return [ok(f"{what}; no other program commands drives")]


def of_health(health: BusHealth, lost: str = "") -> list[Finding]:
    """Return the findings of the state of the bus's adapter."""
    counters = (
        f"sent {health.sent}, received {health.received}, refused {health.refused}, error frames "
        f"{health.error_frames}"
    )
    state = f"the adapter is {health.state.value} ({counters})"
    if health.state is BusState.OFF:
        return [
            problem(
                f"the adapter has left the bus: {state}",
                "the other nodes have another bit rate, or CAN H and L are shorted or swapped; an "
                "adapter that is alone on the bus stays error-passive",
            )
        ]
    if health.state is BusState.ACTIVE and not lost:
        return [ok(state)]
    return [note(f"{state}: {lost or health.last_trouble}", RESISTORS)]


def of_arm(ids: Sequence[int], answering: Iterable[int], arm: str, section: str) -> list[Finding]:
    """Compare the ids that answer with those of an arm file."""
    there = set(answering)
    bus = DIALECTS[section].bus
    commissioning = bus.commissioning if bus is not None else None
    missing = [node for node in ids if node not in there]
    more = sorted(there - set(ids))
    found = []
    if missing:
        fix = "check their supply and plugs"
        if commissioning is not None and commissioning.new_id in there:
            fix += (
                f"; a new drive has the id {commissioning.new_id}, whichever motor it turns: "
                f"`{command_line('can', 'setup', arm)}`"
            )
        found.append(problem(f"the arm file's drives {numbers(missing)} do not answer", fix))
    if more:
        what = f"drives {numbers(more)} answer that are not in the arm file's {section}.ids"
        found.append(note(what, ""))
    return found or [ok("every drive of the arm file answers, and no other")]


# The settings of a controller, compared with what its arm file expects.


def of_settings(settings: DeviceSettings) -> list[Finding]:
    """Return the firmware, if it is known, and the settings that differ.

    Those that forbid moving or homing are problems.
    """
    named = [ok(f"the controller's firmware is {settings.firmware}")] if settings.firmware else []
    listed = [
        Finding(
            Grade.PROBLEM if each.forbids else Grade.NOTE,
            f"{each.setting} is {each.found}, expected {each.expected}",
            each.fix,
        )
        for each in settings.differences
    ]
    return named + (listed or [ok("the controller's settings are what the arm file expects")])


# Returns whether the settings that differ may be written.
Agree = Callable[[DeviceSettings], bool]


def compare_settings(config: ArmConfig, report: Report, agree: Agree | None) -> None:
    """Connect as every command does, and compare the settings; write them if `agree` allows it."""
    try:
        with closing(Arm(parts.connect_real(config))) as arm:  # `with arm` would enable it
            settings = arm.controller.fix_settings([])
            lines = [each.fix for each in settings.differences if each.fix]
            if lines and agree is not None and agree(settings):
                arm.controller.fix_settings(lines)
                settings = arm.controller.fix_settings([])
                report.add([ok(f"{counted(len(lines), 'setting was', 'settings were')} written")])
            report.add(of_settings(settings))
            if settings.differences and report.arm:
                report.more["next"] = [
                    command_line("doctor", "--arm", report.arm, "--fix"),
                    *report.more.get("next", []),
                ]
    except ArmError as error:
        what, fix = parted(bare(error, config.connection))
        what = f"it was recognised, but did not connect: {what}"
        report.add([problem(what, fix or "try once more")])


# What a survey reports, and the survey of a serial port.


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
    """Further results as plain data; `next` are lines to show."""

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
        baud = str(self.more.get("baud") or "")
        known = {"connection.port": self.port, "dialect": self.dialect, "connection.baud": baud}
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
    agree: Agree | None = None,
) -> Diagnosis:
    """Open a serial port and report who answers.

    `config` is the arm that is expected there, and `baud` the only rate to try. Of a controller
    that is the expected one the settings are compared, and written if `agree` allows it.
    """
    connection = None if config is None else config.connection
    # an arm file's unusual rate is the only one to try
    only_baud = baud
    if connection is not None and connection.baud != DIALECTS[connection.dialect].baud:
        only_baud = baud or connection.baud
    # an arm's name and its port are both locked: another program may know only one of them
    with hold(report.port if config is None else config.name, report.port):
        found = prober.examine_port(report.port, only_baud)
    report.add(of_examination(found, connection))
    identity = found.identity
    report.more |= {
        "dialect": identity.dialect if identity else "",
        "firmware": identity.firmware if identity else "",
        "baud": found.baud if identity else None,
        "restarted": found.restarted,
        "next": next_steps(
            report.port, found, arm=report.arm, owners=closed.arms, compared=config is not None
        ),
    }
    if not report.dialect:
        return Diagnosis.NO_ARM
    if config is not None and report.dialect == config.connection.dialect:
        compare_settings(config, report, agree)
    return report.diagnosis
