"""The ports and CAN interfaces of this computer, and what is behind one of them.

Listing opens nothing. `probe` opens a port, which can restart the board behind it; what it says
moves no arm of the table of dialects (docs/finding-the-arm.md). On a CAN bus it only reads.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.connecting import simulation_forced
from armdrive.doctor.findings import Finding, Grade, note
from armdrive.errors import PortUnavailable
from armdrive.transports.can_address import CanAddress, is_can

if TYPE_CHECKING:
    from armdrive.commissioning.acts import Ask
    from armdrive.interview.draft import LinkFile, Surroundings


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
    from armdrive.transports.can_ports import list_can_ports
    from armdrive.transports.ports import list_ports

    ports = list_ports()
    serial = tuple(looked_at(each.stable_name or each.device) for each in ports)
    buses = list_can_ports(ports)
    return (*serial, *(_bus(each.port, each.description, each.todo) for each in buses))


def looked_at(port: str) -> Candidate:
    """Return what is known of a port that somebody names. Opens nothing."""
    from armdrive.doctor.before import look_at
    from armdrive.doctor.owners import arm_files

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
    from armdrive.doctor.after import Expected, findings
    from armdrive.doctor.carrying import examine_port

    found = examine_port(port, None)
    dialect = found.identity.dialect if found.identity is not None else ""
    return Found(port, lines_of(findings(found, Expected())), dialect, found.baud)


def _asked(address: CanAddress) -> Found:
    """Listen on a bus, then ask every id who it is, unless somebody else commands its drives."""
    from armdrive.commissioning.carrier import Carrier
    from armdrive.doctor.can_asking import PROTOCOLS, ask_bus
    from armdrive.doctor.can_findings import of_listening, of_nobody
    from armdrive.doctor.can_survey import IDS, LISTEN_S, listen
    from armdrive.doctor.canopen_survey import heard_nodes
    from armdrive.doctor.carrying import RealClock
    from armdrive.transports.can_link import open_can_link

    rate = address.option("bitrate")
    with closing(open_can_link(str(address.listening()))) as link:
        heard = Carrier(link, RealClock(), Nobody()).run(listen())
    told = of_listening(heard, LISTEN_S, int(rate) if rate.isdecimal() else 0)
    if heard.commands:
        return Found(str(address), lines_of(told))
    with closing(open_can_link(str(address))) as link:
        answers = ask_bus(link, RealClock(), IDS, heard_nodes(heard.passing))
        told += [finding for each in answers for finding in each.findings(link.health, "NAME")]
        if not any(each.there for each in answers):
            told.append(of_nobody(IDS, link.health))
    found = next((PROTOCOLS[each.protocol] for each in answers if each.drives), None)
    if found is not None and found.hint:
        told.append(note(found.hint.format(port=address)))
    return Found(str(address), lines_of(told), found.dialect if found is not None else "")


class Nobody:
    """A survey asks no person anything."""

    def tell(self, text: str) -> None:
        """Say nothing."""

    def watch(self, motor: int) -> None:
        """See nothing."""

    def answer(self, asked: Ask) -> object:
        """Refuse: there is no question in a survey."""
        raise NotImplementedError(asked.question.words)


def lines_of(findings: tuple[Finding, ...] | list[Finding]) -> tuple[str, ...]:
    """Return findings as people read them, what mends each behind it."""
    return tuple(
        f"{'' if each.grade is Grade.OK else each.grade.value + ': '}{each.what}"
        + (f" - {each.mend}" if each.mend else "")
        for each in findings
    )


def surroundings(given: dict[str, str]) -> Surroundings:
    """Return what the interview may know of this computer. Opens nothing."""
    from armdrive import places
    from armdrive.interview.draft import Surroundings
    from armdrive.transports.can_ports import list_can_ports
    from armdrive.transports.ports import list_ports

    found = list_ports()
    ports = tuple(each.stable_name or each.device for each in found)
    buses = tuple(each.port for each in list_can_ports(found))
    arms = tuple(path.stem for path in sorted(places.arm_files().glob("*.toml")))
    return Surroundings(arms, ports, read_links, frozenset(given), buses)


def read_links(path: str) -> LinkFile:
    """Read a model file that somebody names. Raises `WrongAnswer`."""
    from pathlib import Path

    from armdrive.errors import ArmError, ArmFileError
    from armdrive.interview.draft import LinkFile
    from armdrive.interview.readers import WrongAnswer
    from armdrive.modelfile import read_model
    from armdrive.textfile import read_text

    place = Path(path).expanduser()
    try:
        return LinkFile(
            path, read_text(place, "the model file", ArmFileError), read_model(place).chain
        )
    except (ArmError, RuntimeError) as error:
        raise WrongAnswer(str(error)) from None
