"""Deeper examinations: the drives on a CAN bus, and the settings of a recognised controller.

A bus is listened to before it is asked; it is asked by readings alone, and not at all while another
program commands drives. Nothing is set unless that is agreed to.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import TypeVar

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect import parts as connecting
from armdrive.connect.port import bare
from armdrive.dialects.bus.tools import IDS, LISTEN_S, Answers, BusTools, Heard, of_nobody
from armdrive.dialog.conversation import Finding, note, ok, problem
from armdrive.errors import ArmError, BadRequest, LinkLost, PortUnavailable
from armdrive.setup import findings as can_findings
from armdrive.setup.diagnosis import Diagnosis, Report
from armdrive.setup.dialog_runner import RealClock
from armdrive.setup.finding import PROTOCOLS, ask_bus, listened, nodes_heard
from armdrive.setup.findings import settings_findings
from armdrive.setup.limits import limit_remarks
from armdrive.storage.arm_lock import hold
from armdrive.tasks import DeviceSettings
from armdrive.transports import ports
from armdrive.transports.can_address import CanAddress
from armdrive.transports.can_health import BusHealth
from armdrive.transports.can_link import open_can_link

T = TypeVar("T")

Agree = Callable[[DeviceSettings], bool]
"""Returns whether the settings that differ may be written."""

# The settings of a controller that was recognised, whatever wire leads to it.


def compare_settings(config: ArmConfig, report: Report, agree: Agree | None) -> None:
    """Connect as every command does, and compare the settings; mend them where that is agreed."""
    try:
        with closing(Arm(connecting.connect_real(config))) as arm:  # `with arm` would enable it
            settings = arm.mend_settings([])
            lines = [each.mend for each in settings.differences]
            if lines and agree is not None and agree(settings):
                arm.mend_settings(lines)
                settings = arm.mend_settings([])
                report.add([ok(f"{len(lines)} settings were written")])
            report.add(settings_findings(settings))
            if settings.differences and report.arm:
                report.more["next"] = [
                    f"armdrive doctor --arm {report.arm} --mend",
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


# Who is on a CAN bus, how the bus is, and what differs from the arm file.


def ids_of(text: str) -> tuple[int, ...]:
    """Return the ids of drives that are written `1-16,20`. Raises `BadRequest`."""
    found: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise BadRequest(f"ids are written 1-16,20, not {text!r}")
        found |= set(range(int(first), int(last or first) + 1))
    most = max(row.most for row in PROTOCOLS.values())
    if not found or not 1 <= min(found) <= max(found) <= most:
        raise BadRequest(f"ids of drives are 1 to {most}, not {text!r}")
    return tuple(sorted(found))


def only_bus() -> str:
    """Return the one CAN bus that the system knows. Raises `PortUnavailable` for none, or more."""
    there = [each.port for each in ports.list_can_ports(ports.list_ports()) if not each.todo]
    if len(there) == 1:
        return there[0]
    listed = f"there are {', '.join(there)}" if there else "the system knows no adapter"
    raise PortUnavailable(
        f"which bus? {listed}: write it, --can slcan:/dev/ttyACM0?bitrate=500000 say; "
        "`armdrive ports` lists adapters and what each needs"
    )


@dataclass(frozen=True, slots=True)
class BusSurvey:
    """A survey of a CAN bus: who is there, how the bus is, what differs from an arm file.

    `ids` are asked; where none are given, the usual ones and those of the arm file. With
    `every_rate`, other bit rates are tried where nobody answers. With `agree`, settings that differ
    are written where that returns True.
    """

    report: Report
    config: ArmConfig | None
    ids: tuple[int, ...] = ()
    every_rate: bool = False
    agree: Agree | None = None

    def run(self) -> Diagnosis:
        """Survey the bus; what is found goes to the report."""
        report, config = self.report, self.config
        address = CanAddress.parse(report.port)
        master = getattr(config.device, "master_id", None) if config is not None else None
        heard = self._alone(lambda: listened(address, master))
        report.add(can_findings.of_listening(heard, LISTEN_S, _bits_s(address)))
        if heard.commands:
            return Diagnosis.MENDING
        if config is not None and self.agree is not None:
            # first, so that what is told then is as it is now
            compare_settings(config, report, self.agree)
        there = nodes_heard(heard.passing)
        found = self._alone(lambda: self._told(address, there))
        report.more["drives"] = [view for each in found for view in each.views]
        if config is not None:
            self._weigh(config, found)
        answering = [each for each in found if each.there]
        if not answering:
            return Diagnosis.NOBODY
        if config is None:
            steps = (PROTOCOLS[each.protocol].next for each in answering if each.drives)
            report.more["next"] = [step.format(port=report.port) for step in steps]
        return report.diagnosis

    def _alone(self, look: Callable[[], T]) -> T:
        """Look at the bus while no other armdrive has it."""
        port = self.report.port
        holding = hold(self.config.name if self.config is not None else port, port)
        try:
            return look()
        finally:
            holding.release()

    def _told(self, address: CanAddress, heard: Heard) -> tuple[Answers, ...]:
        """Ask the ids, at other bit rates too where nobody answers; add findings to the report."""
        report, config = self.report, self.config
        known = config.device.ids if config is not None else ()
        ids = self.ids or tuple(sorted({*IDS, *known}))
        dialect = config.connection.dialect if config is not None else ""
        found, health, lost = _asked(address, ids, heard, dialect)
        report.add(can_findings.of_health(health, lost))
        for each in found:
            report.add(each.findings(health, config.name if config else "NAME"))
        anybody = any(each.there for each in found)
        if not anybody:
            report.add([of_nobody(ids, health)])
        report.more["bus"] = {"state": health.state.value, **_counters(health)}
        if self.every_rate and not anybody:
            _every_rate(address, ids, report)
        return found

    def _weigh(self, config: ArmConfig, found: Sequence[Answers]) -> None:
        """Say how what answers differs from the arm file; compare settings where that is safe."""
        dialect, ids = config.connection.dialect, config.device.ids
        for each in found:
            row = PROTOCOLS[each.protocol]
            if row.dialect != dialect:
                if each.there:
                    self.report.add([_other(row, dialect)])
                continue
            self.report.add(can_findings.of_arm(ids, each.there, config.name, dialect))
            self.report.add(each.of_arm(ids))
            if set(ids) <= set(each.there) and row.connects and self.agree is None:
                compare_settings(config, self.report, None)


def _other(row: BusTools, dialect: str) -> Finding:
    return problem(
        f"what answers speaks {row.name}, and the arm file says {dialect}",
        f'dialect = "{row.dialect}" under [connection], if these are its drives',
    )


def _counters(health: BusHealth) -> dict[str, int]:
    names = ("sent", "heard", "refused", "error_frames", "read_errors", "overrun")
    return {name: getattr(health, name) for name in names}


def _asked(
    address: CanAddress, ids: tuple[int, ...], heard: Heard, dialect: str = ""
) -> tuple[tuple[Answers, ...], BusHealth, str]:
    """Ask the ids; return what was found, how the adapter was then, and why the bus was lost."""
    link = open_can_link(str(address))
    try:
        found = ask_bus(link, RealClock(), ids, heard, dialect)
    except LinkLost as error:
        return (), link.health, str(error).partition("was lost: ")[2]
    else:
        return found, link.health, ""
    finally:
        link.close()


def _every_rate(address: CanAddress, ids: tuple[int, ...], report: Report) -> None:
    """Ask at every other bit rate that drives have."""
    if address.interface == "socketcan":
        report.add([note("the bit rate of a kernel's interface is set by `ip link`, one by one")])
        return
    known = _bits_s(address)
    for bits_s in dict.fromkeys(rate for row in PROTOCOLS.values() for rate in row.bit_rates):
        if bits_s == known:
            continue
        options = dict(address.options) | {"bitrate": str(bits_s)}
        other = replace(address, options=tuple(options.items()))
        found, _, _ = _asked(other, ids, {})
        report.add([_at_rate(found, bits_s, other)])


def _at_rate(found: Sequence[Answers], bits_s: int, address: CanAddress) -> Finding:
    kbit = bits_s // 1000
    named = ", ".join(str(node) for each in found for node in each.there)
    if not named:
        return ok(f"nobody answers at {kbit} kbit/s")
    return problem(
        f"at {kbit} kbit/s there answer: {named}", f'in the arm file: port = "{address}"'
    )


def _bits_s(address: CanAddress) -> int:
    """Return the bit rate, 0 where the address does not tell it."""
    text = address.option("bitrate")
    return int(text) if text.isdecimal() else 0
