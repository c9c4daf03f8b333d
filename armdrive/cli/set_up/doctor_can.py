"""`armdrive doctor --can`: who is on a CAN bus, how the bus is, and what differs from the arm file.

It listens before it asks, asks by readings alone, and not at all while another program commands
drives. Nothing is set without --mend and a yes.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from armdrive.cli.set_up.doctor_report import Report
from armdrive.cli.set_up.doctor_settings import compare
from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening
from armdrive.dialects.bus.tools import IDS, LISTEN_S, Answers, BusTools, Heard, of_nobody
from armdrive.dialog.conversation import Finding, any_problem, note, ok, problem
from armdrive.errors import ArmError, BadRequest, LinkError, LinkLost, PortUnavailable
from armdrive.setup import findings as can_findings
from armdrive.setup.dialog_runner import RealClock
from armdrive.setup.finding import PROTOCOLS, ask_bus, listened, nodes_heard
from armdrive.storage.arm_lock import hold
from armdrive.transports import ports
from armdrive.transports.address import PREFIX, is_can
from armdrive.transports.can_address import CanAddress
from armdrive.transports.can_health import BusHealth
from armdrive.transports.can_link import open_can_link

T = TypeVar("T")

DONE, MENDING, CLOSED, NOBODY = 0, 1, 4, 6


def ids_of(text: str) -> tuple[int, ...]:
    """Read `1-16,20`. Raises `BadRequest`."""
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


def bus_of(options: argparse.Namespace, config: ArmConfig | None) -> str:
    """Return the bus that is meant, as `can:...`. Raises `BadRequest` or `PortUnavailable`."""
    if options.can:
        return str(options.can if is_can(options.can) else PREFIX + options.can)
    if config is not None:
        return PortOpening(config).find()
    if options.port:
        return str(options.port)
    there = [each.port for each in ports.list_can_ports(ports.list_ports()) if not each.todo]
    if len(there) == 1:
        return there[0]
    listed = f"there are {', '.join(there)}" if there else "the system knows no adapter"
    raise PortUnavailable(
        f"which bus? {listed}: write it, --can slcan:/dev/ttyACM0?bitrate=500000 say; "
        "`armdrive ports` lists adapters and what each needs"
    )


def run(options: argparse.Namespace, config: ArmConfig | None) -> int:
    """Survey the bus, and say what was found."""
    port = bus_of(options, config)
    if not is_can(port):
        raise BadRequest(f"{port} is no CAN bus: write can:INTERFACE:CHANNEL")
    report = Report(port, options.json)
    ids = ids_of(options.ids) if options.ids else _known_ids(config)
    address = CanAddress.parse(port)
    master = getattr(config.device, "master_id", None) if config is not None else None
    heard = _alone(config, port, lambda: listened(address, master))
    report.add(can_findings.of_listening(heard, LISTEN_S, _bits_s(address)))
    if heard.commands:
        return report.end(MENDING)
    if config is not None and options.mend:  # first, so that what is told then is as it is now
        _compare(config, report, options)
    there = nodes_heard(heard.passing)
    found = _alone(config, port, lambda: _told(address, ids, there, report, config, options))
    report.more["drives"] = [view for each in found for view in each.views]
    if config is not None:
        _weigh(config, found, report, options)
    answering = [each for each in found if each.there]
    if not answering:
        return report.end(NOBODY)
    if config is None:
        steps = (PROTOCOLS[each.protocol].next for each in answering if each.drives)
        report.more["next"] = [step.format(port=port) for step in steps]
    return report.end(MENDING if any_problem(report.findings) else DONE)


def _weigh(
    config: ArmConfig, found: Sequence[Answers], report: Report, options: argparse.Namespace
) -> None:
    """Say how what answers differs from the arm file, and compare settings where that is safe."""
    dialect = config.connection.dialect
    for each in found:
        row = PROTOCOLS[each.protocol]
        if row.dialect != dialect:
            if each.there:
                report.add([_other(row, dialect)])
            continue
        report.add(can_findings.of_arm(config.device.ids, each.there, config.name, dialect))
        report.add(each.of_arm(config.device.ids))
        everyone = set(config.device.ids) <= set(each.there)
        if everyone and row.connects and not options.mend:
            _compare(config, report, options)


def _other(row: BusTools, dialect: str) -> Finding:
    return problem(
        f"what answers speaks {row.name}, and the arm file says {dialect}",
        f'dialect = "{row.dialect}" under [connection], if these are its drives',
    )


def _alone(config: ArmConfig | None, port: str, look: Callable[[], T]) -> T:
    """Look at a bus while no other armdrive has it."""
    holding = hold(config.name if config is not None else port, port)
    try:
        return look()
    finally:
        holding.release()


def _known_ids(config: ArmConfig | None) -> tuple[int, ...]:
    return tuple(sorted({*IDS, *(config.device.ids if config is not None else ())}))


def _told(
    address: CanAddress,
    ids: tuple[int, ...],
    heard: Heard,
    report: Report,
    config: ArmConfig | None,
    options: argparse.Namespace,
) -> tuple[Answers, ...]:
    """Ask the ids, at other bit rates too where nobody answers; add findings to the report."""
    dialect = config.connection.dialect if config is not None else ""
    found, health, lost = _asked(address, ids, heard, dialect)
    report.add(can_findings.of_health(health, lost))
    for findings in (each.findings(health, config.name if config else "NAME") for each in found):
        report.add(findings)
    anybody = any(each.there for each in found)
    if not anybody:
        report.add([of_nobody(ids, health)])
    report.more["bus"] = {"state": health.state.value, **_counters(health)}
    if options.every_rate and not anybody:
        _every_rate(address, ids, report)
    return found


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


def _compare(config: ArmConfig, report: Report, options: argparse.Namespace) -> None:
    try:
        compare(config, report, options)
    except LinkError as error:
        report.add([problem(str(error), "try once more")])
    except ArmError as error:
        report.add([problem(str(error), "see above")])
