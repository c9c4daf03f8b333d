"""Surveys the drives on a CAN bus.

A bus is listened to first. Then its drives are asked by readings alone, and not at all while
another program commands them. Nothing is set without the user's consent.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import closing
from functools import partial

from armdrive.config.arm import ArmConfig
from armdrive.connect.target import require_real_ports
from armdrive.dialects.bus import tools
from armdrive.dialects.bus.tools import (
    IDS,
    LISTEN_S,
    Answers,
    BusTools,
    Listened,
    SeenNodes,
    frame_scripts,
    of_nobody,
)
from armdrive.dialog import note, problem
from armdrive.errors import BadRequest, LinkLost, PortUnavailable
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS
from armdrive.setup import dialog_runner
from armdrive.setup.dialog_runner import carry_out
from armdrive.setup.ports import ClosedPort
from armdrive.setup.prober import ask_bus, is_command, nodes_seen, protocols
from armdrive.setup.survey import (
    Agree,
    Diagnosis,
    Report,
    compare_settings,
    of_arm,
    of_health,
    of_listening,
    survey_port,
)
from armdrive.storage.arm_lock import hold
from armdrive.transports import opening, ports
from armdrive.transports.address import CanAddress, is_can
from armdrive.transports.can_health import BusHealth


def probe(port: str) -> Report:
    """Open any port and report what it leads to; moves nothing. Raises `LinkError`."""
    require_real_ports()
    report = Report(port)
    if is_can(port):
        survey_bus(report)
        bus = DIALECTS[report.dialect].bus if report.dialect else None
        if bus is not None and bus.hint:
            report.add([note(f"`{_next_command(bus, port)}` {bus.hint}")])
    else:
        survey_port(report, ClosedPort(port))
    return report


# The drives on a CAN bus, the state of the bus, and what differs from the arm file.


# One id, or the first and the last of several.
_IDS = re.compile(r"(\d{1,9})(?:-(\d{1,9}))?", re.ASCII)


def ids_of(text: str) -> tuple[int, ...]:
    """Return the ids of drives that are written `1-16,20`. Raises `BadRequest`."""
    most = max(row.most for row in protocols().values())
    found: set[int] = set()
    for part in text.split(","):
        written = _IDS.fullmatch(part.strip())
        if written is None:
            raise BadRequest(f"ids are written 1-16,20, not {text!r}")
        first, last = int(written[1]), int(written[2] or written[1])
        if not 1 <= first <= last <= most:
            raise BadRequest(f"ids of drives are 1 to {most}, not {text!r}")
        found |= set(range(first, last + 1))
    return tuple(sorted(found))


def only_bus() -> str:
    """Return the only CAN bus that the system knows. Raises `PortUnavailable` for none or more."""
    there = [each.port for each in ports.list_can_ports(ports.list_ports()) if not each.todo]
    if len(there) == 1:
        return there[0]
    listed = f"there are {', '.join(there)}" if there else "no adapter was found"
    raise PortUnavailable(
        f"which bus? {listed}: name it, as in --can slcan:/dev/ttyACM0?bitrate=500000; "
        "`armdrive ports` lists adapters and what each needs"
    )


def survey_bus(
    report: Report,
    config: ArmConfig | None = None,
    ids: Sequence[int] = (),
    agree: Agree | None = None,
) -> Diagnosis:
    """Survey a CAN bus; the findings go to the report.

    `config` is the arm whose drives are expected. `ids` are asked; if empty, the usual ones and
    those of the arm. With `agree`, settings that differ are written if it returns True.
    """
    address = CanAddress.parse(report.port)
    # comparing settings takes the lock itself, so it is held for each look alone
    locked = partial(hold, report.port if config is None else config.name, report.port)
    with locked():
        traffic = listened(address, config)
    report.add(of_listening(traffic, LISTEN_S, _bits_s(address)))
    if traffic.commands:
        return Diagnosis.PROBLEM
    if config is not None and agree is not None:
        # before the drives are asked, so that their settings are reported as written
        compare_settings(config, report, agree)
    known = config.device.ids if config is not None else ()
    ids = ids or sorted({*IDS, *known})
    with locked():
        dialect = config.connection.dialect if config is not None else ""
        found, health, lost = _answers(address, ids, nodes_seen(traffic.passing), dialect)
        report.add(of_health(health, lost))
        for each in found:
            report.add(each.findings(health, config.name if config is not None else "NAME"))
        answered = any(each.there for each in found)
        if not answered:
            report.add([of_nobody(ids, health)])
    counters = ("sent", "received", "refused", "error_frames", "read_errors", "overrun")
    report.more["bus"] = {"state": health.state.value} | {
        name: getattr(health, name) for name in counters
    }
    report.more["drives"] = [view for each in found for view in each.views]
    if config is not None:
        _compare(report, config, found, settings=agree is None)
    else:
        rows = [protocols()[each.protocol] for each in found if each.drives]
        report.more["dialect"] = rows[0].dialect if rows else ""
        if answered:
            report.more["next"] = [_next_command(row, report.port) for row in rows]
    return report.diagnosis if answered else Diagnosis.NO_ARM


def _compare(
    report: Report, config: ArmConfig, found: Sequence[Answers], *, settings: bool
) -> None:
    """Compare the answers with the arm file, and the settings if connecting sets nothing."""
    dialect, ids = config.connection.dialect, config.device.ids
    for each in found:
        row = protocols()[each.protocol]
        if row.dialect == dialect:
            report.add(of_arm(ids, each.there, config.name, dialect))
            report.add(each.of_arm(ids))
            if settings and row.connects and set(ids) <= set(each.there):
                compare_settings(config, report, None)
        elif each.there:
            what = f"these drives speak {row.name}, and the arm file says {dialect}"
            fix = f'dialect = "{row.dialect}" under [connection], if they are this arm\'s drives'
            report.add([problem(what, fix)])


def _next_command(bus: BusTools, port: str) -> str:
    return command_line(*bus.next, "--port", port)


def listened(address: CanAddress, config: ArmConfig | None = None) -> Listened:
    """Return the frames that pass by themselves.

    The adapter does not even acknowledge them if it has a listen-only mode. The heartbeat of the
    arm's own master counts as a command.
    """
    frames, master = frame_scripts(), getattr(config and config.device, "master_id", None)
    look = partial(tools.listen, frames.io, partial(is_command, master=master))
    with closing(opening.open_can_link(str(address.listening()))) as link:
        traffic: Listened = carry_out(frames, look, link, dialog_runner.RealClock())
    return traffic


def _answers(
    address: CanAddress, ids: Sequence[int], seen: SeenNodes, dialect: str
) -> tuple[tuple[Answers, ...], BusHealth, str]:
    """Return the answers, the adapter's state after them, and why the bus was lost if it was."""
    with closing(opening.open_can_link(str(address))) as link:
        try:
            found = ask_bus(link, dialog_runner.RealClock(), ids, seen, dialect)
        except LinkLost as error:
            return (), link.health, str(error).partition("was lost: ")[2]
        return found, link.health, ""


def _bits_s(address: CanAddress) -> int:
    """Return the bit rate, or 0 if the address does not say it."""
    text = address.option("bitrate")
    return int(text) if text.isdecimal() else 0
