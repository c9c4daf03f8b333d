"""The ports and CAN interfaces of this computer, and what is behind one of them.

Listing opens nothing. `probe` opens a port, which can restart the board behind it; what it says
moves no arm of the table of dialects (docs/how-to/finding-the-arm.md). On a CAN bus it only reads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

from armdrive.config.link_model import read_model
from armdrive.connect.target import simulation_forced
from armdrive.dialects.bus import tools
from armdrive.dialects.bus.tools import (
    IDS,
    LISTEN_S,
    Answers,
    BusTools,
    Heard,
    Listened,
    frame_scripts,
    of_nobody,
)
from armdrive.dialog.conversation import Finding, Grade, WrongAnswer, note
from armdrive.errors import ArmError, ArmFileError, PortUnavailable
from armdrive.registry import DIALECTS
from armdrive.setup import dialog_runner, prober
from armdrive.setup.dialog_runner import Clock, carry_out
from armdrive.setup.draft import LinkFile, Surroundings
from armdrive.setup.findings import Expected, findings, of_listening
from armdrive.setup.ports import arm_files, look_at
from armdrive.storage import files as places
from armdrive.text.reading import read_text
from armdrive.transports import can_link
from armdrive.transports import ports as port_lists
from armdrive.transports.address import is_can
from armdrive.transports.can_address import CanAddress
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame


@dataclass(frozen=True, slots=True)
class Candidate:
    """A port or an interface, what is known of it while it is closed, and whether it can open."""

    port: str
    lines: tuple[str, ...] = ()
    openable: bool = True


@dataclass(frozen=True, slots=True)
class Found:
    """What a probe has found, in words; `dialect` is empty where nobody was recognised."""

    port: str
    lines: tuple[str, ...]
    dialect: str = ""
    baud: int | None = None

    @property
    def answers(self) -> dict[str, str]:
        """What it answers of the questions that make an arm file."""
        known = {"connection.port": self.port, "dialect": self.dialect}
        if self.dialect and self.baud:
            known["connection.baud"] = str(self.baud)
        return {key: word for key, word in known.items() if word}


def candidates() -> tuple[Candidate, ...]:
    """Return what an arm may be behind. Opens nothing."""
    ports = port_lists.list_ports()
    serial = tuple(looked_at(each.stable_name or each.device) for each in ports)
    buses = port_lists.list_can_ports(ports)
    return (*serial, *(_bus(each.port, each.description, each.todo) for each in buses))


def looked_at(port: str) -> Candidate:
    """Return what is known of a port that somebody names. Opens nothing."""
    if is_can(port):
        return _bus(port, "a CAN bus", "")
    before = look_at(port, arm_files())
    return Candidate(port, lines_of(before.findings), before.openable)


def _bus(port: str, description: str, todo: str) -> Candidate:
    return Candidate(port, tuple(each for each in (description, todo) if each), not todo)


def probe(port: str) -> Found:
    """Open a port and find out what it leads to; moves nothing. Raises `LinkError`."""
    if simulation_forced():
        raise PortUnavailable("ARMDRIVE_FORCE_SIM is set, so that no real port is opened")
    if is_can(port):
        return _asked(CanAddress.parse(port))
    found = prober.examine_port(port, None)
    dialect = found.identity.dialect if found.identity is not None else ""
    return Found(port, lines_of(findings(found, Expected())), dialect, found.baud)


def _asked(address: CanAddress) -> Found:
    """Listen on a bus, then ask every id who it is, unless somebody else commands its drives."""
    rate = address.option("bitrate")
    heard = listened(address)
    told = of_listening(heard, LISTEN_S, int(rate) if rate.isdecimal() else 0)
    if heard.commands:
        return Found(str(address), lines_of(told))
    with closing(can_link.open_can_link(str(address))) as link:
        answers = ask_bus(link, dialog_runner.RealClock(), IDS, nodes_heard(heard.passing))
        told += [finding for each in answers for finding in each.findings(link.health, "NAME")]
        if not any(each.there for each in answers):
            told.append(of_nobody(IDS, link.health))
    found = next((PROTOCOLS[each.protocol] for each in answers if each.drives), None)
    if found is not None and found.hint:
        told.append(note(found.hint.format(port=address)))
    return Found(str(address), lines_of(told), found.dialect if found is not None else "")


def listened(address: CanAddress, master: int | None = None) -> Listened:
    """Hear what passes, with an adapter that does not even acknowledge where it can be kept.

    `master` is the node of a master whose heartbeat would be a command.
    """
    frames = frame_scripts()
    look = partial(tools.listen, frames.io, partial(is_command, master=master))
    with closing(can_link.open_can_link(str(address.listening()))) as link:
        heard: Listened = carry_out(frames, look, link, dialog_runner.RealClock())
    return heard


def lines_of(findings: tuple[Finding, ...] | list[Finding]) -> tuple[str, ...]:
    """Return findings as people read them, what mends each behind it."""
    return tuple(
        f"{'' if each.grade is Grade.OK else each.grade.value + ': '}{each.what}"
        + (f" - {each.mend}" if each.mend else "")
        for each in findings
    )


def surroundings(given: dict[str, str]) -> Surroundings:
    """Return what the interview may know of this computer. Opens nothing."""
    found = port_lists.list_ports()
    ports = tuple(each.stable_name or each.device for each in found)
    buses = tuple(each.port for each in port_lists.list_can_ports(found))
    arms = tuple(path.stem for path in sorted(places.arm_files().glob("*.toml")))
    return Surroundings(arms, ports, read_links, given, buses)


def read_links(path: str) -> LinkFile:
    """Read a model file that somebody names. Raises `WrongAnswer`."""
    place = Path(path).expanduser()
    try:
        return LinkFile(
            path, read_text(place, "the model file", ArmFileError), read_model(place).chain
        )
    except (ArmError, RuntimeError) as error:
        raise WrongAnswer(str(error)) from None


# Which protocols a CAN bus is asked in, in which order, and which ids without harm.
#
# A protocol is asked first whose questions do nothing to drives of any other: reading CANopen's
# objects by SDO does nothing to MKS drives, whatever their ids. MKS drives are asked by ids of one
# frame, and from 128 on those are CANopen's: SYNC, process data, orders to drives. So where a node
# was heard or has answered, no id is asked in another protocol that its own does not leave free.

PROTOCOLS: Mapping[str, BusTools] = MappingProxyType(
    {
        bus.name: bus
        for bus in sorted(
            (row.bus for row in DIALECTS.values() if row.bus is not None),
            key=lambda bus: not bus.harmless,
        )
    }
)
"""Every protocol, in the order in which a bus is asked where no arm file says what it speaks."""


def is_command(frame: Frame, master: int | None = None) -> bool:
    """Tell whether a frame can be nothing but a request to a drive, in any protocol.

    `master` is the node of a master whose heartbeat would be one.
    """
    rows = PROTOCOLS.values()
    if any(row.reads_answer(frame) for row in rows):
        return False
    return any(row.reads_command(frame, master) for row in rows)


def nodes_heard(frames: Sequence[Frame]) -> Heard:
    """Return who was heard in frames that passed, and what state each said it is in."""
    return {node: state for row in PROTOCOLS.values() for node, state in row.heard(frames).items()}


def ask_bus(
    link: Link,
    clock: Clock,
    ids: Sequence[int],
    heard: Heard = MappingProxyType({}),
    dialect: str = "",
) -> tuple[Answers, ...]:
    """Ask a bus who is on it. That of an arm file is asked in another protocol if nobody answers.

    Raises `LinkLost`.
    """
    rows = sorted(PROTOCOLS.values(), key=lambda row: row.dialect != dialect)
    answers: list[Answers] = []
    for row in rows:
        if dialect and any(each.there for each in answers):
            break
        chosen = [each for each in spared(ids, answers, heard) if each <= row.most]
        if chosen or heard:
            scripts = row.scripts(chosen)
            ask = partial(row.ask, scripts.io, chosen, heard)
            answers.append(carry_out(scripts, ask, link, clock))
    return tuple(answers)


def spared(ids: Sequence[int], answers: Sequence[Answers], heard: Heard) -> list[int]:
    """Leave out the ids that mean something to nodes that were heard or have answered."""
    there = {each.protocol for each in answers if each.there}
    free = [
        row.leaves_free
        for row in PROTOCOLS.values()
        if row.leaves_free is not None and (heard or row.name in there)
    ]
    return [each for each in ids if all(each <= most for most in free)]
